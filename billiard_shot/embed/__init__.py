"""The compiled core in other programs: scenes for pages and C, and the JavaScript module."""

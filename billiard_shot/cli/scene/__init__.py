"""Commands about bundled scenes and scene files, a module a command."""

"""
The compiler: makes of the entries a library for each target, and a description of it.

It runs where the package is built, never where it is used; it needs the extra `build`.
"""

"""Commands that fit scenes to recordings, a module a command."""

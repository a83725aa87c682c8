"""The rules of games, a module a game; each has a constant GAME."""

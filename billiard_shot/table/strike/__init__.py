"""The strike: where the cue has room, and its impact with the ball."""

"""What a simulation of a table consists of: numbers, geometry, balls, the cue."""

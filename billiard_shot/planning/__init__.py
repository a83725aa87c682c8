"""Search for the stroke most likely to reach a target, under noise and a robot's limits."""

"""Which stroke to play: strokes searched for a target, under noise and a robot's limits."""

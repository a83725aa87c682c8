"""One ball: it slides, rolls, spins in place, flies, bounces; when it meets the table."""

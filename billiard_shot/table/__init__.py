"""What a ball does between strokes: slide, roll, spin in place, fly, bounce, rest."""

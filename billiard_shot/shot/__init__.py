"""From a stroke to what the ball does: contact geometry, impact, motion on the table."""

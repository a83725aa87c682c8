"""What accuracy and effects cost in a scene."""

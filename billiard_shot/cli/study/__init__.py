"""`billiard-shot study STUDY`: what accuracy and effects cost in a scene."""

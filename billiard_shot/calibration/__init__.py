"""Recorded shots, and the numbers of a scene that follow from them."""

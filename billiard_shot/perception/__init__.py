"""Where balls lie, from the detections of a camera: tracks, sightings, and layouts. No ROS."""

"""ROS 2 nodes: each a thin adapter that converts, calls the library and converts back."""

"""Players that decide, a module an agent; each has a function `make`."""

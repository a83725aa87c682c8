"""Studies: the cost of accuracy and effects, hard cases, and differences between the laws."""

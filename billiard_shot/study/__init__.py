"""What accuracy and effects cost, where solvers break, how the laws differ."""

"""What balls do to each other and to cushions: two bodies, or many at once."""

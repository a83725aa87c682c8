"""From films and pictures of a table to places of balls: classical vision, without a network."""

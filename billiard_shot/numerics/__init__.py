"""Roots, small linear algebra, contact frames and rounding, without any physics."""

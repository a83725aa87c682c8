"""Roots, small linear algebra, contact frames and rounding: numbers without any physics."""

"""Tolerances that only rounding asks for; those that steer a method are beside the method."""

SUM = 1e-15
"""Of numbers that were added up, relative to the largest."""

COUPLING = 8 * 2.0**-52
"""Of the coupling of two contacts in W, relative to the mean of the contacts' own responses."""

PLACE = 1e-9
"""Of the places of bodies, which people and files give to so many digits [m]."""

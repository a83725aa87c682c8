"""Tolerances for rounding errors. The tolerances of a method stand in its module."""

SUM = 1e-15
"""Of a sum, relative to its largest term."""

COUPLING = 8 * 2.0**-52
"""Of the coupling of two contacts in W, relative to the geometric mean of their own responses."""

PLACE = 1e-9
"""Of positions of bodies [m], which users and files give with a limited number of digits."""

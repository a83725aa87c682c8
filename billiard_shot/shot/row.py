"""Columns of the row of numbers that compiled code fills in for one shot."""

VELOCITY, SPIN, REST = slice(0, 3), slice(3, 6), slice(6, 9)  # m/s, rad/s, m
CUE_SPEED = 9  # m/s along the stroke
DURATION = 10  # s from the end of the strike to rest
ERROR = 11  # m, estimate
LOSS = slice(12, 16)  # J: tip restitution, tip friction, table restitution, table friction
IMPULSE = slice(16, 22)  # N s: of tip and table, normal and two tangential each
STATUS, PHASES, EVALUATIONS, SEGMENTS = 22, 23, 24, 25
AXES = slice(26, 44)  # of tip and table, (2, 3, 3): normal and two tangents as rows
COLUMNS = 44

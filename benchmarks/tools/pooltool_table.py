"""pooltool's default table, balls and parameters as a scene of this library."""

import math

import numpy as np

from billiard_shot import BallState, Scene

LENGTH, WIDTH, RADIUS = 1.9812, 0.9906, 0.028575
HEIGHT = 0.64  # of the cushions' noses, in ball diameters


def pocket(mouth, turn_deg, jaw, depth, radius, inset, corner):
    """
    Pocket of the same shape, for a ball that touches a nose at its height.

    In pooltool a ball touches a nose if its centre is a radius away from it. Here a ball touches
    if the surfaces do, `inset` nearer. So noses lie nearer to the middle, and jaws are rounder.
    """
    tangent = math.tan(0.5 * math.radians(turn_deg))
    if corner:  # along a nose, from the corner to where its straight part ends
        end = math.sqrt(0.5) * mouth + jaw * tangent - inset
        mouth = (end - (jaw + inset) * tangent) / math.sqrt(0.5)
        beyond = depth + math.sqrt(2.0) * inset + 0.5 * mouth
    else:
        mouth = 2.0 * (0.5 * mouth + jaw * tangent - (jaw + inset) * tangent)
        beyond = depth + inset
    return {
        'mouth': mouth,
        'cut_deg': 180.0 - turn_deg,
        'jaw_radius': jaw + inset,
        'shelf': beyond - radius,
        'radius': radius,
    }


def scene(cushion='han', flight='off', duration=0.0):
    """
    Scene with pooltool's numbers.

    Flight is off because pooltool does not model it: there friction between balls never lifts a
    ball. The friction between balls is a little lower, because pooltool takes the speed at which
    they part, e v, for their normal impulse per mass, which is (1 + e) v / 2. Impacts take no time
    in pooltool, nor here if `duration` is 0 s, those with cushions included.
    """
    weaker = 0.95 / (0.5 * (1.0 + 0.95))
    above = (2.0 * HEIGHT - 1.0) * RADIUS
    inset = RADIUS - math.sqrt(RADIUS**2 - above**2)
    cushions = {'model': cushion, 'height': HEIGHT, **({} if duration else {'duration': 0.0})}
    return Scene.from_dict(
        {
            'ball': {'mass': 0.170097, 'radius': RADIUS},
            'cue': {'mass': 0.567},
            'contacts': {
                'cue_ball': {'restitution': 0.75, 'friction': 0.6, 'stiffness': 1.5},
                'ball_table': {'restitution': 0.5, 'friction': 0.2, 'stiffness': 1.0},
                'ball_ball': {
                    'restitution': 0.95,
                    'friction_fast': 0.009951 * weaker,
                    'friction_slow': 0.108 * weaker,
                    'friction_decay': 1.088,
                    'duration': duration,
                },
            },
            'cloth': {
                'sliding_friction': 0.2,
                'rolling_resistance': 0.01,
                'gravity': 9.81,
                'spin_deceleration': 2.5 * 4.0 / 9.0 * 9.81,
            },
            'effects': {'flight': flight},
            'table': {
                'length': LENGTH - 2.0 * inset,
                'width': WIDTH - 2.0 * inset,
                'cushion': cushions,
                'corner': pocket(0.118, 45.0 - 5.3, 0.02095, 0.0417, 0.062, inset, True),
                'side': pocket(0.137, 90.0 - 7.14, 0.00795, 0.0685, 0.0645, inset, False),
            },
        }
    )


def turned(vector):
    """Vector in the frame `table`: its x is along the table, that of pooltool across."""
    x, y, z = vector
    return np.array([y, -x, z])


def states(given):
    """States of balls as pooltool wrote them."""
    centre = np.array([0.5 * WIDTH, 0.5 * LENGTH, 0.0])
    return {
        name: BallState(turned(np.subtract(rvw[0], centre)), turned(rvw[1]), turned(rvw[2]))
        for name, rvw in given.items()
    }

"""The hard cases: collisions at the limits of the input, and how other solvers fail there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.status import Status
from studies.collisions import (
    block,
    Collision,
    cradle,
    PAPER_BALL_MASS,
    stacked,
    strike_of,
    wedge,
)

MASSE_STROKE = (-2, -1, 12), (4, 0, -16)
SLANTED = (-0.8, -0.3, 0.5), (0.9, 0.1, -0.4)
ENDED = (Status.OK, Status.INFINITE_SEQUENCE)  # the sequence may be endless; it is ended


@dataclass(frozen=True, slots=True)
class Family:
    """
    Cases of one kind.

    Attributes
    ----------
    name : str
    breaks : str
        How other solvers fail.
    members : mapping of str to Collision
    status : tuple of Status
        Statuses with which a solution may end.
    sensitive : bool
        Whether the answer depends steeply on the numbers. Its sensitivity is then not checked.
    hopeless : frozenset of str
        Members that may end in BUDGET_EXCEEDED: in time, finite, and without a gain of energy.

    """

    name: str
    breaks: str
    members: Mapping[str, Collision]
    status: tuple[Status, ...] = (Status.OK,)
    sensitive: bool = False
    hopeless: frozenset[str] = frozenset()


def families() -> Iterator[Family]:
    """All hard cases; both laws (bistiffness, energetic) solve each of them."""
    yield from _coefficients()
    yield from _ratios()
    yield from _directions()
    yield from _slips()
    yield from _sequences()
    yield from _many()


def _coefficients() -> Iterator[Family]:
    ends = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]
    members: dict[str, Collision] = {}
    for e in ends:
        name = f'e = {e[0]:g} and {e[1]:g}'
        members[f'{name}, stacked'] = stacked(restitution=e)
        members[f'{name}, slanted'] = strike_of(*SLANTED, restitution=e)
        members[f'{name}, masse'] = strike_of(*MASSE_STROKE, restitution=e)
        members[f'{name}, Hertz'] = strike_of(*SLANTED, restitution=e, exponent=1.5)
    yield Family(
        'restitution 0 or 1',
        'e = 0 divides by zero where restitution is a stiffness; bodies that stay pressed '
        'together close and part without end; e = 1 gains energy in fixed steps',
        members,
        ENDED,
    )
    members = {}
    for mu in [(0.0, 0.0), (0.0, 10.0), (10.0, 0.0), (10.0, 10.0)]:
        name = f'mu = {mu[0]:g} and {mu[1]:g}'
        members[f'{name}, slanted'] = strike_of(*SLANTED, friction=mu)
        members[f'{name}, masse'] = strike_of(*MASSE_STROKE, friction=mu)
        members[f'{name}, light end'] = strike_of(*SLANTED, friction=mu, end_mass=0.005)
    yield Family(
        'friction 0 or 10',
        'at mu = 0 the directions of sliding are undefined; at mu = 10 contacts jam and explicit '
        'friction oscillates',
        members,
    )


def _masses(ratio: float) -> tuple[float, float]:
    """Masses of cue and ball [kg] in a ratio; the heavier one has the mass of the paper's ball."""
    return PAPER_BALL_MASS * min(ratio, 1.0), PAPER_BALL_MASS / max(ratio, 1.0)


def _ratios() -> Iterator[Family]:
    members: dict[str, Collision] = {}
    for power in (-8, -4, 4, 8):
        members[f'1e{power}, stacked'] = stacked(ratio=10.0**power)
        members[f'1e{power}, slanted'] = strike_of(*SLANTED, ratio=10.0**power)
        members[f'1e{power}, masse'] = strike_of(*MASSE_STROKE, ratio=10.0**power)
    yield Family(
        'stiffness ratio',
        'one spring oscillates up to 10,000 times while the other is compressed once: explicit '
        'steps must resolve each oscillation, implicit steps lose energy',
        members,
        ENDED,
        hopeless=frozenset(name for name in members if name.startswith(('1e-8', '1e8'))),
    )
    members = {}
    for power in (-6, -3, 3, 6):
        mass = 10.0**power
        members[f'1e{power}, stacked'] = stacked(masses=(mass, 1.0))
        members[f'1e{power}, slanted'] = strike_of(*SLANTED, masses=_masses(mass))
        members[f'1e{power}, masse'] = strike_of(*MASSE_STROKE, masses=_masses(mass))
    yield Family(
        'mass ratio',
        'a light body hits a heavy one hundreds of times; velocities cancel to the last digit',
        members,
        ENDED,
        sensitive=True,
        hopeless=frozenset({'1e6, stacked'}),
    )
    yield Family(
        'speed',
        'with absolute tolerances and velocity thresholds, a solver treats slow strokes as rest, '
        'and needs too many steps for fast ones',
        {
            f'1e{power} m/s, {name}': strike_of(n, c, speed=10.0**power)
            for power in (-9, -3, 0, 3)
            for name, n, c in (('slanted', *SLANTED), ('masse', *MASSE_STROKE))
        },
    )


def _directions() -> Iterator[Family]:
    members: dict[str, Collision] = {}
    for power in (3, 6, 9, 12):
        cosine = 10.0**-power
        sine = math.sqrt(1.0 - cosine * cosine)
        members[f'level, side, n.c = -1e-{power}'] = strike_of((-cosine, -sine, 0), (1, 0, 0))
        members[f'level, top, n.c = -1e-{power}'] = strike_of((-cosine, 0, sine), (1, 0, 0))
        c, up = np.array([1, 0, -1]) / math.sqrt(2), np.array([1, 0, 1]) / math.sqrt(2)
        across = 0.8 * up + 0.6 * np.array([0, 1, 0])
        members[f'slanted, n.c = -1e-{power}'] = strike_of(-cosine * c + sine * across, c)
    yield Family(
        'grazing strokes',
        'slip is up to 1e12 times the approach speed; friction may press the ball down harder '
        'than the tip does (a wedge)',
        members,
        ENDED,
        hopeless=frozenset(name for name in members if 'top' in name),
    )
    members = {}
    for height in (1e-3, 1e-6, 1e-12, 0.0, -1e-12, -1e-6):
        members[f'n.z = {height:g}, level'] = strike_of((-0.9, -0.3, height), (1, 0, 0))
        members[f'n.z = {height:g}, down'] = strike_of((-0.9, -0.3, height), (1, 0, -0.2))
    yield Family(
        'equator',
        'if the sign of n.z decides whether the table takes part, a rounding error decides it; '
        'the motion must decide',
        members,
        ENDED,
    )
    members = {
        'vertical, through the centre': strike_of((0, 0, 1), (0, 0, -1)),
        'vertical, off by 1e-10': strike_of((1e-10, 0, 1), (0, 0, -1)),
        'vertical, off by 1e-5': strike_of((1e-5, 2e-5, 1), (0, 0, -1)),
    }
    for degrees in (0, 30, 60, 89):
        c = np.array([math.cos(math.radians(degrees)), 0.0, -math.sin(math.radians(degrees))])
        members[f'c = -n, {degrees} degrees down'] = strike_of(-c, c)
        members[f'c = -n, {degrees} degrees down, light end'] = strike_of(-c, c, end_mass=0.005)
    yield Family(
        'jam and centre hits',
        'no contact slips at the start, or ever: the direction of slip is 0/0',
        members,
    )


def _slips() -> Iterator[Family]:
    def reversing(tilt: float) -> Collision:
        """Strike with a light cue, which the ball throws back while it slips."""
        return strike_of(
            (-1, -0.5, tilt),
            (1, 0, 0),
            masses=(0.3 * PAPER_BALL_MASS, PAPER_BALL_MASS),
            friction=(0.02, 0.15),
            restitution=(1.0, 0.5),
        )

    yield Family(
        'slip reversal',
        'the slip passes through zero without stopping; a tilt of 1e-14 makes it pass beside '
        'zero instead, where its direction turns within 1e-14 of the stroke',
        {f'out of plane by {tilt:g}': reversing(tilt) for tilt in (0.0, 1e-14, 1e-10, 1e-6)},
        ENDED,
    )
    yield Family(
        'slip onset from stick',
        'the direction of slip is undefined at the instant of slip onset, and its equation is '
        'stiff afterwards',
        {
            'at the tip': strike_of((-0.85, -0.15, 0.5), (1, 0, -0.3), end_mass=0.03),
            'at the cloth': strike_of(
                (0.5, -0.5, 1.6), (-0.4, -0.6, -1.2), friction=(0.51, 0.3), end_mass=0.034
            ),
            'at both': strike_of((0.0, 0.3, 1.2), (-0.3, -0.7, -0.7), friction=(0.49, 0.62)),
        },
    )


def _sequences() -> Iterator[Family]:
    yield Family(
        'simultaneous events',
        'the order in which events at the same instant are handled changes the answer',
        {
            'two contacts alike': wedge(),
            'two contacts alike, e = 0': wedge(restitution=0.0),
            'two contacts alike, e = 1': wedge(restitution=1.0),
            'two contacts alike, friction': wedge(friction=0.3),
            'two contacts alike, jammed by friction': wedge(friction=10.0),
            'four corners': block((0.0, 0.0, -1.0)),
            'four corners, sliding': block((0.3, 0.1, -1.0)),
            'four corners, turning': block((2.0, -1.0, -0.5), (0.1, -0.2, 0.3)),
            'four corners, mu = 10': block((2.0, -1.0, -0.5), (0.1, -0.2, 0.3), friction=10.0),
        },
        ENDED,
    )
    yield Family(
        'end and reactivation at once',
        'law energetic is discontinuous here: a spring just reaches, or just misses, the energy '
        'at which its contact ends (law bistiffness is continuous)',
        {
            f'k2/k1 = {ratio}': stacked(ratio=ratio)
            for ratio in (1.7023750075, 2.1250675834, 23.2114207656)
        },
        sensitive=True,
    )
    yield Family(
        'infinite sequences',
        'bodies that are pressed together part and meet infinitely often: an event loop does not '
        'end',
        {
            'heavy on light': stacked((100.0, 1.0), (0.9, 0.5), 0.1),
            'heavier on light': stacked((1000.0, 1.0), (0.5, 0.3), 0.01),
            'plastic': stacked((1.0, 1.0), (0.0, 0.0), 1.0),
        },
        ENDED,
    )
    members: dict[str, Collision] = {}
    n, c = (0.2, 0.1, 1.0), (0.3, 0.0, -1.0)
    for ratio in (1e2, 1e3, 1e4):
        masses = _masses(ratio)
        members[f'cue {ratio:g} times the ball'] = strike_of(n, c, masses=masses)
        members[f'cue {ratio:g} times the ball, e = .9'] = strike_of(
            n, c, masses=masses, restitution=(0.9, 0.9)
        )
    yield Family(
        'jammed cue',
        'a heavy cue presses the ball onto the table through hundreds of states',
        members,
        ENDED,
        sensitive=True,
    )


def _many() -> Iterator[Family]:
    members: dict[str, Collision] = {}
    for count in (2, 3, 5, 10, 20, 50):
        members[f'{count} balls'] = cradle(count)
        members[f'{count} balls, Hertz'] = cradle(count, exponent=1.5)
        members[f'{count} balls, e = .9'] = cradle(count, restitution=0.9)
        members[f'{count} balls, e = 0'] = cradle(count, restitution=0.0)
    yield Family(
        "Newton's cradle",
        'if the pairs are resolved one after the other, the answer depends on the order; with e = '
        '0 the pairs part and meet infinitely often',
        members,
        ENDED,
        hopeless=frozenset({'50 balls, e = 0'}),
    )

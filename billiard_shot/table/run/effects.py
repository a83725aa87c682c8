"""Effects on the table: what is simulated where the motion calls for it, a gate each."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import combinations
import math
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.scene import Effects, Scene
from billiard_shot.table.model.geometry import BallClothParams, GATE_OFF, GATE_ON, TableParams
from billiard_shot.table.model.motion import FLIGHT, ROLL, SLIDE
from billiard_shot.table.run.layout import ball_cloth_params, table_params
from billiard_shot.table.run.results import EventKind, TableEvent, TableRun

AUTO, OFF, ON = 'auto', 'off', 'on'
JAW = 'jaw of'
TOGETHER = 'the ball reaches what is near during the strike'
N = TypeVar('N', bound=tuple[Any, ...])
C = TypeVar('C', bound='EffectContext')
Verdict: TypeAlias = tuple[bool, str]
"""Whether an effect was simulated, and why or why not."""


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect in one shot; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str
    called_for: bool  # whether scene, stroke and motion call for it; the scene may force it off


@dataclass(frozen=True, slots=True)
class EffectContext:
    """What a gate decides by: scene and motion. The layer `shot` adds the stroke."""

    scene: Scene
    velocity: NDArray[np.float64]  # of the ball that is struck, at first (3,) [m/s]
    run: TableRun  # of all balls, the struck one first
    struck_together: bool  # whether other balls or a cushion took part in the strike

    def events(self, *kinds: EventKind) -> list[TableEvent]:
        """Events of some kinds on the table, in the order of time."""
        return [event for event in self.run.events if event.kind in kinds]


@dataclass(frozen=True, slots=True, eq=False)
class EffectGate:
    """
    An effect: its name, how a setting changes numbers, and when it is simulated.

    Attributes
    ----------
    name : str
        The field of `scene.Effects`.
    condition : str
        What it takes to be simulated, in a few words.
    without : str
        What happens if it is off, in a sentence.
    evaluate : callable
        Says of an `EffectContext` whether the effect was simulated, and what decided.
    off : mapping of str to object
        What the setting `off` changes in the numbers, by their names: a value, or a function of
        the number as it was.
    on : mapping of str to object, optional
        The same of the setting `on`. None where there is nothing to decide: the effect is a part
        of the equations, and vanishes by itself.
    tells_without : bool
        Whether a shot without the effect tells, too, whether it calls for it.

    """

    name: str
    condition: str
    without: str
    evaluate: Callable[[Any], Verdict]
    off: Mapping[str, Any] = field(default_factory=dict)
    on: Mapping[str, Any] | None = None
    tells_without: bool = False


def gate(
    condition: str, without: str, **rest: Any
) -> Callable[[Callable[[Any], Verdict]], EffectGate]:
    """Make a function the gate of the effect that has its name; arguments as of `EffectGate`."""
    return lambda function: EffectGate(function.__name__, condition, without, function, **rest)


def apply_overrides(numbers: N, gates: Iterable[EffectGate], effects: Effects) -> N:
    """Return numbers (a named tuple) as settings change those of them that the tuple has."""
    for each in gates:
        changes = {OFF: each.off, ON: each.on}.get(getattr(effects, each.name)) or {}
        for name in changes.keys() & set(numbers._fields):  # type: ignore[attr-defined]
            value = changes[name]
            value = value(getattr(numbers, name)) if callable(value) else value
            numbers = numbers._replace(**{name: value})  # type: ignore[attr-defined]
    return numbers


def report(gate: EffectGate, context: C, again: Callable[[Scene], C]) -> Effect:
    """
    Say what became of an effect in a shot.

    Parameters
    ----------
    gate : EffectGate
    context : EffectContext
        Of the shot.
    again : callable
        Predicts the same in another scene: in this one, but with the effect set to `auto` where
        the scene forces it on or off.

    """
    simulated, reason = gate.evaluate(context)
    setting = getattr(context.scene.effects, gate.name)
    if setting == AUTO or (setting == ON and gate.on is None):
        return Effect(gate.name, simulated, reason, simulated)
    effects = replace(context.scene.effects, **{gate.name: AUTO})
    if not gate.tells_without:
        context = again(replace(context.scene, effects=effects))
    called_for, reason = gate.evaluate(context)
    if setting == ON:
        return Effect(gate.name, simulated, f'the scene turns it on; {reason}', called_for)
    word = 'it would be simulated' if called_for else 'nothing calls for it either'
    return Effect(gate.name, False, f'the scene turns it off; {word}: {reason}', called_for)


# Above the cloth.
@gate(
    'a ball leaves the cloth, by more than the tolerance',
    'the ball is put back on the cloth with its horizontal motion kept',
    off={'flight_gate': GATE_OFF},
    on={'flight_gate': GATE_ON},
)
def flight(shot: EffectContext) -> Verdict:
    """Look for free falls, from the strike on or after impacts."""
    up, balls = float(shot.velocity[2]), shot.run.balls
    rise = f'the ball rises by {_rise(shot, up)}'
    if up > 0.0 and _flies(balls[shot.run.names[0]].rows[:1]):
        return True, rise
    if fliers := [name for name, ball in balls.items() if _flies(ball.rows)]:
        return True, f'in an impact, a ball leaves the cloth: {", ".join(fliers)}'
    if up > 0.0:
        return False, f'too small to resolve within the tolerance: {rise}'
    return False, 'the ball does not leave the cloth'


@gate(
    'a ball that has flown leaves the cloth again, by more than the tolerance',
    'a ball stays down where it first lands',
    off={'cloth_restitution': 0.0},
    on={'bounce_gate': GATE_ON},
)
def bounce(shot: EffectContext) -> Verdict:
    """Count bounces."""
    balls = shot.run.balls.values()
    bounces = sum(event.kind == EventKind.BOUNCE for ball in balls for event in ball.events)
    if bounces:
        return True, f'bounces until those that follow are too small: {bounces}'
    if not any(_flies(ball.rows) for ball in balls):
        return False, 'there is no flight'
    again = shot.scene.contacts.ball_table.restitution * max(float(shot.velocity[2]), 0.0)
    rise = f'the ball rises by {_rise(shot, again)} after it first lands'
    return False, f'too small to resolve within the tolerance: {rise}'


def _flies(rows: NDArray[np.void]) -> bool:
    """Whether a ball falls freely in some of its segments."""
    return bool(((rows['motion'] == FLIGHT) & (rows['acceleration'][:, 2] != 0.0)).any())


def _rise(shot: EffectContext, up: float) -> str:
    return f'{1e3 * 0.5 * up * up / shot.scene.cloth.gravity:.3g} mm'


# On the cloth.
@gate(
    'a ball slips on the cloth',
    'a ball rolls at once, as it would at the end of its slide',
    off={'sliding_friction': math.inf},
)
def slide(shot: EffectContext) -> Verdict:
    """Look for balls that slide."""
    return _balls_that('slip on the cloth', shot, lambda rows: rows['motion'] == SLIDE)


@gate(
    'a ball comes to roll',
    'a rolling ball meets no resistance, and never rests',
    off={'rolling_resistance': 0.0, 'rolling_rise': 0.0},
)
def roll(shot: EffectContext) -> Verdict:
    """Look for balls that roll."""
    return _balls_that('come to roll', shot, lambda rows: rows['motion'] == ROLL)


@gate(
    'a ball spins about the vertical',
    'spin about the vertical stays, and a ball that has any never rests',
    off={'spin_deceleration': 0.0},
)
def spin_decay(shot: EffectContext) -> Verdict:
    """Look for spin about the vertical."""
    verdict = _balls_that('spin about the vertical', shot, lambda rows: rows['spin'][:, 2])
    if verdict[0] and shot.scene.cloth.spin_deceleration == 0.0:
        return False, 'the cloth does not slow spin about the vertical'
    return verdict


def _balls_that(
    do: str, shot: EffectContext, doing: Callable[[NDArray[np.void]], NDArray[Any]]
) -> Verdict:
    """Say which balls do something in some of their segments, or that none does."""
    names = [name for name, ball in shot.run.balls.items() if np.any(doing(ball.rows))]
    if names:
        return True, f'balls that {do}: {", ".join(names)}'
    return False, f'no ball that would {do}'


# Cushions and pockets.
@gate(
    'the path of a ball reaches a cushion',
    'the cloth is unbounded, and there are no pockets',
    off={'length': math.inf, 'pockets': False},
)
def cushion(shot: EffectContext) -> Verdict:
    """Look for impacts with cushions."""
    if shot.scene.table is None:
        return False, 'the scene has no table: the cloth is endless'
    if shot.struck_together and not _balls_in_strike(shot):
        return True, TOGETHER
    events = [each for each in shot.events(EventKind.CUSHION) if not each.place.startswith(JAW)]
    simulated, reason = _count(events, 'a cushion')
    in_the_air = sum(event.position[2] > shot.scene.ball.radius for event in events)
    if shot.scene.table.cushion.model == 'han' and in_the_air:
        reason += f'; {in_the_air} in the air, where `han` does not hold: with the default model'
    return simulated, reason


@gate(
    'the path of a ball reaches a pocket',
    'the cushions go on where the pockets would be',
    off={'pockets': False},
    on={'pocket_gate': GATE_ON},
)
def pocket(shot: EffectContext) -> Verdict:
    """Look for balls that fall, and for impacts with jaws."""
    table = shot.scene.table
    if table is None or not table.pockets:
        return False, f'the {"scene has no table" if table is None else "table has none"}'
    if fallen := [f'{event.balls[0]} in {event.place}' for event in shot.events(EventKind.POCKET)]:
        return True, f'balls that fall: {", ".join(fallen)}'
    jaws = [event for event in shot.events(EventKind.CUSHION) if event.place.startswith(JAW)]
    return _count(jaws, 'a jaw of a pocket')


# Other balls.
@gate(
    'the path of a ball reaches another one',
    'balls go through each other',
    off={'pair_gate': GATE_OFF},
    on={'pair_gate': GATE_ON},
)
def ball_ball(shot: EffectContext) -> Verdict:
    """Look for balls that meet."""
    if len(shot.run.balls) == 1:
        return False, 'there is no other ball'
    if _balls_in_strike(shot):
        return True, TOGETHER
    return _count(_meetings(shot), 'another ball')


@gate(
    'balls meet with slip, and have friction',
    'balls that meet are smooth: no throw, no spin from one to the other',
    off={'friction_fast': 0.0, 'friction_slow': 0.0},
)
def throw(shot: EffectContext) -> Verdict:
    """Look for slip of balls that meet."""
    balls = shot.scene.contacts.ball_ball
    if balls.friction_fast == balls.friction_slow == 0.0:
        return False, 'balls have no friction on each other'
    if _balls_in_strike(shot):
        return True, TOGETHER
    slip = max((_slip(shot, event) for event in _meetings(shot)), default=None)
    if slip is None:
        return False, 'no ball meets another one'
    if slip < 1e-9:
        return False, 'the balls meet without slip'
    return True, f'balls meet with slip, of {slip:.3g} m/s at most'


@gate(
    'a ball meets another one that is within reach of others',
    'bodies in touch meet two by two, one pair after the other',
    # Nothing is ever so deep in another one; and contacts take no time.
    off={'contact_gap': -1e-3, 'ball_duration': 0.0},
)
def cluster(shot: EffectContext) -> Verdict:
    """Look for impacts of several bodies."""
    events = shot.events(EventKind.CLUSTER)
    if shot.struck_together:
        return True, f'{TOGETHER}; later impacts of more than two bodies: {len(events)}'
    if not events:
        return False, 'no more than two bodies ever meet'
    most = max(len(event.balls) for event in events)
    return True, f'impacts of more than two bodies: {len(events)}, of up to {most} balls'


def _meetings(shot: EffectContext) -> list[TableEvent]:
    return shot.events(EventKind.BALL, EventKind.CLUSTER)


def _count(events: list[TableEvent], what: str) -> Verdict:
    if not events:
        return False, f'no path reaches {what}'
    ball, times = events[0].balls[0], f'{len(events)} time{"s" * (len(events) > 1)}'
    return True, f'balls meet {what} {times}, first {ball} at {events[0].time:.3g} s'


def _balls_in_strike(shot: EffectContext) -> bool:
    """Whether balls met during the strike."""
    return shot.struck_together and any(event.time == 0.0 for event in _meetings(shot))


def _slip(shot: EffectContext, event: TableEvent) -> float:
    """Slip of balls just before they meet [m/s]; in a cluster, the largest."""
    radius = shot.scene.ball.radius
    reach = 2.0 * radius + shot.scene.contacts.ball_ball.gap + rounding.PLACE
    before, largest = np.nextafter(event.time, -np.inf), 0.0
    states = [shot.run.balls[name].at(before) for name in event.balls]
    for one, other in combinations(states, 2):
        between = one.position - other.position
        distance = float(np.linalg.norm(between))
        if distance <= reach:
            normal = between / distance
            slip = one.velocity - other.velocity
            slip = slip - radius * np.cross(one.spin + other.spin, normal)
            largest = max(largest, float(np.linalg.norm(slip - (slip @ normal) * normal)))
    return largest


TABLE_GATES = flight, bounce, slide, roll, spin_decay, cushion, pocket, ball_ball, throw, cluster


@lru_cache(maxsize=64)
def params_on_table(scene: Scene) -> tuple[BallClothParams, TableParams]:
    """Collect the parameters of a scene's table, with the effects that it forces on or off."""
    return apply_overrides(ball_cloth_params(scene), TABLE_GATES, scene.effects), table_on(scene)


@lru_cache(maxsize=64)
def table_on(scene: Scene) -> TableParams:
    """Collect the parameters of a scene's table alone, without the ball's."""
    return apply_overrides(table_params(scene), TABLE_GATES, scene.effects)

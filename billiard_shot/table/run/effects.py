"""Effects on the table: what is simulated where the motion calls for it, one object each."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import combinations
import math
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.scene import Effects, Scene
from billiard_shot.table.model.geometry import BallClothParams, GATE_OFF, GATE_ON, TableParams
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.layout import ball_cloth_params, table_params
from billiard_shot.table.run.results import BallState, EventKind, TableEvent, TableRun, Trajectory

AUTO, OFF, ON = 'auto', 'off', 'on'
JAW = 'jaw of'
TOGETHER = 'the ball reaches what is near during the strike'
N = TypeVar('N')
L = TypeVar('L', bound='EffectContext', contravariant=True)


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect in one shot; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str
    called_for: bool  # whether scene, stroke and motion call for it; the scene may force it off


@dataclass(frozen=True, slots=True)
class EffectContext:
    """What a row decides by: scene and motion. The layer `shot` adds the stroke."""

    scene: Scene
    velocity: NDArray[np.float64]  # of the ball that is struck, at first (3,) [m/s]
    spin: NDArray[np.float64]  # (3,) [rad/s]
    run: TableRun  # of all balls, the struck one first
    struck_together: bool  # whether other balls or a cushion took part in the strike

    def that_do(self, motion: Motion) -> list[str]:
        """Names of the balls that are ever in a kind of motion."""
        return [
            name for name, ball in self.run.balls.items() if np.any(ball.rows['motion'] == motion)
        ]

    def events(self, *kinds: EventKind) -> list[TableEvent]:
        """Events of some kinds on the table, in the order of time."""
        return [event for event in self.run.events if event.kind in kinds]


class GateDecision(NamedTuple):
    """Whether an effect was simulated, and why or why not."""

    simulated: bool
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class EffectGate(Generic[L]):
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
        Says of a finished shot whether the effect was simulated, and what decided.
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
    evaluate: Callable[[L], GateDecision]
    off: Mapping[str, Any] = field(default_factory=dict)
    on: Mapping[str, Any] | None = None
    tells_without: bool = False

    def apply(self, numbers: N, setting: str) -> N:
        """Return numbers (a named tuple) as a setting changes them; other tuples have the rest."""
        changes = {OFF: self.off, ON: self.on}.get(setting) or {}
        mine = {
            name: value(getattr(numbers, name)) if callable(value) else value
            for name, value in changes.items()
            if hasattr(numbers, name)
        }
        return numbers._replace(**mine) if mine else numbers  # type: ignore[attr-defined]


def check_overrides(gates: Iterable[EffectGate[Any]], *kinds: type[tuple[Any, ...]]) -> None:
    """Raise TypeError if a gate changes a number that no kind of named tuple has."""
    names = {name for kind in kinds for name in kind._fields}  # type: ignore[attr-defined]
    for gate in gates:
        for setting, changes in ((OFF, gate.off), (ON, gate.on or {})):
            unknown = sorted(set(changes) - names)
            if unknown:
                raise TypeError(
                    f'effect {gate.name}: {setting} changes {", ".join(unknown)}, which is not a '
                    f'number of {", ".join(kind.__name__ for kind in kinds)}'
                )


def apply_overrides(numbers: N, gates: Iterable[EffectGate[Any]], effects: Effects) -> N:
    """Numbers (a named tuple) for the compiled code, as a scene's settings change them."""
    for gate in gates:
        numbers = gate.apply(numbers, getattr(effects, gate.name))
    return numbers


def report(gate: EffectGate[L], context: L, again: Callable[[Scene], L]) -> Effect:
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
def _flight(context: EffectContext) -> GateDecision:
    up = float(context.velocity[2])
    rise = f'the ball rises by {_rise(context, up)}'
    if up > 0.0 and _flies(context.run.balls[context.run.names[0]], first=True):
        return GateDecision(True, rise)
    fliers = [name for name, ball in context.run.balls.items() if _flies(ball)]
    if fliers:
        return GateDecision(True, f'in an impact, a ball leaves the cloth: {", ".join(fliers)}')
    if up > 0.0:
        return GateDecision(False, f'too small to resolve within the tolerance: {rise}')
    return GateDecision(False, 'the ball does not leave the cloth')


def _bounce(context: EffectContext) -> GateDecision:
    balls = context.run.balls.values()
    bounces = sum(event.kind == EventKind.BOUNCE for ball in balls for event in ball.events)
    if bounces:
        return GateDecision(True, f'bounces until those that follow are too small: {bounces}')
    if not any(map(_flies, balls)):
        return GateDecision(False, 'there is no flight')
    again = context.scene.contacts.ball_table.restitution * max(float(context.velocity[2]), 0.0)
    rise = f'the ball rises by {_rise(context, again)} after it first lands'
    return GateDecision(False, f'too small to resolve within the tolerance: {rise}')


def _flies(ball: Trajectory, first: bool = False) -> bool:
    """Whether a ball falls freely, in its first piece of motion or in any."""
    rows = ball.rows[:1] if first else ball.rows
    flights = (rows['motion'] == Motion.FLIGHT) & (rows['acceleration'][:, 2] != 0.0)
    return bool(flights.any())


def _rise(context: EffectContext, up: float) -> str:
    return f'{1e3 * 0.5 * up * up / context.scene.cloth.gravity:.3g} mm'


# On the cloth.
def _slide(context: EffectContext) -> GateDecision:
    return _seen(context.that_do(Motion.SLIDE), 'slip on the cloth')


def _roll(context: EffectContext) -> GateDecision:
    return _seen(context.that_do(Motion.ROLL), 'come to roll')


def _spin_decay(context: EffectContext) -> GateDecision:
    turning = [name for name, ball in context.run.balls.items() if np.any(ball.rows['spin'][:, 2])]
    if turning and context.scene.cloth.spin_deceleration == 0.0:
        return GateDecision(False, 'the cloth does not slow spin about the vertical')
    return _seen(turning, 'spin about the vertical')


def _seen(names: Sequence[str], what: str) -> GateDecision:
    """Say which balls do something, or that none does."""
    return (
        GateDecision(True, f'balls that {what}: {", ".join(names)}')
        if names
        else GateDecision(False, f'no ball that would {what}')
    )


# Cushions and pockets.
def _cushion(context: EffectContext) -> GateDecision:
    if context.scene.table is None:
        return GateDecision(False, 'the scene has no table: the cloth is endless')
    if context.struck_together and not _balls_in_strike(context):
        return GateDecision(True, TOGETHER)
    events = [
        event for event in context.events(EventKind.CUSHION) if not event.place.startswith(JAW)
    ]
    decision = _count(events, 'a cushion')
    in_the_air = sum(event.position[2] > context.scene.ball.radius for event in events)
    if context.scene.table.cushion.model == 'han' and in_the_air:
        return decision._replace(
            reason=f'{decision.reason}; {in_the_air} in the air, where `han` does not hold: '
            'with the default model'
        )
    return decision


def _pocket(context: EffectContext) -> GateDecision:
    table = context.scene.table
    if table is None or not table.pockets:
        what = 'scene has no table' if table is None else 'table has none'
        return GateDecision(False, f'the {what}')
    fallen = [f'{event.balls[0]} in {event.place}' for event in context.events(EventKind.POCKET)]
    if fallen:
        return GateDecision(True, f'balls that fall: {", ".join(fallen)}')
    jaws = [event for event in context.events(EventKind.CUSHION) if event.place.startswith(JAW)]
    return _count(jaws, 'a jaw of a pocket')


# Other balls.
def _ball_ball(context: EffectContext) -> GateDecision:
    if len(context.run.balls) == 1:
        return GateDecision(False, 'there is no other ball')
    if _balls_in_strike(context):
        return GateDecision(True, TOGETHER)
    return _count(context.events(EventKind.BALL, EventKind.CLUSTER), 'another ball')


def _throw(context: EffectContext) -> GateDecision:
    balls = context.scene.contacts.ball_ball
    if balls.friction_fast == balls.friction_slow == 0.0:
        return GateDecision(False, 'balls have no friction on each other')
    if _balls_in_strike(context):
        return GateDecision(True, TOGETHER)
    meetings = context.events(EventKind.BALL, EventKind.CLUSTER)
    if not meetings:
        return GateDecision(False, 'no ball meets another one')
    slip = max(_slip(context, event) for event in meetings)
    if slip < 1e-9:
        return GateDecision(False, 'the balls meet without slip')
    return GateDecision(True, f'balls meet with slip, of {slip:.3g} m/s at most')


def _cluster(context: EffectContext) -> GateDecision:
    events = context.events(EventKind.CLUSTER)
    if context.struck_together:
        later = f'later impacts of more than two bodies: {len(events)}'
        return GateDecision(True, f'{TOGETHER}; {later}')
    if not events:
        return GateDecision(False, 'no more than two bodies ever meet')
    most = max(len(event.balls) for event in events)
    return GateDecision(
        True, f'impacts of more than two bodies: {len(events)}, of up to {most} balls'
    )


def _count(events: list[TableEvent], what: str) -> GateDecision:
    if not events:
        return GateDecision(False, f'no path reaches {what}')
    first = events[0]
    times = f'{len(events)} time{"s" * (len(events) > 1)}'
    return GateDecision(
        True, f'balls meet {what} {times}, first {first.balls[0]} at {first.time:.3g} s'
    )


def _balls_in_strike(context: EffectContext) -> bool:
    """Whether balls met during the strike."""
    meetings = context.events(EventKind.BALL, EventKind.CLUSTER)
    return context.struck_together and any(event.time == 0.0 for event in meetings)


def _slip(context: EffectContext, event: TableEvent) -> float:
    """Slip of balls just before they meet [m/s]; in a cluster, the largest."""
    radius, balls = context.scene.ball.radius, context.scene.contacts.ball_ball
    reach = 2.0 * radius + balls.gap + rounding.PLACE
    states = [_just_before(context, name, event.time) for name in event.balls]
    largest = 0.0
    for one, other in combinations(states, 2):
        between = one.position - other.position
        distance = float(np.linalg.norm(between))
        if distance <= reach:
            normal = between / distance
            slip = one.velocity - other.velocity
            slip = slip - radius * np.cross(one.spin + other.spin, normal)
            largest = max(largest, float(np.linalg.norm(slip - (slip @ normal) * normal)))
    return largest


def _just_before(context: EffectContext, name: str, time: float) -> BallState:
    """State of a ball at the end of what it did before an event."""
    return context.run.balls[name].at(np.nextafter(time, -np.inf))


TABLE_GATES: tuple[EffectGate[EffectContext], ...] = (
    EffectGate(
        'flight',
        'a ball leaves the cloth, by more than the tolerance',
        'the ball is put back on the cloth with its horizontal motion kept',
        _flight,
        off={'flight_gate': GATE_OFF},
        on={'flight_gate': GATE_ON},
    ),
    EffectGate(
        'bounce',
        'a ball that has flown leaves the cloth again, by more than the tolerance',
        'a ball stays down where it first lands',
        _bounce,
        off={'cloth_restitution': 0.0},
        on={'bounce_gate': GATE_ON},
    ),
    EffectGate(
        'slide',
        'a ball slips on the cloth',
        'a ball rolls at once, as it would at the end of its slide',
        _slide,
        off={'sliding_friction': math.inf},
    ),
    EffectGate(
        'roll',
        'a ball comes to roll',
        'a rolling ball meets no resistance, and never rests',
        _roll,
        off={'rolling_resistance': 0.0, 'rolling_rise': 0.0},
    ),
    EffectGate(
        'spin_decay',
        'a ball spins about the vertical',
        'spin about the vertical stays, and a ball that has any never rests',
        _spin_decay,
        off={'spin_deceleration': 0.0},
    ),
    EffectGate(
        'cushion',
        'the path of a ball reaches a cushion',
        'the cloth is unbounded, and there are no pockets',
        _cushion,
        off={'length': math.inf, 'pockets': False},
    ),
    EffectGate(
        'pocket',
        'the path of a ball reaches a pocket',
        'the cushions go on where the pockets would be',
        _pocket,
        off={'pockets': False},
        on={'pocket_gate': GATE_ON},
    ),
    EffectGate(
        'ball_ball',
        'the path of a ball reaches another one',
        'balls go through each other',
        _ball_ball,
        off={'pair_gate': GATE_OFF},
        on={'pair_gate': GATE_ON},
    ),
    EffectGate(
        'throw',
        'balls meet with slip, and have friction',
        'balls that meet are smooth: no throw, no spin from one to the other',
        _throw,
        off={'friction_fast': 0.0, 'friction_slow': 0.0},
    ),
    EffectGate(
        'cluster',
        'a ball meets another one that is within reach of others',
        'bodies in touch meet two by two, one pair after the other',
        _cluster,
        # Nothing is ever so deep in another one; and contacts take no time.
        off={'contact_gap': -1e-3, 'ball_duration': 0.0},
    ),
)
check_overrides(TABLE_GATES, BallClothParams, TableParams)


@lru_cache(maxsize=64)
def params_on_table(scene: Scene) -> tuple[BallClothParams, TableParams]:
    """Collect the parameters of a scene's table, with the effects that it forces on or off."""
    return apply_overrides(ball_cloth_params(scene), TABLE_GATES, scene.effects), table_on(scene)


@lru_cache(maxsize=64)
def table_on(scene: Scene) -> TableParams:
    """Collect the parameters of a scene's table alone, without the ball's."""
    return apply_overrides(table_params(scene), TABLE_GATES, scene.effects)

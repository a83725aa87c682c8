"""Which effects a shot called for, which were simulated, and why."""
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot import row as at
from billiard_shot.table.motion import ACCELERATION, MOTION, Motion
from billiard_shot.table.trajectory import EventKind, Trajectory


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str


def effects_of(
    scene: Scene, row: NDArray[np.float64], trajectory: Trajectory
) -> tuple[Effect, ...]:
    """List every effect the library knows, from a shot's results."""
    if row[at.PHASES] == 0:
        names = ('table_contact', 'tip_friction', 'table_friction', 'end_mass',
                 'flight', 'bounce', 'slide', 'roll', 'spin_decay')
        return tuple(Effect(name, False, 'the stroke was not played') for name in names)
    return (
        *_of_strike(scene, row),
        *_in_the_air(scene, row, trajectory),
        *_on_cloth(scene, row, trajectory),
    )


def _of_strike(scene: Scene, row: NDArray[np.float64]) -> Iterator[Effect]:
    tip, table = row[at.IMPULSE].reshape(2, 3)
    pressed = bool(table[0] > 0.0)
    yield Effect('table_contact', pressed, (
        f'the ball is pressed onto the cloth, with {table[0]:.3g} N s' if pressed
        else 'the strike never presses the ball onto the cloth'))
    yield _friction('tip_friction', scene.contacts.cue_ball.friction, tip, 'the tip')
    yield _friction('table_friction', scene.contacts.ball_table.friction, table, 'the cloth')
    if scene.cue.guided:
        yield Effect('end_mass', False, 'the cue is guided: its tip cannot move sideways')
    else:
        reason = f'the tip can move sideways, with {1e3 * scene.cue.end_mass:.3g} g of the cue'
        yield Effect('end_mass', True, reason)


def _friction(name: str, friction: float, impulse: NDArray[np.float64], body: str) -> Effect:
    size = np.hypot(impulse[1], impulse[2])
    if friction == 0.0:
        return Effect(name, False, 'the coefficient of friction is 0')
    if size == 0.0:
        return Effect(name, False, f'there is no slip to resist at {body}')
    return Effect(name, True, f'{body} drags the ball sideways with {size:.3g} N s')


def _in_the_air(
    scene: Scene, row: NDArray[np.float64], trajectory: Trajectory
) -> Iterator[Effect]:
    up = row[at.VELOCITY][2]
    rise = f'{1e3 * 0.5 * up * up / scene.cloth.gravity:.3g} mm'
    flown = bool(trajectory.rows[0, ACCELERATION + 2] != 0.0)
    if up <= 0.0:
        reason = 'the ball does not leave the cloth'
    elif flown:
        reason = f'the ball rises by {rise}'
    elif scene.effects.flight == 'off':
        reason = f'the scene turns it off; the ball would rise by {rise}'
    else:
        reason = f'too small to resolve within the tolerance: the ball rises by {rise}'
    yield Effect('flight', flown, reason)
    bounces = sum(event.kind == EventKind.BOUNCE for event in trajectory.events)
    if not flown:
        reason = 'there is no flight'
    elif scene.effects.bounce == 'off':
        reason = 'the scene turns it off; the ball stays where it lands'
    elif bounces:
        reason = f'the ball bounces {bounces} times before hops are too small to resolve'
    else:
        reason = 'too small to resolve within the tolerance'
    yield Effect('bounce', bounces > 0, reason)


def _on_cloth(
    scene: Scene, row: NDArray[np.float64], trajectory: Trajectory
) -> Iterator[Effect]:
    seen = {int(code) for code in trajectory.rows[:, MOTION]}
    for name, motion, yes, no in (
        ('slide', Motion.SLIDE, 'the ball slips on the cloth', 'the ball never slips on it'),
        ('roll', Motion.ROLL, 'the ball comes to roll', 'the ball never comes to roll'),
    ):
        yield Effect(name, motion in seen, yes if motion in seen else no)
    turning = bool(row[at.SPIN][2] != 0.0)
    decays = turning and scene.cloth.spin_deceleration > 0.0
    if decays:
        reason = 'the ball spins about the vertical'
    elif turning:
        reason = 'the cloth does not slow spin about the vertical'
    else:
        reason = 'the ball has no spin about the vertical'
    yield Effect('spin_decay', decays, reason)

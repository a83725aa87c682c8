"""
Quantities over time: speed, spin and energy of a shot; forces and impulses of its collisions.

Collisions and strikes are seen close up, with forces, impulses and energies.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import cycle, pairwise
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import Entry
from billiard_shot.impact import collide, integrator, kernel
from billiard_shot.impact.collide import Body, Contact, contact_space, properties_of, system_of
from billiard_shot.impact.options import elastic_energy, LAWS
from billiard_shot.impact.state import ContactState, is_active, Model, Workspace
from billiard_shot.impact.taylor import advance
from billiard_shot.pictures.canvas import (
    ball_colour,
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MOTIONS,
    new_figure,
    ORANGE,
    PURPLE,
    save,
    SKY,
    VERMILION,
)
from billiard_shot.pictures.trails import Trails
from billiard_shot.records import Array, OBJECTS
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.effects import model_of, StrikeModel
from billiard_shot.shot.shot import Shot
from billiard_shot.table.model.cue import UP
from billiard_shot.table.model.motion import Motion, RELEASE
from billiard_shot.table.run.results import EventKind

SAMPLES_PER_MOTION = 12  # of each motion of each ball


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """
    Motion and energy of balls at n times, in order; at an event, just before it and just after.

    Attributes
    ----------
    time : (n,) float array
        [s].
    speeds : mapping of str to (n,) float array
        Speed of every ball that ever moves [m/s].
    rims : mapping of str to (n,) float array
        Surface speed of a ball's rotation about a level axis [m/s]: its speed, if it rolls.
    spins : mapping of str to (n, 3) float array
        [rad/s], frame `table`.
    translation, rotation, height : (n,) float arrays
        Energies of all balls together [J]. The energy of height is relative to lying on the cloth.
        A ball in a pocket or off the table has no energy.

    """

    time: Array
    speeds: Mapping[str, Array]
    rims: Mapping[str, Array]
    spins: Mapping[str, Array]
    translation: Array
    rotation: Array
    height: Array


def history_of(trails: Trails) -> History:
    """Sample the motion of all moving balls over the time that is shown."""
    ball, gravity = trails.scene.ball, trails.scene.cloth.gravity
    moving = [name for name in trails.balls if trails.moved(name)]
    time = _times(trails, moving)
    states = {name: trails.balls[name].at(time) for name in moving}
    speeds = {name: np.linalg.norm(s.velocity, axis=1) for name, s in states.items()}
    sizes = {name: np.linalg.norm(s.spin, axis=1) for name, s in states.items()}
    nothing = np.zeros(len(time))
    heights = [
        np.where(s.motion < 5, s.position[:, 2] - ball.radius, 0.0) for s in states.values()
    ]
    return History(
        time,
        speeds,
        {name: ball.radius * np.hypot(*s.spin[:, :2].T) for name, s in states.items()},
        {name: s.spin for name, s in states.items()},
        sum((0.5 * ball.mass * v**2 for v in speeds.values()), nothing),
        sum((0.5 * ball.inertia * w**2 for w in sizes.values()), nothing),
        height=sum((ball.mass * gravity * z for z in heights), nothing),
    )


def _times(trails: Trails, names: list[str]) -> Array:
    """
    Find times just before and just after all events, and between them.

    During an impact, its balls move at constant velocities that stand for the impact. Their speeds
    and energies have no meaning then, so there are no times within an impact.
    """
    starts = np.concatenate(
        [[0.0, trails.until], *(trails.balls[name].rows['time'] for name in names)]
    )
    ends = np.unique(starts[starts <= trails.until])
    inner = ends[:-1, np.newaxis] + np.diff(ends)[:, np.newaxis] * np.linspace(
        0.0, 1.0, SAMPLES_PER_MOTION, endpoint=False
    )
    before = np.nextafter(ends[1:], 0.0)
    times = np.unique(np.concatenate([ends, inner.ravel(), before]))
    for name in names:
        rows = trails.balls[name].rows
        for end in np.flatnonzero(rows['cause'] == RELEASE):
            times = times[(times < rows['time'][end - 1]) | (times >= rows['time'][end])]
    return times


MOTION_NAMES = {
    Motion.SLIDE: 'slides',
    Motion.ROLL: 'rolls',
    Motion.FLIGHT: 'flies',
    Motion.SPIN: 'spins',
}
LABELLED = {
    EventKind.CUSHION: 'cushion',
    EventKind.POCKET: 'pocket',
    EventKind.OFF: 'off',
    EventKind.BALL: 'ball',
    EventKind.CLUSTER: 'balls',
    EventKind.CUE: 'cue',
}
VISIBLE = 2e-3  # smallest energy of height that is drawn, relative to that of motion
MOST_NAMED = 5  # balls besides the cue ball that the key names


def draw_history(trails: Trails, path: Path, title: str = '') -> None:
    """
    Write a picture: speeds, the cue ball's spin, and energies of all balls, over time.

    Raises
    ------
    ValueError
        If matplotlib is missing, or the file cannot be written.

    """
    history = history_of(trails)
    heights = (3.0, 2.4, 2.6)
    figure = new_figure(9.5, sum(heights))
    speeds, spins, energies = figure.subplots(3, 1, sharex=True, height_ratios=heights)
    _speeds(speeds, trails, history)
    _spins(spins, history)
    kinds = [(history.translation, SKY, 'of motion'), (history.rotation, ORANGE, 'of spin')]
    if history.height.max() > VISIBLE * history.translation.max():
        kinds.append((history.height, GREY, 'of height'))
    values, colours, labels = zip(*kinds, strict=True)
    energies.stackplot(history.time, *values, colors=colours, labels=labels, linewidth=0)
    energies.set(
        xlabel='time from the end of the strike (s)',
        ylabel='energy, all balls (J)',
        xlim=(0.0, trails.until),
        ylim=(0.0, None),
    )
    for axes in (speeds, spins, energies):
        axes.grid(alpha=0.3)
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small', frameon=False)
    if title:
        figure.suptitle(title, fontsize='medium')
    save(figure, path)


def _speeds(axes: Any, trails: Trails, history: History) -> None:
    seen = set()
    for piece in trails.pieces(CUE_BALL):
        label = f'cue ball {MOTION_NAMES[piece.motion]}'
        axes.axvspan(
            piece.times[0],
            piece.times[-1],
            color=MOTIONS[piece.motion],
            alpha=0.13,
            linewidth=0,
            label=None if label in seen else label,
        )
        seen.add(label)
    others = [name for name in history.speeds if name != CUE_BALL]
    for name in others:
        axes.plot(
            history.time,
            history.speeds[name],
            color=ball_colour(name),
            linewidth=1.0,
            label=f'ball {name}' if len(others) <= MOST_NAMED else None,
        )
    if len(others) > MOST_NAMED:
        axes.plot([], [], color=GREY, linewidth=1.0, label=f'{len(others)} other balls')
    if CUE_BALL in history.speeds:
        axes.plot(
            history.time, history.speeds[CUE_BALL], color=BLACK, linewidth=1.6, label='cue ball'
        )
        axes.plot(
            history.time,
            history.rims[CUE_BALL],
            color=BLACK,
            linewidth=1.0,
            linestyle='--',
            label='its rim, turning',
        )
    axes.set(ylabel='speed (m/s)', ylim=(0.0, None))
    for event in trails.run.events:
        if event.balls[0] == CUE_BALL and event.kind in LABELLED:
            axes.axvline(event.time, color=BLACK, linewidth=0.6, linestyle=':')


def _spins(axes: Any, history: History) -> None:
    if CUE_BALL in history.spins:
        for k, (name, colour, dashes) in enumerate(
            (('x', BLUE, '-'), ('y', VERMILION, '--'), ('z', GREEN, '-.'))
        ):
            axes.plot(
                history.time,
                history.spins[CUE_BALL][:, k],
                dashes,
                color=colour,
                linewidth=1.4,
                label=f'about {name}',
            )
    axes.axhline(0.0, color=PURPLE, linewidth=0.5)
    axes.set(ylabel="cue ball's spin (rad/s)")


SAMPLES_PER_STEP = 24  # of a step, beside its ends
STATE_NAMES = {(True, True): 'S1', (False, True): 'S2', (True, False): 'S3'}  # by active contacts


@dataclass(frozen=True, slots=True, eq=False)
class CollisionTrace:
    """
    A collision of N contacts at n times, in order; the time of an event occurs twice.

    Contact j has components 3 j (normal), 3 j + 1 and 3 j + 2 (tangential).

    Attributes
    ----------
    time : (n,) float array
        Scaled: the unit is 1 / sqrt(W k), with the largest normal response W [1/kg] and the
        largest stiffness k. The compression of a single contact lasts pi / 2 (exponent 1).
    active : (n, N) bool array
    velocities : (n, 3 N) float array
        Contact velocities [m/s].
    forces : (n, 3 N) float array
        On bodies a [N s per unit of time].
    impulses : (n, 3 N) float array
        On bodies a, since the start [N s].
    energies : (n, N) float array
        Elastic energies of the contacts [J]; energy that a law leaves when a contact ends is lost.

    """

    time: Array
    active: NDArray[np.bool_]
    velocities: Array
    forces: Array
    impulses: Array
    energies: Array

    def phases(self) -> list[slice]:
        """Stretches of samples between which the set of active contacts changes."""
        changes = np.flatnonzero((self.active[1:] != self.active[:-1]).any(axis=1)) + 1
        ends = [0, *changes.tolist(), len(self.time)]
        return [slice(a, b) for a, b in pairwise(ends)]

    def slip(self, contact: int) -> Array:
        """Slip speed at a contact (n,) [m/s]."""
        return np.hypot(self.velocities[:, 3 * contact + 1], self.velocities[:, 3 * contact + 2])

    def friction(self, contact: int) -> Array:
        """Friction force at a contact (n,), as `forces`."""
        return np.hypot(self.forces[:, 3 * contact + 1], self.forces[:, 3 * contact + 2])


@dataclass(slots=True)
class _Recorder:
    """Takes the solver's steps in place of `advance`, and samples them."""

    now: float = 0.0
    rows: list[Array] = field(default_factory=list)

    def __call__(
        self,
        m: Model,
        contacts: list[ContactState],
        ws: Workspace,
        scale: float,
        order: int,
        x: float,
    ) -> None:
        part = np.linspace(0.0, x, SAMPLES_PER_STEP + 2)
        powers = part[:, np.newaxis] ** np.arange(order + 1)
        integrals = scale * part[:, np.newaxis] * powers[:, :order] / np.arange(1, order + 1)
        velocities, forces, impulses, energies, active = [], [], [], [], []
        for c in contacts:
            pushes = 1.0 if is_active(c) else 0.0
            active.append(np.full(len(part), pushes))
            velocities += [powers @ u[: order + 1] for u in (c.velocity, c.slip_1, c.slip_2)]
            axes = c.force, c.friction_1, c.friction_2
            for force, impulse in zip(axes, c.impulse, strict=True):
                coefficients = pushes * np.array(force[:order])
                forces.append(powers[:, :order] @ coefficients)
                impulses.append(impulse + integrals @ coefficients)
            energies.append(
                [
                    elastic_energy(c.stiffness, pushes * max(y, 0.0), c.exponent)
                    for y in powers @ c.compression[: order + 1]
                ]
            )
        self.rows.append(
            np.column_stack(
                [self.now + scale * part, *active, *velocities, *forces, *impulses, *energies]
            )
        )
        self.now += scale * x
        advance(m, contacts, ws, scale, order, x)


def _with_names(function: Callable[..., Any], **names: Any) -> Callable[..., Any]:
    """Copy a function, with other values for some of the global names that it uses."""
    meanings = {**function.__globals__, **names}
    return FunctionType(function.__code__, meanings, argdefs=function.__defaults__)


def _watched_solver(recorder: _Recorder) -> Callable[..., Any]:
    """Return the solver, interpreted, with a recorder in place of `advance`."""
    take_step = _with_names(integrator.take_step, advance=recorder)
    integrate = _with_names(integrator.integrate, take_step=take_step)
    entry = kernel.solve_collisions
    solve_collisions = Entry(_with_names(entry.function, integrate=integrate), entry.example)
    return _with_names(kernel.solve_in_contact_space, solve_collisions=solve_collisions)


def trace_of_collision(
    bodies: Sequence[Body],
    contacts: Sequence[Contact],
    law: str,
    exponent: float = 1.0,
    tolerance: float = 1e-8,
) -> CollisionTrace:
    """Trace a collision of bodies; parameters as for `collide`."""
    recorder = _Recorder()
    space, count = contact_space(system_of(bodies, contacts)), len(contacts)
    _watched_solver(recorder)(
        properties_of(contacts, LAWS[law], exponent),
        space.delassus[np.newaxis],
        space.approach[np.newaxis],
        [tolerance],
        storage=OBJECTS,
    )
    rows = np.concatenate([np.zeros((0, 1 + 11 * count)), *recorder.rows])
    speed = max(float(-space.approach[::3].min()), 0.0)
    unit = speed / float(space.delassus.diagonal()[::3].max())  # N s
    time, active, u, force, impulse, energy = np.split(
        rows, np.cumsum([1, count, 3 * count, 3 * count, 3 * count]), axis=1
    )
    return CollisionTrace(
        time[:, 0], active > 0.0, speed * u, unit * force, unit * impulse, unit * speed * energy
    )


def trace_of_strike(shot: Shot) -> CollisionTrace:
    """
    Trace the strike of a shot, without the shaft of its cue.

    Raises
    ------
    ValueError
        If it was refused, or the ball touched others.

    """
    if shot.status.refused or len(shot.impact.dissipated) != 2:
        raise ValueError(
            'shot must be a stroke that can be played, of a ball that touches nothing but the '
            f'cloth, got {shot.status.name}: {shot.message}'
        )
    model = model_of(shot.scene)
    stroke = shot.stroke.touching(model.tip_curvature)
    normal, velocity = np.array(stroke.normal), np.array(stroke.velocity)
    return trace_of_collision(*bodies_of_strike(model, normal, velocity), shot.scene.law)


def bodies_of_strike(
    model: StrikeModel, normal: Array, velocity: Array
) -> tuple[tuple[Body, ...], tuple[Contact, ...]]:
    """
    State a stroke that can be played as bodies and contacts of cue, ball and table.

    Parameters
    ----------
    model : StrikeModel
    normal, velocity : (3,) arrays
        As of `Stroke`; velocity in m/s.

    """
    surface, c = model.surface, velocity
    n = normal / np.linalg.norm(normal)
    centre, end = np.array([0.0, 0.0, surface.radius]), model.inverse_end_mass
    cue = Body(model.cue_mass, velocity=c, guide=c, end_mass=1.0 / end if end > 0.0 else None)
    ball = Body(surface.mass, surface.inertia, position=centre)
    tip, cloth = zip(model.restitution, model.friction, model.stiffness, strict=True)
    bodies = cue, ball, Body.fixed(), Body.fixed()
    # The table takes part if the ball touches it. Else only another fixed body does.
    above, count = (1, 3) if model.on_cloth else (3, 4)
    contacts = (
        Contact(0, 1, centre + surface.radius * n, n, *tip, exponent=model.exponent[0]),
        Contact(above, 2, (0, 0, 0), UP, *cloth, exponent=model.exponent[1]),
    )
    return bodies[:count], contacts


CONTACT_COLOURS = BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK


def draw_collision(
    bodies: Sequence[Body],
    contacts: Sequence[Contact],
    path: Path,
    *,
    law: str = 'bistiffness',
    exponent: float = 1.0,
) -> None:
    """
    Write a picture: the impulse of each contact, and its elastic energy, over time.

    A drop of an energy is a loss. Bands tell states apart; the title names the contacts that are
    active in each state.

    Parameters
    ----------
    bodies, contacts, law, exponent
        As for `collide`.
    path : Path
        Of a picture file, such as `.png`.

    Raises
    ------
    ValueError
        If nothing approaches, if matplotlib is missing, or if the file cannot be written.

    """
    save(collision_figure(bodies, contacts, law, exponent), path)


def collision_figure(
    bodies: Sequence[Body], contacts: Sequence[Contact], law: str, exponent: float = 1.0
) -> Any:
    """Draw a collision; return the matplotlib figure."""
    result = collide(bodies, contacts, law, exponent, 1e-10)
    if not result.phases:
        raise ValueError('contacts: one must approach, but no two bodies collide')
    trace = trace_of_collision(bodies, contacts, law, exponent)
    time = trace.time / trace.time[-1]
    figure = new_figure(8.0, 6.0)
    impulses, energies = figure.subplots(2, 1, sharex=True)
    for j, (contact, colour) in enumerate(zip(contacts, cycle(CONTACT_COLOURS), strict=False)):
        touching = np.where(trace.active[:, j], 1.0, np.nan)
        name = f'contact {j}: body {contact.a} on body {contact.b}'
        lost = result.dissipated[j]
        losses = f'lost {lost[0]:.3g} J' + (f', {lost[1]:.3g} J by friction' if lost[1] else '')
        impulses.plot(time, trace.impulses[:, 3 * j], color=colour, label=name)
        energies.plot(time, trace.energies[:, j] * touching, color=colour, label=losses)
    _shade((impulses, energies), trace, time)
    impulses.set(ylabel='normal impulse (N s)', xlim=(0.0, 1.0))
    energies.set(
        ylabel='elastic energy (J)', xlabel='time / length of the collision', ylim=(0.0, None)
    )
    for axes in (impulses, energies):
        axes.grid(alpha=0.3)
        axes.legend(loc='upper left', bbox_to_anchor=(1.0, 1.0), fontsize='small', frameon=False)
    states = ', '.join('+'.join(map(str, phase.active)) for phase in result.phases)
    figure.suptitle(
        f'{result.status.name}, law {law}: active contacts {states}', fontsize='medium', wrap=True
    )
    return figure


CONTACTS = (('tip', BLUE, '-'), ('cloth', VERMILION, '--'))
MIN_LABEL_SHARE = 0.03  # of the strike's length that a state needs to be labelled


def draw_strike(shot: Shot, path: Path, title: str = '') -> None:
    """
    Write a picture: forces, grip, slip and elastic energies over the time of the strike.

    Raises
    ------
    ValueError
        If there was no strike, if the ball touched more than the cloth, if matplotlib is missing,
        or if the file cannot be written.

    """
    heights = (2.3, 1.9, 1.9, 1.9)
    figure = new_figure(9.0, sum(heights))
    trace = trace_of_strike(shot)
    panels = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    length = float(trace.time[-1])
    time = trace.time / length
    _states(panels, trace, time)
    frictions = model_of(shot.scene).friction
    for j, (name, colour, dashes) in enumerate(CONTACTS):
        style = {'color': colour, 'linestyle': dashes, 'linewidth': 1.6}
        touching = np.where(trace.active[:, j], 1.0, np.nan)
        force = trace.forces[:, 3 * j]
        panels[0].plot(time, length * force * touching, label=f'{name} presses', **style)
        if frictions[j] > 0.0:
            grip = grip_of(trace, j, frictions[j])
            panels[1].plot(time, grip, label=name, **style)
        panels[2].plot(time, trace.slip(j) * touching, label=name, **style)
        panels[3].plot(time, trace.energies[:, j] * touching, label=name, **style)
    panels[0].set(ylabel='force × length of\nthe strike (N s)', ylim=(0.0, None), xlim=(0.0, 1.0))
    panels[1].set(ylabel='friction / (μ ×\npressing force)', ylim=(0.0, 1.1))
    panels[1].axhline(1.0, color=GREY, linewidth=0.8)
    for word, height in (('slides', 1.0), ('sticks', 0.5)):
        panels[1].annotate(
            word,
            (1.0, height),
            (3, 0),
            textcoords='offset points',
            fontsize=8,
            va='center',
            annotation_clip=False,
        )
    panels[2].set(ylabel='slip (m/s)', ylim=(0.0, None))
    panels[3].set(
        ylabel='energy in\nthe contact (J)', ylim=(0.0, None), xlabel='time / length of the strike'
    )
    for axes in panels:
        axes.grid(alpha=0.3)
    panels[0].legend(loc='upper right', fontsize='small', frameon=False)
    figure.align_ylabels(panels)
    if title:
        figure.suptitle(title, fontsize='medium')
    save(figure, path)


def grip_of(trace: CollisionTrace, contact: int, friction: float) -> NDArray[np.float64]:
    """Friction force relative to its limit (n,): 1 during slip; NaN without a normal force."""
    limit = friction * trace.forces[:, 3 * contact]
    enough = trace.active[:, contact] & (limit > 1e-6 * limit.max())
    return np.where(enough, trace.friction(contact) / np.where(enough, limit, 1.0), np.nan)


def _shade(panels: Sequence[Any], trace: CollisionTrace, time: Array) -> None:
    """Shade every other state."""
    for part in trace.phases()[1::2]:
        for axes in panels:
            axes.axvspan(*time[part][[0, -1]], color=GREEN, alpha=0.08, linewidth=0)


def _states(panels: Sequence[Any], trace: CollisionTrace, time: Array) -> None:
    """Shade every other state, and name those that are long enough."""
    _shade(panels, trace, time)
    for part in trace.phases():
        begin, end = time[part][0], time[part][-1]
        if end - begin > MIN_LABEL_SHARE:
            name = STATE_NAMES[tuple(trace.active[part][0].tolist())]
            panels[0].annotate(
                name,
                (0.5 * (begin + end), 1.0),
                (0, 2),
                ha='center',
                xycoords=('data', 'axes fraction'),
                fontsize=8,
                textcoords='offset points',
                annotation_clip=False,
            )

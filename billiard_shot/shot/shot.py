"""What a prediction gives back, and how it is said: statuses, a sentence, a list of facts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from pathlib import Path
import re
import textwrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import Phase, read_log
from billiard_shot.notebook import Shown, Tabular
from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, in_hand
from billiard_shot.shot.effects import model_of, ShotContext
from billiard_shot.shot.lowest_elevation import lowest_elevation
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.run import results
from billiard_shot.table.strike import placement


def message_of(
    status: Status, scene: Scene, stroke: Stroke, trajectory: results.Trajectory
) -> str:
    """Explain a status; for a refused stroke: field, value and allowed range."""
    x, y, z = stroke.velocity
    elevation = math.degrees(math.atan2(-z, math.hypot(x, y))) + 0.0  # 0, not -0
    match status:
        case Status.OK | Status.OFF_TABLE:  # told by what happened
            return ''
        case Status.NEVER_RESTS:
            return (
                f'nothing stops the ball: its last motion, from {trajectory.duration:.3g} s on, '
                'is endless'
            )
        case Status.INFINITE_SEQUENCE:
            return 'an infinite, decaying sequence of impacts was replaced by its limit'
        case Status.NEGATIVE_ENERGY:
            return 'law: poisson drove an elastic energy below zero; take another law'
        case Status.TOLERANCE_NOT_REACHED:
            return 'tolerance: not reached; error_estimate states how large the error may be'
        case Status.BUDGET_EXCEEDED:
            return 'step budget exceeded in the impact or the bounces; the result is incomplete'
        case Status.MISS:
            return stroke.miss or (
                f'normal must point against the stroke, with a cosine below 0, got '
                f'{_components(stroke.normal)}, cosine {_cosine(stroke):.3g}'
            )
        case Status.NEGATIVE_ELEVATION:
            return (
                f'elevation must be 0 to 90, got {elevation:.3g} (degrees); the velocity of the '
                f'cue, {_components(stroke.velocity)} m/s, points up'
            )
        case Status.CUE_THROUGH_CLOTH:
            height = scene.ball.radius * (1.0 + stroke.normal[2])
            needed = scene.cue.ferrule_radius * math.cos(math.radians(elevation))
            return (
                f'normal must be at least {1e3 * needed:.3g} mm above the cloth, or the cue goes '
                f'through it, got {_components(stroke.normal)}, {1e3 * height:.3g} mm above it'
            )
        case Status.CUE_THROUGH_BALL | Status.CUE_THROUGH_CUSHION:
            return _in_the_way(status, scene, stroke, trajectory, elevation)
    return status.name.lower().replace('_', ' ')


def _in_the_way(
    status: Status, scene: Scene, stroke: Stroke, trajectory: results.Trajectory, elevation: float
) -> str:
    obstacles = placement.surroundings_of(scene)
    touching = stroke.touching(scene.cue.tip_curvature_radius / scene.ball.radius)
    direction = np.array(stroke.velocity) / stroke.speed
    if status == Status.CUE_THROUGH_BALL:
        names = [f'ball {name!r}' for name in scene.object_balls]
        depth_in = placement.depth_in_ball
    else:
        names = [f'the {name} cushion' for name in results.NOSE_NAMES]
        depth_in = placement.depth_in_cushion
    depths = [
        depth_in(obstacles, i, touching.normal, direction, trajectory.final_position)
        for i in range(len(names))
    ]
    pairs = zip(names, depths, strict=True)
    name, depth = next(pair for pair in pairs if pair[1] > rounding.PLACE)
    a, b, _, azimuth, _ = touching.offsets
    lowest = lowest_elevation(scene, [[a, b, 0.0, azimuth, 1.0]], trajectory.final_position)
    free = math.degrees(lowest[0])
    blocked = f'{name} blocks the cue, by {1e3 * depth:.3g} mm'
    if free >= 90.0:
        return f'{blocked} at {elevation:.3g} degrees; no elevation clears it'
    return f'elevation must be at least {free:g}, got {elevation:.3g} (degrees): {blocked}'


def _components(values: tuple[float, ...]) -> str:
    return '(' + ', '.join(f'{value:.4g}' for value in values) + ')'


def _cosine(stroke: Stroke) -> float:
    pairs = zip(stroke.normal, stroke.velocity, strict=True)
    return sum(n * v for n, v in pairs) / stroke.speed


STORY_WIDTH = 80  # characters of a line
NO_BREAK = '\xa0'
LABEL = 16  # characters of the name of a fact
FASTEST_CUE = 30.0  # m/s; no cue is as fast


def sentence(shot: Shot) -> str:
    """Describe a shot in one line; for a refused stroke, give the reason."""
    if shot.discontinuity > 0.0:
        trouble = (
            'law: the energetic law is discontinuous here; within the accuracy of the strike '
            f'the ball may rest at either of two positions {shot.discontinuity:.2g} m apart'
        )
    else:
        trouble = message_of(shot.status, shot.scene, shot.stroke, shot.trajectory)
    if shot.status.refused:
        return trouble
    return '; '.join(filter(None, [trouble, *_happenings(shot)]))


def facts(shot: Shot) -> dict[str, str]:
    """List what people ask of a shot, by name, with units; empty for a refused stroke."""
    if shot.status.refused:
        return {}
    a, b, elevation, azimuth, speed = shot.stroke.offsets
    vx, vy, vz = shot.velocity
    listed = {
        'stroke': (
            f'a {results.rounded(a, 2, "+")}, b {results.rounded(b, 2, "+")} radii; elevation '
            f'{_degrees(elevation, 1)}, azimuth {_degrees(azimuth, 2)}; {speed:.3g} m/s'
        ),
        'cue ball leaves': (
            f'at {math.hypot(vx, vy, vz):.3g} m/s, azimuth {_degrees(math.atan2(vy, vx), 2)}'
        ),
        'spin': f'{_spin_in_words(shot)} rad/s',
        'spin x, y, z': f'{_vector(shot.spin, 1)} rad/s',
    }
    if shot.tip_time > 0.0:
        chatter = ' (it chatters)' if shot.chatter else ''
        listed['touch'] = (
            f'tip {_milliseconds(shot.tip_time)}{chatter}, cloth {_milliseconds(shot.cloth_time)}'
        )
    if speed > FASTEST_CUE:
        listed['warning'] = f'no cue reaches {speed:.3g} m/s; breaks have up to 15 m/s'
    if len(shot.run.names) > 1:
        listed['first contact'] = (
            results.ball_in_words(shot.first_contact) if shot.first_contact else 'none'
        )
    for name in sorted(shot.run.names, key=_order):
        if outcome := _outcome(shot, name):
            listed['cue ball' if name == CUE_BALL else f'ball {name}'] = outcome
    listed['numerical error'] = f'at most {1e3 * shot.error_estimate:.1g} mm'
    if shot.first_contact:
        until = results.ball_in_words(shot.first_contact)
        listed['numerical error'] += f' until the cue ball meets {until}'
    elif not shot.trajectory.comes_to_rest:
        listed['numerical error'] += f' until {shot.trajectory.duration:.3g} s'
    return listed


def as_text(shot: Shot) -> str:
    """Write status, sentence and facts, in lines of at most 80 characters."""
    lines = textwrap.wrap(
        f'{shot.status.name}: {sentence(shot)}', STORY_WIDTH, subsequent_indent='    '
    )
    return '\n'.join([*lines, *(wrapped_fact(*fact) for fact in facts(shot).items())])


def wrapped_fact(name: str, text: str) -> str:
    """Write a fact below its sentence, in lines of at most 80 characters; units stay in place."""
    return textwrap.fill(
        re.sub(r'(?<=\d) (?=m/s)', NO_BREAK, text),
        STORY_WIDTH,
        initial_indent=f'  {name:{LABEL}}',
        subsequent_indent=' ' * (2 + LABEL),
        break_on_hyphens=False,
    ).replace(NO_BREAK, ' ')


def _happenings(shot: Shot) -> Iterator[str]:
    if shot.miscue:
        yield 'a miscue: the tip slid on the ball'
    yield _pocketed(shot)
    for ball in shot.off_table:
        yield f'{results.ball_in_words(ball)} off the table'
    if shot.first_contact:
        yield f'first contact {shot.first_contact}'
    elif len(shot.run.names) > 1:
        yield 'no ball hit'
    if shot.double_hit is not None:
        again = results.moment_in_words(shot.double_hit)
        yield f'a double hit: the cue hits the ball again {again}'
    if all(ball.comes_to_rest for ball in shot.run.balls.values()):
        yield f'at rest after {shot.run.duration:.3g} s'


def _pocketed(shot: Shot) -> str:
    """Say which balls fell where; the cue ball scratches."""
    falls = {
        ball: f'into {results.place_in_words(pocket)}' for ball, pocket in shot.pocketed.items()
    }
    return '; '.join(
        f'cue ball scratched {where}' if ball == CUE_BALL else f'{ball} {where}'
        for ball, where in falls.items()
    )


def _outcome(shot: Shot, name: str) -> str:
    """Say where a ball that moved, or was struck, ends; '' for the others."""
    ball = shot.run.balls[name]
    if name in shot.pocketed:
        return f'falls into {results.place_in_words(shot.pocketed[name])}'
    if name in shot.off_table:
        return 'leaves the table'
    if name != CUE_BALL and len(ball.rows) == 1:
        return ''
    ends = 'rests at' if ball.comes_to_rest else 'moves on from'
    return f'{ends} {_vector(ball.final_position[:2], 3)} m'


def _order(name: str) -> tuple[bool, float, str]:
    """Sort the cue ball first, numbers by their values, and other names by the alphabet."""
    return name != CUE_BALL, float(name) if name.isdecimal() else math.inf, name


def _spin_in_words(shot: Shot) -> str:
    """
    State the spin [rad/s] about three axes, as seen along the horizontal motion of the ball.

    Top and back spin: about the level axis across the motion. Side spin: about the vertical, named
    by the side on which the cue hits. Massé spin: about the direction of motion, named by the side
    to which the cloth turns the ball.
    """
    _, _, _, azimuth, _ = shot.stroke.offsets
    vx, vy, _ = shot.velocity
    heading = math.atan2(vy, vx) if math.hypot(vx, vy) > 0.0 else azimuth
    cosine, sine = math.cos(heading), math.sin(heading)
    x, y, z = shot.spin.tolist()
    named = (
        (cosine * y - sine * x, 'top', 'back'),
        (z, 'right', 'left'),
        (cosine * x + sine * y, 'massé right', 'massé left'),
    )
    told = [
        f'{positive if value > 0.0 else negative} {abs(value):.1f}'
        for value, positive, negative in named
        if abs(value) >= 0.05  # else it is written as 0.0
    ]
    return ', '.join(told) or '0.0'


def _vector(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], digits: int) -> str:
    return f'({", ".join(results.rounded(value, digits) for value in values.tolist())})'


def _milliseconds(seconds: float) -> str:
    return f'{1e3 * seconds:.3g} ms'


def _degrees(radians: float, digits: int) -> str:
    return f'{results.rounded(math.degrees(radians), digits)}°'


ROUNDED_PUSH = 1e-12  # relative to a push: friction that is only rounding


@dataclass(frozen=True, slots=True, eq=False)
class Impact:
    """
    The impact between cue, ball (contact 0) and table (contact 1).

    Where the ball reaches others or a cushion meanwhile, their contacts come after these.
    """

    dissipated: NDArray[np.float64]  # (N, 2) J: a row a contact: restitution, friction
    phases: tuple[Phase, ...]  # in order: the active contacts, and how it stood at the end


@dataclass(frozen=True, eq=False)
class Shot(Shown, Tabular):
    """
    A predicted shot. Numbers are in SI units and the frame `table`; arrays cannot be changed.

    If `status.refused`, the stroke was not played: the ball stays where it is.
    """

    scene: Scene
    stroke: Stroke
    position: NDArray[np.float64]  # (3,) m, of the cue ball's centre where it is struck
    tolerance: float  # m
    wall_time: float  # s that the prediction took
    status: Status  # how it ended; TOLERANCE_NOT_REACHED also if there is a `discontinuity`
    error_estimate: float  # m, largest error of the trajectory, with the `discontinuity`
    # m, between the two resting places on endless cloth that law `energetic` allows within the
    # accuracy of the strike; 0 if there is only one
    discontinuity: float
    run: results.TableRun  # of every ball, from the end of the strike
    _cue: np.void = field(repr=False)  # CueRecord, after the strike
    _log: NDArray[np.void] = field(repr=False)  # (phases, N) PhaseLog of N contacts
    _losses: NDArray[np.float64] = field(repr=False)  # (N, 2) J: restitution, friction

    @property
    def trajectory(self) -> results.Trajectory:
        """Of the cue ball."""
        return self.run.balls[CUE_BALL]

    @cached_property
    def message(self) -> str:
        """The result in one sentence; for a refused stroke, the reason."""
        return sentence(self)

    def __repr__(self) -> str:
        return f'Shot({self.status.name}: {self.message})'

    def __str__(self) -> str:
        return as_text(self)

    @property
    def events(self) -> tuple[results.TableEvent, ...]:
        """All that happens to all balls, in the order of time."""
        return self.run.events

    @property
    def pocketed(self) -> dict[str, str]:
        """The balls that fell into pockets, in the order of time, and which ones."""
        return self.run.pocketed

    @property
    def off_table(self) -> tuple[str, ...]:
        """The balls that left the table, in the order of time."""
        return self.run.off_table

    @property
    def final_position(self) -> dict[str, NDArray[np.float64]]:
        """Final position of every ball (3,) [m], also of a pocketed or lost one."""
        return self.run.final_position

    @property
    def scratched(self) -> bool:
        """Whether the cue ball fell into a pocket or left the table."""
        return CUE_BALL in self.pocketed or CUE_BALL in self.off_table

    @property
    def first_contact(self) -> str | None:
        """The first ball that the cue ball met; None if it met none."""
        return self.run.first_met.get(CUE_BALL)

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the ball's centre at the end of the strike (3,) [m/s]."""
        velocity: NDArray[np.float64] = self._cue['velocity']
        return velocity

    @property
    def spin(self) -> NDArray[np.float64]:
        """Angular velocity of the ball at the end of the strike (3,) [rad/s]."""
        spin: NDArray[np.float64] = self._cue['spin']
        return spin

    @property
    def cue_speed(self) -> float:
        """Cue speed along the stroke at the end of the strike [m/s], negative if it recoils."""
        return float(self._cue['speed'])

    @property
    def miscue(self) -> bool:
        """Whether the tip slid on the ball: at 2 m/s 0.2 mm before it pressed most, or 1 mm."""
        return bool(self._cue['miscue'])

    @property
    def tip_time(self) -> float:
        """For how long the tip touched the ball in the strike [s]."""
        return float(self._cue['tip_time'])

    @property
    def cloth_time(self) -> float:
        """For how long the ball pressed the cloth in the strike [s]."""
        return float(self._cue['cloth_time'])

    @property
    def chatter(self) -> bool:
        """
        Whether the tip touched the ball again, too soon for anybody to see a second hit.

        That is within 5 ms of the first touch, while the ball is lower than 1 mm above the cloth
        and has met nothing else.
        """
        return bool(self._cue['chatter'])

    @cached_property
    def impact(self) -> Impact:
        """The impact in detail."""
        return Impact(self._losses, read_log(self._log))

    @property
    def double_hit(self) -> float | None:
        """
        When the cue first hits the ball again [s]; None if it does not, or only chatters.

        From the end of the strike. 0 if it hit the ball more than once during the strike.
        """
        hit = float(self._cue['double_hit'])
        return None if self.status.refused or hit == math.inf else hit

    @property
    def effect_context(self) -> ShotContext:
        """What the gates of effects decide by."""
        return ShotContext(
            self.scene,
            self.velocity,
            self.run,
            bool(self._cue['others']),
            self.stroke,
            self._pushes(),
            self.cue_speed,
            self.double_hit,
            self.chatter,
        )

    def _pushes(self) -> NDArray[np.float64]:
        """Impulses of tip and cloth (2, 2) [N s]: normal and tangential."""
        n = self.stroke.touching(model_of(self.scene).tip_curvature).normal
        normals = np.array([n, (0.0, 0.0, 1.0)])
        impulses = self._cue['impulses'].reshape(2, 3)
        along = (impulses * normals).sum(axis=1)
        across = np.linalg.norm(impulses - along[:, np.newaxis] * normals, axis=1)
        return np.column_stack([along, np.where(across > ROUNDED_PUSH * along, across, 0.0)])

    @property
    def evaluations(self) -> int:
        """Steps that the impact took."""
        return int(self._cue['steps'])

    def after(self) -> Scene:
        """
        Return the scene after the shot: the balls where they rest.

        Balls in pockets and off the table are gone. If the cue ball is, it lies at the free place
        of the head string that is nearest to the middle (`ball in hand`).

        Raises
        ------
        ValueError
            If a ball still moves at the end: nothing stops it, or the budget was exceeded.

        """
        for name, ball in self.run.balls.items():
            if not ball.comes_to_rest:
                raise ValueError(
                    f'after() needs all balls at rest; ball {name!r} still moves '
                    f'(status {self.status.name})'
                )
        balls = self.run.places_left
        if CUE_BALL not in balls:
            balls[CUE_BALL] = in_hand(self.scene, balls)
        return replace(self.scene, balls=balls)

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame`, with a row for each event."""
        rows = [
            (e.time, str(e.kind), ' '.join(e.balls), e.place, *e.position.tolist(), e.energy_after)
            for e in self.events
        ]
        names = 'time', 'kind', 'balls', 'place', 'x', 'y', 'z', 'energy_after'
        return {name: [row[i] for row in rows] for i, name in enumerate(names)}

    def plot(self, path: str | Path | None = None) -> Any:
        """
        Draw the table from above; return the matplotlib figure, and write it to `path` if given.

        Raises
        ------
        ValueError
            If matplotlib is not installed, or the file cannot be written.

        """
        figure = Shown.pictures('table').shot_figure(self)
        if path is not None:
            Shown.pictures('canvas').save(figure, Path(path))
        return figure

    def view(self, path: str | Path | None = None) -> Path:
        """
        Write the shot as an HTML page, and return its path.

        Without `path` the page is a temporary file, and opens in the browser. ValueError if the
        file cannot be written, or the stroke was refused.
        """
        pages = Shown.pictures('view')
        if path is None:
            opened: Path = pages.open_page(self)
            return opened
        pages.write_page(self, Path(path))
        return Path(path)

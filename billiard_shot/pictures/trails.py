"""Paths of balls, and the motion of the cue, in the form that pictures take."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import EventKind, Segment, TableRun, Trajectory

ENDLESS_SHOWN = 2.0  # s for which a motion without end is shown
SAGITTA = 1e-4  # m, largest distance of a drawn line from the curve
MAX_POINTS = 400  # largest number of points of a segment
MEETINGS = EventKind.BALL, EventKind.CLUSTER
OFF_CLOTH = (Motion.POCKETED, Motion.OFF_TABLE)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A stretch of one kind of motion: times (n,) [s] and points (n, 3) [m] on it."""

    motion: Motion
    times: NDArray[np.float64]
    points: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trails:
    """Paths and events of the balls of a table that was simulated."""

    scene: Scene
    run: TableRun

    @property
    def balls(self) -> Mapping[str, Trajectory]:
        """The paths by name, the cue ball first if there is one."""
        return self.run.balls

    @cached_property
    def ghosts(self) -> tuple[NDArray[np.float64], ...]:
        """Positions of the cue ball (3,) as it met other balls [m]."""
        met = (each for each in self.run.events if each.kind in MEETINGS)
        times = [each.time for each in met if CUE_BALL in each.balls]
        return tuple(self.balls[CUE_BALL].at(time).position for time in times)

    @cached_property
    def until(self) -> float:
        """Time up to which the balls are shown [s]."""
        return max(
            ball.duration + (0.0 if ball.comes_to_rest else ENDLESS_SHOWN)
            for ball in self.balls.values()
        )

    def pieces(self, name: str) -> tuple[Piece, ...]:
        """Lines of a ball; empty if the ball never moves."""
        return tuple(_pieces(self.balls[name], self.until))

    def all_points(self) -> NDArray[np.float64]:
        """Points of all lines (n, 2) [m]."""
        lines = [piece.points[:, :2] for name in self.balls for piece in self.pieces(name)]
        return np.concatenate([np.zeros((0, 2)), *lines])

    def moved(self, name: str) -> bool:
        """Whether a ball moved from its place."""
        return len(self.balls[name].rows) > 1 or not self.balls[name].comes_to_rest

    def start(self, name: str) -> NDArray[np.float64]:
        """Centre of a ball at time 0 (3,) [m]."""
        return self.balls[name].at(0.0).position

    def end(self, name: str) -> NDArray[np.float64] | None:
        """Find the centre of a ball in the end (3,) [m]; None if in a pocket or off the table."""
        state = self.balls[name].at(self.until)
        return None if Motion(int(state.motion)) in OFF_CLOTH else state.position


def trails_of(shot: Shot) -> Trails:
    """Make trails of all balls of a shot; nothing moves if it is refused."""
    return Trails(shot.scene, shot.run)


def path_colours(trails: Trails, colours: Sequence[str], pale: str) -> dict[str, str]:
    """
    Choose the colours of the paths of the balls that move, by name; no two balls share one.

    The cue ball has the first colour. If more balls move than there are colours, only the cue
    ball, the ball that it met first, and balls that left the table have one; the others are pale.
    """
    moving = sorted(filter(trails.moved, trails.balls), key=lambda name: name != CUE_BALL)
    told = moving
    if len(moving) > len(colours):
        gone = [name for name in moving if trails.end(name) is None]
        told = [
            name
            for name in (CUE_BALL, trails.run.first_met.get(CUE_BALL), *gone)
            if name in moving
        ]
    return dict.fromkeys(moving, pale) | dict(zip(dict.fromkeys(told), colours, strict=False))


def _pieces(ball: Trajectory, until: float) -> Iterator[Piece]:
    """Yield the pieces of a path; consecutive segments of like motion are one piece."""
    motion, times = Motion.REST, [np.zeros(0)]
    for segment in ball.segments:
        if segment.start >= until or segment.motion in (Motion.REST, *OFF_CLOTH):
            continue
        if segment.motion != motion and len(times) > 1:
            yield _piece(ball, motion, times)
            times = times[:1]
        motion = segment.motion
        times.append(_times(segment, min(segment.end, until)))
    if len(times) > 1:
        yield _piece(ball, motion, times)


def _piece(ball: Trajectory, motion: Motion, times: list[NDArray[np.float64]]) -> Piece:
    every = np.concatenate(times)
    # the state just before the last time: at an event, `at` gives the state after it
    points = ball.at(np.append(every[:-1], np.nextafter(every[-1], 0.0))).position
    return Piece(motion, every, points)


def _times(segment: Segment, end: float) -> NDArray[np.float64]:
    """Choose times at which to draw a segment so that straight lines follow its curve."""
    duration = end - segment.start
    size = float(np.linalg.norm(segment.acceleration))
    bend = float(np.linalg.norm(np.cross(segment.velocity, segment.acceleration)))
    straight = bend <= 1e-9 * size * float(np.linalg.norm(segment.velocity))
    # a parabola's chord over dt misses it by at most a dt^2 / 8
    steps = 1 if straight else math.ceil(duration * math.sqrt(size / (8.0 * SAGITTA)))
    return np.linspace(segment.start, end, 1 + min(max(steps, 1), MAX_POINTS))


SWING = 0.3  # m, largest distance over which the cue is accelerated
MAX_ACCELERATION_TIME = 0.8  # s, largest duration of the acceleration


@dataclass(frozen=True, slots=True, eq=False)
class CueMotion:
    """
    Motion of the cue along its axis; the strike is at time 0.

    Attributes
    ----------
    tip : (3,) float array
        Point where the tip meets the ball [m], frame `table`.
    direction : (3,) float array
        Direction of the motion; a unit vector, frame `table`.
    swing : float
        Distance over which the cue is accelerated evenly [m].
    time : float
        Time that this takes [s].
    after : float
        Speed just after the strike [m/s].

    """

    tip: NDArray[np.float64]
    direction: NDArray[np.float64]
    swing: float
    time: float
    after: float

    def way(self, time: float) -> NDArray[np.float64]:
        """Displacement of the cue from its position at the strike (3,) [m]."""
        if time >= 0.0:
            return self.after * time * self.direction
        begun = max(1.0 + time / self.time, 0.0)
        return -self.swing * (1.0 - begun * begun) * self.direction


def cue_motion(shot: Shot, trails: Trails) -> CueMotion:
    """Choose how the cue of a shot moves: the shot has only its speeds at the strike."""
    radius = shot.scene.ball.radius
    stroke = shot.stroke.touching(shot.scene.cue.tip_curvature_radius / radius)
    swing = min(SWING, 0.5 * stroke.speed * MAX_ACCELERATION_TIME)
    return CueMotion(
        tip=trails.start(CUE_BALL) + radius * np.array(stroke.normal),
        direction=np.array(stroke.velocity) / stroke.speed,
        swing=swing,
        time=2.0 * swing / stroke.speed,
        after=0.0 if shot.status.refused else shot.cue_speed,
    )

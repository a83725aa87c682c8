"""A shot with all that it does on the table, in the quantities that the studies compare."""
from collections.abc import Mapping
from dataclasses import dataclass, replace
import math

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.scene.placing import CUE_BALL
from billiard_shot.shot.effects import Effect, effects_of, ShotLook
from billiard_shot.shot.predict import predict
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.motion import CAUSE, Cause, Motion
from billiard_shot.table.run import TableRun
from billiard_shot.table.simulate import simulate
from billiard_shot.table.trajectory import BallState, Trajectory

STANDS = (Motion.REST, Motion.SPIN, Motion.POCKETED, Motion.OFF_TABLE)


@dataclass(frozen=True, slots=True, eq=False)
class Played:
    """A shot, and what became of the other balls."""

    shot: Shot
    table: TableRun | None  # where there is more than the ball that is struck

    @property
    def time(self) -> float:
        """Time that it took to compute [s]."""
        return self.shot.wall_time + (self.table.wall_time if self.table else 0.0)

    @property
    def steps(self) -> int:
        """Steps of the impact, pieces of motion, and contacts looked for."""
        pieces = sum(len(ball.rows) for ball in self.balls.values())
        return self.shot.evaluations + pieces + (self.table.searches if self.table else 0)

    @property
    def balls(self) -> Mapping[str, Trajectory]:
        """Trajectories of all balls."""
        return self.table.balls if self.table else {CUE_BALL: self.shot.trajectory}

    @property
    def look(self) -> ShotLook:
        """What gates may look at."""
        return replace(self.shot.look, table=self.table, trajectory=self.balls[CUE_BALL])

    @property
    def effects(self) -> tuple[Effect, ...]:
        """What was simulated, and why."""

        def again(scene: Scene) -> ShotLook:
            return play(scene, self.shot.stroke, self.shot.tolerance).look

        return effects_of(self.look, again)


def play(scene: Scene, stroke: Stroke, tolerance: float) -> Played:
    """Play a stroke, and follow all balls on the table until they rest."""
    shot = predict(scene, stroke, tolerance)
    balls = {name: BallState(np.array([*place, scene.ball.radius]))
             for name, place in scene.balls.items()}
    balls[CUE_BALL] = BallState(np.array(scene.cue_ball), shot.velocity, shot.spin)
    if shot.status.refused or (scene.table is None and len(balls) == 1):
        return Played(shot, None)
    return Played(shot, simulate(scene, balls, tolerance))


def heading(trajectory: Trajectory) -> float:
    """Direction of a ball when it comes to roll, or before it meets something else [rad]."""
    way = trajectory.segments[0]
    causes = trajectory.rows[:, CAUSE]
    for segment, cause in zip(trajectory.segments, causes, strict=True):
        if cause not in (Cause.START, Cause.OWN) or segment.motion in STANDS:
            break
        way = segment
        if segment.motion == Motion.ROLL:
            break
    return math.atan2(way.velocity[1], way.velocity[0])


def distance(one: Played, other: Played) -> float:
    """
    Measure how far apart a ball comes to rest in two shots, of the ball that is moved most [m].

    Infinite, if one of them stops and the other never does; it may spin in place for ever.
    """
    apart = 0.0
    for name, ball in one.balls.items():
        twin = other.balls[name]
        if _stops(ball) != _stops(twin):
            return math.inf
        apart = max(apart, float(np.linalg.norm(ball.rest - twin.rest)))
    return apart


def _stops(ball: Trajectory) -> bool:
    return ball.segments[-1].motion in STANDS

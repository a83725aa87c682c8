"""What a prediction gives back."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import Phase, read_log
from billiard_shot.notebook import Shown
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, in_hand
from billiard_shot.shot import story
from billiard_shot.shot.effects import model_of, ShotContext
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.data_frame import data_frame
from billiard_shot.table.run import TableEvent, TableRun
from billiard_shot.table.trajectory import Trajectory

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
class Shot(Shown):
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
    run: TableRun  # of every ball, from the end of the strike
    _cue: np.void = field(repr=False)  # CueRecord, after the strike
    _log: NDArray[np.void] = field(repr=False)  # (phases, N) PhaseLog of N contacts
    _losses: NDArray[np.float64] = field(repr=False)  # (N, 2) J: restitution, friction

    @property
    def trajectory(self) -> Trajectory:
        """Of the cue ball."""
        return self.run.balls[CUE_BALL]

    @cached_property
    def message(self) -> str:
        """The result in one sentence; for a refused stroke, the reason."""
        return story.sentence(self)

    def __repr__(self) -> str:
        return f'Shot({self.status.name}: {self.message})'

    def __str__(self) -> str:
        return story.as_text(self)

    @property
    def events(self) -> tuple[TableEvent, ...]:
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
        """For how long the tip touched the ball in the strike [s]; 0 if that was not recorded."""
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
            self.spin,
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

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each event: time, kind, balls, place, energies.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        rows = [
            (e.time, str(e.kind), ' '.join(e.balls), e.place, *e.position.tolist(), e.energy_after)
            for e in self.events
        ]
        names = 'time', 'kind', 'balls', 'place', 'x', 'y', 'z', 'energy_after'
        return data_frame({name: [row[i] for row in rows] for i, name in enumerate(names)})

    def plot(self, path: str | Path | None = None) -> Any:
        """
        Draw the table from above; return the matplotlib figure, and write it to `path` if given.

        Raises
        ------
        ValueError
            If matplotlib is not installed, or the file cannot be written.

        """
        from billiard_shot.pictures.canvas import save
        from billiard_shot.pictures.table import shot_figure

        figure = shot_figure(self)
        if path is not None:
            save(figure, Path(path))
        return figure

    def view(self, path: str | Path | None = None) -> Path:
        """
        Write the shot as an HTML page, and return its path.

        Without `path` the page is a temporary file, and opens in the browser. ValueError if the
        file cannot be written, or the stroke was refused.
        """
        from billiard_shot.pictures.view import open_page, write_page

        if path is None:
            return open_page(self)
        write_page(self, Path(path))
        return Path(path)

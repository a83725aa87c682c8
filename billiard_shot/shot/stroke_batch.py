"""Many strokes that were played, as people use them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.notebook import Shown
from billiard_shot.scene import Scene
from billiard_shot.status import MISS, Status
from billiard_shot.table.data_frame import data_frame
from billiard_shot.table.table_batch import batch_of, TableBatch
from billiard_shot.table.task import BatchRecording
from billiard_shot.table.words import count_in_words


@dataclass(frozen=True, eq=False, repr=False)
class StrokeBatch(TableBatch, Shown):
    """n strokes that were played, and what came of them on n tables; ball 0 is the cue ball."""

    scene: Scene
    velocity: NDArray[np.float64]  # (n, 3) m/s, of the cue ball at the end of the strike
    spin: NDArray[np.float64]  # (n, 3) rad/s
    cue_speed: NDArray[np.float64]  # (n,) m/s along the stroke
    dissipated: NDArray[np.float64]  # (n, 2, 2) J: contact; restitution, friction
    evaluations: NDArray[np.int64]  # (n,) steps of the impact; 0: it is not solved, but mapped
    error_estimate: NDArray[np.float64]  # (n,) m; 0 if it is not estimated
    chatter: NDArray[np.bool_]  # (n,) the tip touched the ball again, see `Shot.chatter`

    @property
    def refused(self) -> NDArray[np.bool_]:
        """Whether a stroke could not be played (n,)."""
        refused: NDArray[np.bool_] = self.status >= MISS
        return refused

    @property
    def mapped(self) -> NDArray[np.bool_]:
        """Whether the strike comes from a map (n,), see `predict_within_noise`."""
        mapped: NDArray[np.bool_] = ~self.refused & (self.evaluations == 0)
        return mapped

    def __repr__(self) -> str:
        return f'StrokeBatch({count_in_words(self.status, "stroke", self.miscue)})'

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each stroke.

        Status, velocity, spin; and what rules ask: the columns of `TableBatch.to_frame`.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        columns: dict[str, Any] = {'status': [Status(each).name for each in self.status.tolist()]}
        for name in ('velocity', 'spin'):
            columns |= {f'{name}_{x}': getattr(self, name)[:, i] for i, x in enumerate('xyz')}
        for name in ('cue_speed', 'duration', 'error_estimate', 'chatter'):
            columns[name] = getattr(self, name)
        return data_frame(columns | self.columns())


def stroke_batch(scene: Scene, names: tuple[str, ...], played: BatchRecording) -> StrokeBatch:
    """Return strokes that were played, on tables whose balls have these names."""
    cues = played.cues
    return StrokeBatch(
        **vars(batch_of(played, names)),
        scene=scene,
        velocity=cues['velocity'],
        spin=cues['spin'],
        cue_speed=cues['speed'],
        dissipated=cues['losses'].reshape(-1, 2, 2),
        evaluations=cues['steps'],
        error_estimate=played.error,
        chatter=cues['chatter'],
    )

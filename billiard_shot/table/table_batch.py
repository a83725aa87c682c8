"""Many tables that were simulated, as people use them."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.status import Status
from billiard_shot.table.data_frame import data_frame
from billiard_shot.table.motion import Motion, NOTHING
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.task import BatchRecording
from billiard_shot.table.words import count_in_words, plural


@dataclass(frozen=True, eq=False)
class TableBatch:
    """Runs of many tables; row by row what `simulate` gives. Balls in the order of `names`."""

    names: tuple[str, ...]
    final_position: NDArray[np.float64]  # (tables, balls, 3) m, of each ball
    motion: NDArray[np.uint8]  # (tables, balls) a Motion: REST, POCKETED, ABSENT ...
    pocket: NDArray[np.int64]  # (tables, balls) index in POCKET_NAMES, -1: in none
    first_met: NDArray[np.int64]  # (tables, balls) index of the first ball each met, -1: none
    duration: NDArray[np.float64]  # (tables,) s until all rest
    status: NDArray[np.uint16]  # (tables,) Status
    events: NDArray[np.int64]  # (tables,) how many there were
    searches: NDArray[np.int64]  # (tables,) how many contacts were looked for
    double_hit: NDArray[np.bool_]  # (tables,) the cue hit ball 0 again, in the strike or later
    miscue: NDArray[np.bool_]  # (tables,) the tip slid on ball 0 in a strike
    jaws_met: NDArray[np.int64]  # (tables,) rounded jaws that ball 0 met before another ball
    rest_time: NDArray[np.float64]  # (tables, balls) s since when it rests, or is off the table
    cushions: NDArray[np.int64]  # (tables, balls) straight cushions that each ball met
    last_cushion: NDArray[np.float64]  # (tables, balls) s, of a cushion or a jaw; -inf: none
    met_time: NDArray[np.float64]  # (tables, balls) s, when ball 0 met each ball first; inf: never
    met_after: NDArray[np.int64]  # (tables, balls) straight cushions that ball 0 had met by then
    position_at: NDArray[np.float64]  # (tables, balls, times, 3) m, at the times asked for

    @property
    def states(self) -> TableStates:
        """The balls as they rest on the table, without those that fell or left it."""
        on_table = self.motion < Motion.POCKETED
        return TableStates(self.names, self.final_position, present=on_table)

    @property
    def first_contact_time(self) -> NDArray[np.float64]:
        """When ball 0 met another ball (tables,) [s]; infinite if it met none."""
        first: NDArray[np.float64] = self.met_time.min(axis=1)
        return first

    @property
    def to_cushion(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) met a cushion or jaw after ball 0 met another ball."""
        after: NDArray[np.bool_] = self.last_cushion > self.first_contact_time[:, np.newaxis]
        return after

    @property
    def off_table(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) left the table."""
        off: NDArray[np.bool_] = self.motion == Motion.OFF_TABLE
        return off

    @cached_property
    def pocketed(self) -> tuple[dict[str, str], ...]:
        """For each table the balls that fell, in the order of time, and the pockets."""
        fallen: list[dict[str, str]] = [{} for _ in range(len(self.status))]
        tables, balls = np.nonzero(self.pocket != NOTHING)
        for k in np.lexsort((self.rest_time[tables, balls], tables)).tolist():
            t, i = int(tables[k]), int(balls[k])
            fallen[t][self.names[i]] = POCKET_NAMES[self.pocket[t, i]]
        return tuple(fallen)

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each table; places in m, times in s.

        `pocketed`, `off_table` and `to_cushion` are tuples of names, `first_contact` is a name or
        None, and `first_contact_time` is NaN without a first contact.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        return data_frame(
            {
                'status': [Status(each).name for each in self.status.tolist()],
                'duration': self.duration,
                **self.columns(),
            }
        )

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame` that tell what the balls did."""
        names = np.array([*self.names, None], object)
        places = {
            f'{name}_{x}': self.final_position[:, i, k]
            for i, name in enumerate(self.names)
            for k, x in enumerate('xy')
        }
        return {
            'first_contact': names[self.first_met[:, 0]],
            'first_contact_time': self.first_contact_time,
            'pocketed': [tuple(each) for each in self.pocketed],
            'off_table': self._listed(self.off_table),
            'to_cushion': self._listed(self.to_cushion),
            'cushions': self.cushions[:, 0],
            'double_hit': self.double_hit,
            'miscue': self.miscue,
            **places,
        }

    def _listed(self, which: NDArray[np.bool_]) -> list[tuple[str, ...]]:
        return [
            tuple(name for name, there in zip(self.names, row, strict=True) if there)
            for row in which.tolist()
        ]

    def __repr__(self) -> str:
        balls = plural(len(self.names), 'ball')
        return f'TableBatch({balls}, {count_in_words(self.status, "table", self.miscue)})'


def batch_of(played: BatchRecording, names: tuple[str, ...]) -> TableBatch:
    """Return simulated tables, whose balls have these names, as people use them."""
    balls, tables, cues = played.balls, played.tables, played.cues
    return TableBatch(
        names=names,
        final_position=balls['position'],
        motion=balls['motion'].astype(np.uint8),
        pocket=balls['pocket'],
        first_met=balls['first_contact'],
        duration=tables['duration'],
        status=played.status.astype(np.uint16),
        events=tables['events'],
        searches=tables['searches'],
        double_hit=tables['double_hit'],
        miscue=cues['miscue'] if len(cues) else np.zeros(len(tables), np.bool_),
        jaws_met=tables['jaws_met'],
        rest_time=balls['time'],
        cushions=balls['cushions'],
        last_cushion=balls['last_edge'],
        met_time=balls['met_time'],
        met_after=balls['met_after'],
        position_at=played.places,
    )

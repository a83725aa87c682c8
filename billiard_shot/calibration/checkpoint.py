"""The state of a calibration in a file, so that an interrupted one goes on."""

from collections.abc import Sequence
from dataclasses import replace
import hashlib
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from billiard_shot.calibration.joint_fit import Shot
from billiard_shot.calibration.recording import Floats


class State(NamedTuple):
    """After a number of stages: common numbers, scales, and shots with their launches."""

    stages: int
    values: Floats
    scales: Floats
    shots: tuple[Shot, ...]


class Checkpoint:
    """
    A file with the state of a calibration; without a path, nothing is written.

    Parameters
    ----------
    path : str or Path, optional
    request : object
        All that decides the result, as text: the state of another calibration is not read.

    """

    def __init__(self, path: str | Path | None, request: object) -> None:
        self._path = None if path is None else Path(path)
        self._key = hashlib.sha256(repr(request).encode()).hexdigest()

    def read(self, shots: Sequence[Shot]) -> State | None:
        """
        Read the state; None if there is none.

        Raises
        ------
        ValueError
            If the file has the state of another calibration.

        """
        if self._path is None or not self._path.exists():
            return None
        try:
            data = json.loads(self._path.read_text(encoding='utf-8'))
            key, stages, values, scales, launches, until = (data[name] for name in FIELDS)
        except (ValueError, KeyError, TypeError):
            key = None
        if key != self._key:
            raise ValueError(
                f'checkpoint: {self._path} has no state of this calibration; remove it to begin '
                'anew'
            )
        found = tuple(
            replace(shot, launch=np.array(launches[number]), until=np.array(until[number]))
            for number, shot in enumerate(shots)
            if launches[number] is not None
        )
        return State(stages, np.array(values), np.array(scales), found)

    def write(self, state: State, shots: Sequence[Shot]) -> None:
        """Write a state; `shots` are all shots, of which it may have left out some."""
        if self._path is None:
            return
        found = {id(shot.watched): shot for shot in state.shots}
        kept = [found.get(id(shot.watched)) for shot in shots]
        content = (
            self._key,
            state.stages,
            state.values.tolist(),
            state.scales.tolist(),
            [shot and shot.launch.tolist() for shot in kept],
            [shot and np.asarray(shot.until).tolist() for shot in kept],
        )
        written = self._path.with_suffix(self._path.suffix + '.new')
        written.write_text(json.dumps(dict(zip(FIELDS, content, strict=True))), encoding='utf-8')
        written.replace(self._path)  # all of it or nothing, also if the process ends now

    def remove(self) -> None:
        """Remove the file of a calibration that is done."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)


FIELDS = 'calibration', 'stages', 'values', 'scales', 'launches', 'until'

"""The result of a calibration: estimates, predictions, the scene file and the report."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billiard_shot.calibration.check import Check, check, checked
from billiard_shot.calibration.estimate import Estimate
from billiard_shot.calibration.forecast import middle_launch, SHORT
from billiard_shot.calibration.model import Model
from billiard_shot.calibration.recording import Floats, Frame, RecordedShot
from billiard_shot.calibration.scene_file import scene_text
from billiard_shot.calibration.watched import watch
from billiard_shot.scene import Scene


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """
    A scene that was fitted to recorded shots.

    Attributes
    ----------
    scene : Scene
    estimates : tuple of Estimate
        Of the scene and of the frames of the recordings.
    frames : tuple of Frame
        Of the recordings.
    recordings : tuple of str
        Their names.
    converged : bool
        Whether the fit found a minimum; without it, intervals say little.
    unsettled : tuple of str
        If it did not converge, the shots whose launches, searched anew, move the numbers.
    fitted : tuple of str
        Names of the shots that were fitted.
    spins : (shots, 3) float array
        Follow, side and masse relative to the speed of those whose stroke was not commanded.
    checks, checks_before : tuple of Check
        The shots that were held out: as the scene predicts them, and as the scene did with which
        the calibration began.
    ignored : tuple of str
        What was left out, and why.

    """

    scene: Scene
    estimates: tuple[Estimate, ...]
    frames: tuple[Frame, ...]
    recordings: tuple[str, ...]
    converged: bool
    unsettled: tuple[str, ...]
    fitted: tuple[str, ...]
    spins: Floats
    checks: tuple[Check, ...]
    checks_before: tuple[Check, ...]
    ignored: tuple[str, ...]

    def __repr__(self) -> str:
        known = sum(each.interval is not None for each in self.estimates)
        state = 'converged' if self.converged else 'NOT converged'
        text = f'{known} of {len(self.estimates)} numbers identified'
        return f'Calibration({state}, {text}, {len(self.fitted)} shots fitted)'

    @property
    def state(self) -> str:
        """Whether the fit converged, in words."""
        if self.converged:
            return 'converged'
        text = 'NOT converged: do not rely on the intervals'
        return f'{text}; unsettled: shots {", ".join(self.unsettled)}' if self.unsettled else text

    def predict(
        self, shot: RecordedShot, seen: float = np.inf, recording: int = 0, seed: int = 1
    ) -> Check:
        """
        Predict a recorded shot after the launch that explains it best.

        If less than half a second was seen, many launches explain it: then one is taken whose
        path is in the middle of those of the others, see forecast.py.

        Parameters
        ----------
        shot : RecordedShot
        seen : float
            Time from the strike on until which samples tell the launch [s]; by default all do.
        recording : int
            Number of the recording whose frame the shot has.
        seed : int
            Of the search.

        Raises
        ------
        ValueError
            If the shot cannot be used, or no launch of it can be simulated.

        """
        model = Model(self.scene, self.frames)
        if seen < SHORT and shot.command is None and len(self.spins):
            frame = model.frames[recording]
            draw = np.random.default_rng(seed)
            watched = watch(shot, frame.rate)
            launch = middle_launch(model.scene, frame, watched, seen, self.spins, draw)
            found = None if launch is None else checked(model, recording, shot, launch)
        else:
            found = check((model, recording, shot, seen, (seed,)))
        if found is None:
            raise ValueError(f'shot {shot.name!r}: no launch can be simulated')
        return found

    def save(self, path: str | Path) -> None:
        """Write the scene as YAML, with a comment for each number that was sought."""
        heading = [
            f'Fitted to {len(self.fitted)} shots of {", ".join(self.recordings)}: {self.state}.',
            'Intervals: each shot left out in turn.',
        ]
        text = scene_text(self.scene, self.estimates, heading)
        Path(path).write_text(text, encoding='utf-8')

    def report(self, path: str | Path) -> None:
        """Write a page for a browser: how well the scene predicts, and what is known."""
        from billiard_shot.pictures.calibration import write_report

        write_report(self, Path(path))

"""`calibrate`: the numbers of a scene that recorded shots decide."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.calibration.check import Check, check
from billiard_shot.calibration.checkpoint import Checkpoint, State
from billiard_shot.calibration.comparison import FIRST_SCALES
from billiard_shot.calibration.estimate import Estimate
from billiard_shot.calibration.intervals import Interval, intervals_of, undecided
from billiard_shot.calibration.joint_fit import (
    fit,
    JointFit,
    Mapped,
    Problem,
    scales_after,
    searched,
    Shot,
)
from billiard_shot.calibration.launch import launch_of, prior_of
from billiard_shot.calibration.model import Model, model_of, Sought, sought_in, values_of
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.result import Calibration
from billiard_shot.calibration.simulator import recording_of, Simulator
from billiard_shot.calibration.usable import (
    check_places,
    named_scene,
    read_recordings,
    Recordings,
    Usable,
    usable_shots,
)
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.values import as_float, positive, whole

FIRST_HORIZON, HORIZON, GROWTH = 1.0, 8.0, 2.0
"""First and last time after the strike that count for common numbers [s], and their ratio."""

LEAST_SHOTS = 5
"""Number of shots that a fit needs."""

WORSE = 0.03
"""A number that the shots do not decide may raise the cost by this part if it is not fitted."""


class Progress(NamedTuple):
    """The step that is being done, and the part of all steps that is done."""

    text: str
    done: int
    total: int


def calibrate(
    recordings: Recordings | Simulator,
    scene: SceneLike | None = None,
    *,
    names: Sequence[str] | None = None,
    held_out: float = 0.25,
    horizon: float = HORIZON,
    seed: int = 1,
    executor: Executor | None = None,
    progress: Callable[[Progress], object] | None = None,
    checkpoint: str | Path | None = None,
) -> Calibration:
    """
    Fit a scene to recorded shots.

    Each shot has a launch of its own: velocity and spin of the struck ball, the time of the
    strike, and the places of the balls. What all shots have in common is fitted with a horizon
    that grows. A number that the shots do not decide keeps the value of the scene. If strokes were
    commanded, launches follow from them, and numbers of the cue are fitted, too.

    Parameters
    ----------
    recordings : Recording, str, Path, or sequence of these; or Simulator
        Recordings of one table, or their files, see `read_recording`. Or a simulator, which is
        asked for shots, see `recording_of`.
    scene : Scene, str or Path, optional
        With which the fit begins; by default the one that the first recording names.
    names : sequence of str, optional
        Numbers to be fitted, see `Scene.parameters`; by default `USUAL_NAMES`, and `CUE_NAMES` if
        strokes were commanded.
    held_out : float
        Part of the shots that are not fitted, but tell how well the scene predicts, 0 to 0.9.
    horizon : float
        Longest time after the strike that counts [s], above 0.
    seed : int
        The same seed gives the same result.
    executor : concurrent.futures.Executor, optional
        Does the work; by default this thread does.
    progress : callable, optional
        Called with a `Progress`.
    checkpoint : str or Path, optional
        File to which the state is written, and from which the same calibration goes on.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError
        If an argument or a file makes no sense, or too few shots can be used.

    """
    if callable(recordings):
        if scene is None:
            raise refused(scene, 'given for a simulator', 'scene')
        recordings = recording_of(recordings, scene, seed=seed)
    read = read_recordings(recordings)
    scene = named_scene(read) if scene is None else Scene.load(scene)
    share = as_float(held_out)
    if not 0.0 <= share <= 0.9:
        raise refused(held_out, 'a number from 0 to 0.9', 'held_out')
    horizons = _horizons(positive('horizon', horizon, 's'))
    seed = whole('seed', seed, 0)
    sought = sought_in(scene, read, names)
    usable, ignored = usable_shots(read)
    check_places(scene, usable, read)
    order = np.random.default_rng(seed).permutation(len(usable)).tolist()
    count = round(share * len(usable))
    tested, used = ([usable[k] for k in sorted(part)] for part in (order[:count], order[count:]))
    if len(used) < LEAST_SHOTS:
        raise ValueError(
            f'recordings must have at least {LEAST_SHOTS} usable shots beside those held out, got '
            + '\n  '.join([str(len(used)), *ignored])
        )
    mapped: Mapped = map if executor is None else executor.map
    work = _Work(mapped, progress, len(horizons) * len(used) + 2 * len(tested))
    content = [(each.shot.name, len(each.watched.place)) for each in usable]
    saved = Checkpoint(checkpoint, (scene.to_dict(), sought, horizons, share, seed, content))
    model = model_of(scene, read)
    shots = [Shot(each.watched, each.recording, _first_launch(each, model)) for each in used]
    problem, found = _fitted(model, sought, shots, horizons, seed, work, saved)
    problem, found, intervals = _decided(problem, found, work)
    fitted = problem.model_at(found.values)
    checks, checks_before = (_checked(by, tested, seed, work) for by in (fitted, model))
    saved.remove()
    return Calibration(
        scene=replace(fitted.scene, balls=scene.balls),
        estimates=_estimates(sought, problem, found, intervals),
        frames=fitted.frames,
        recordings=tuple(each.name for each in read),
        converged=found.converged,
        fitted=tuple(each.watched.name for each in found.shots),
        checks=checks,
        checks_before=checks_before,
        ignored=tuple(ignored),
    )


def _first_launch(one: Usable, model: Model) -> Floats:
    """Return a likely launch: that of the stroke, if it is known."""
    if one.shot.stroke is None or one.watched.command is not None:
        return prior_of(one.watched)[0]
    return launch_of(model.scene, model.frames[one.recording], one.watched, one.shot.stroke)


def _horizons(last: float) -> list[float]:
    """Return the horizons of a fit; the last one twice, with scales of what it found [s]."""
    horizons, horizon = [last, last], last / GROWTH
    while horizon >= FIRST_HORIZON:
        horizons.insert(0, horizon)
        horizon /= GROWTH
    return horizons


def _fitted(
    model: Model,
    sought: tuple[Sought, ...],
    shots: Sequence[Shot],
    horizons: Sequence[float],
    seed: int,
    work: '_Work',
    saved: Checkpoint,
) -> tuple[Problem, JointFit]:
    """Fit with all horizons in turn; go on from the state that is saved, if there is one."""
    state = saved.read(shots) or State(0, values_of(sought), FIRST_SCALES, tuple(shots))
    for stage in range(state.stages, len(horizons)):
        work.text = f'first {horizons[stage]:g} s'
        problem = Problem(model, sought, horizons[stage], work.mapped)
        ticking = problem._replace(mapped=work.ticking)
        launched = searched(ticking, state.values, state.shots, state.scales, seed, stage)
        if len(launched) < LEAST_SHOTS:
            raise ValueError(
                f'recordings must have at least {LEAST_SHOTS} shots that the scene can simulate, '
                f'got {len(launched)} of {len(shots)}: are their places in m, in the frame of the '
                'table?'
            )
        scales = scales_after(problem, state.values, launched, state.scales)
        found = fit(problem, state.values, launched, scales, work.say_error)
        state = State(stage + 1, found.values, found.scales, found.shots)
        if state.stages < len(horizons):
            saved.write(state, shots)
    return problem, found


def _decided(
    problem: Problem, found: JointFit, work: '_Work'
) -> tuple[Problem, JointFit, list[Interval]]:
    """
    Let the numbers go, one after the other, that the shots do not decide; fit the others.

    A number stays if the fit is worse without it.
    """
    intervals, needed = intervals_of(problem, found), set[str]()
    while doubtful := [
        k for k in undecided(problem, found, intervals) if problem.sought[k].name not in needed
    ]:
        least = doubtful[0]
        work.text = f'without {problem.sought[least].name}'
        rest = tuple(each for k, each in enumerate(problem.sought) if k != least)
        without = problem._replace(sought=rest)
        values = np.delete(found.values, least)
        tried = fit(without, values, found.shots, found.scales, work.say_error)
        if tried.cost > (1.0 + WORSE) * found.cost:
            needed.add(problem.sought[least].name)
        else:
            problem, found = without, tried
            intervals = intervals_of(problem, found)
    return problem, found, intervals


def _checked(
    model: Model, tested: Sequence[Usable], seed: int, work: '_Work'
) -> tuple[Check, ...]:
    """Predict shots that were not fitted; leave out those without any launch."""
    work.text = 'shots held out'
    items = [
        (model, each.recording, each.shot, np.inf, (seed, number))
        for number, each in enumerate(tested)
    ]
    return tuple(each for each in work.ticking(check, items) if each is not None)


def _estimates(
    sought: Sequence[Sought], problem: Problem, found: JointFit, intervals: Sequence[Interval]
) -> tuple[Estimate, ...]:
    """Return the estimates of all numbers, also of those that the shots do not decide."""
    known = {
        each.name: (value, *interval)
        for each, value, interval in zip(
            problem.sought, found.values.tolist(), intervals, strict=True
        )
    }
    return tuple(
        Estimate(
            each.name,
            each.unit,
            each.start,
            each.published,
            *known.get(each.name, (each.start, None, ())),
        )
        for each in sought
    )


class _Work:
    """Does the work of a calibration, and tells how much of it is done."""

    def __init__(
        self, mapped: Mapped, progress: Callable[[Progress], object] | None, total: int
    ) -> None:
        self.mapped, self.text = mapped, ''
        self._progress, self._done, self._total = progress, 0, total

    def ticking(self, work: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """Do work for items; each of them counts."""
        for each in self.mapped(work, items):
            yield each
            self._done += 1
            self._say(self.text)

    def say_error(self, error: float) -> None:
        """Tell the median error of a fit [m]."""
        self._say(f'{self.text}, median error {1e3 * error:.1f} mm')

    def _say(self, text: str) -> None:
        if self._progress is not None:
            self._progress(Progress(text, self._done, self._total))

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
from billiard_shot.calibration.forecast import spins_of
from billiard_shot.calibration.intervals import Interval, intervals_of, undecided
from billiard_shot.calibration.joint_fit import (
    deviations_of,
    fit,
    JointFit,
    Mapped,
    Problem,
    pulls_of,
    scales_after,
    searched,
    Shot,
)
from billiard_shot.calibration.launch import launch_of, prior_of
from billiard_shot.calibration.model import Model, model_of, Sought, sought_in, values_of, within
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.result import Calibration
from billiard_shot.calibration.simulator import recording_of, Simulator
from billiard_shot.calibration.usable import (
    check_enough,
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

FIRST_HORIZON, HORIZON, GROWTH = 0.8, 8.0, 3.0
"""First and last time after the strike that count for common numbers [s], and their ratio."""

FEW_STEPS, STEPS = 4, 10
"""Most steps of the common numbers at a horizon, and at the last one."""

ROUNDS = 6
"""How often launches are searched at the last horizon, and common numbers fitted, at most."""

SETTLED = 0.25
"""
A fit has converged if launches that are searched anew move each common number by less than this
part of its standard deviation, and the next step would not either.
"""

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
    check_enough(len(used), LEAST_SHOTS, 'usable shots beside those held out', ignored)
    mapped: Mapped = map if executor is None else executor.map
    work = _Work(mapped, progress, (len(horizons) + ROUNDS - 1) * len(used) + 2 * len(tested))
    content = [(each.shot.name, len(each.watched.place)) for each in usable]
    saved = Checkpoint(checkpoint, (scene.to_dict(), sought, horizons, share, seed, content))
    model = model_of(scene, read)
    shots = [Shot(each.watched, each.recording, _first_launch(each, model)) for each in used]
    problem, found, unsettled = _fitted(model, sought, shots, horizons, seed, work, saved)
    problem, found, intervals = _decided(problem, found, work)
    fitted = problem.model_at(found.values)
    checks, checks_before = (_checked(by, tested, seed, work) for by in (fitted, model))
    saved.remove()
    return Calibration(
        scene=replace(fitted.scene, balls=scene.balls),
        estimates=_estimates(sought, problem, found, intervals),
        frames=fitted.frames,
        recordings=tuple(each.name for each in read),
        converged=unsettled is None and found.ahead < SETTLED,
        unsettled=unsettled or (),
        fitted=tuple(each.watched.name for each in found.shots),
        spins=spins_of(found.shots),
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
    """Return the horizons of a fit [s]."""
    horizons, horizon = [last], last / GROWTH
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
) -> tuple[Problem, JointFit, tuple[str, ...] | None]:
    """
    Fit with all horizons in turn, with the last one until the numbers stay.

    Goes on from the state that is saved, if there is one. Returns also the shots that keep the
    numbers from staying, None if they stay.
    """
    values = within(sought, values_of(sought))
    state = saved.read(shots) or State(0, values, FIRST_SCALES, tuple(shots))
    last, stages = len(horizons) - 1, len(horizons) + ROUNDS - 1
    pulls: dict[str, Floats] = {}
    for stage in range(state.stages, stages):
        again = stage > last  # at the last horizon, launches are searched near those known
        adapts = stage <= last + 1  # after that, the same samples count in the same way
        problem = Problem(model, sought, horizons[min(stage, last)], work.mapped)
        work.text = f'first {problem.horizon:g} s'
        begun = state.shots
        if not again:
            begun = tuple(replace(each, until=np.inf) for each in begun)
        launched = searched(
            problem._replace(mapped=work.ticking),
            state.values,
            begun,
            state.scales,
            (seed, stage),
            near=again,
            cut=adapts,
        )
        if len(launched) < LEAST_SHOTS:
            raise ValueError(
                f'recordings must have at least {LEAST_SHOTS} shots that the scene can simulate, '
                f'got {len(launched)} of {len(shots)}: are their places in m, in the frame of the '
                'table?'
            )
        scales = state.scales
        if adapts:
            scales = scales_after(problem, state.values, launched, scales)
        steps = STEPS if stage >= last else FEW_STEPS
        found = fit(problem, state.values, launched, scales, steps, work.say_error)
        moved = (np.abs(found.values - state.values) / deviations_of(problem, found)).max()
        if again and max(moved, found.ahead) < SETTLED:
            unsettled = None
            break
        before, pulls = pulls, pulls_of(problem, found)
        unsettled = tuple(
            name
            for name in pulls
            if name in before and (np.abs(pulls[name] - before[name]) > SETTLED).any()
        )
        state = State(stage + 1, found.values, found.scales, found.shots)
        if state.stages < stages:
            saved.write(state, shots)
    work.reach(stages * len(shots))
    return problem, found, unsettled


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
        tried = fit(without, values, found.shots, found.scales, STEPS, work.say_error)
        if tried.costs.sum() > (1.0 + WORSE) * found.costs.sum():
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
    fits = zip(found.values.tolist(), intervals, strict=True)
    known = dict(zip(problem.sought, fits, strict=True))
    estimates = []
    for each in sought:
        before = each.stated(each.start)
        estimate = Estimate(each.name, each.unit, before, each.published, before, None, ())
        if each in known:
            value, ((low, high), shots) = known[each]
            estimate = replace(
                estimate,
                value=each.stated(value),
                interval=(each.stated(low), each.stated(high)),
                shots=shots,
            )
        estimates.append(estimate)
    return tuple(estimates)


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

    def reach(self, done: int) -> None:
        """Count the steps before this one as done: some were not needed."""
        self._done = done
        self._say(self.text)

    def _say(self, text: str) -> None:
        if self._progress is not None:
            self._progress(Progress(text, self._done, self._total))

"""Computation of an atlas: an independent plan for each layout, on any executor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
import hashlib
from itertools import islice
from queue import SimpleQueue
from typing import Any, TypeAlias

from billiard_shot.planning.atlas.layouts import Layout, layouts_of, scene_at
from billiard_shot.planning.atlas.request import AtlasRequest, with_defaults
from billiard_shot.planning.plan import plan
from billiard_shot.planning.runner import SupportsSubmit
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.planning.targets import Pot
from billiard_shot.scene import Scene
from billiard_shot.status import Status

StrokeNumbers: TypeAlias = tuple[float, float, float, float, float]
# Layouts submitted to an executor at a time: enough for all workers that one process can supply,
# but few enough that an atlas of any size needs little memory.
AHEAD = 256


@dataclass(frozen=True, slots=True)
class LayoutResult:
    """
    Success probability of a pot from one layout.

    Attributes
    ----------
    layout : Layout
    status : Status
        OK; NO_PLAN if no stroke was found; INVALID_REQUEST if the cue has no clearance within the
        limits of the robot.
    message : str
        The same in one line.
    simulations : int
        Number of all simulated strokes.
    successes, trials : int
        Of the best stroke under noise, in held-out trials.
    kind : str
        Players' name for the best stroke; empty if no stroke was found.
    stroke : (float, float, float, float, float) or None
        a, b [ball radii], elevation, azimuth [rad] and speed [m/s] of the best stroke.

    """

    layout: Layout
    status: Status
    message: str
    simulations: int = 0
    successes: int = 0
    trials: int = 0
    kind: str = ''
    stroke: StrokeNumbers | None = None

    @property
    def success(self) -> float:
        """Fraction of the trials that potted the ball; 0 if no stroke was found."""
        return self.successes / self.trials if self.trials else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of the success (Wilson); (0, 1) if no stroke was found."""
        return wilson_interval(self.successes, self.trials)


def atlas(
    scene: Scene,
    request: AtlasRequest,
    layouts: Iterable[Layout] | None = None,
    executor: Executor | SupportsSubmit | None = None,
) -> Iterator[LayoutResult]:
    """
    Plan a pot from every layout, and yield each result as soon as it is known.

    The same scene, request and layout give the same result on any executor; only the order of the
    results differs. Close the generator to stop early: layouts not yet started are cancelled.

    Parameters
    ----------
    scene : Scene
        With the balls that are not moved; its section `robot` limits the strokes.
    request : AtlasRequest
    layouts : iterable of Layout, optional
        Layouts to plan from; by default those of `layouts_of`.
    executor : optional
        Plans from several layouts at once: an executor of `concurrent.futures`, the result of
        `get_executor()` of a Dask client, or any object with a method `submit` that returns
        futures. By default the calling thread, one layout after the other.

    Yields
    ------
    LayoutResult

    Raises
    ------
    ValueError
        Before the first result, if the request does not fit the scene.

    """
    request = with_defaults(scene, request)
    wanted = iter(layouts_of(scene, request) if layouts is None else layouts)
    if executor is None:
        return (plan_layout(scene, request, layout) for layout in wanted)
    return _as_completed(scene, request, wanted, executor)


def _as_completed(
    scene: Scene,
    request: AtlasRequest,
    layouts: Iterator[Layout],
    executor: Executor | SupportsSubmit,
) -> Iterator[LayoutResult]:
    ended: SimpleQueue[Future[LayoutResult]] = SimpleQueue()
    under_way: set[Future[LayoutResult]] = set()

    def submit(layout: Layout) -> None:
        future = executor.submit(plan_layout, scene, request, layout)
        under_way.add(future)
        future.add_done_callback(ended.put)

    try:
        for layout in islice(layouts, AHEAD):
            submit(layout)
        while under_way:
            future = ended.get()
            under_way.discard(future)
            for layout in islice(layouts, 1):
                submit(layout)
            yield future.result()
    finally:
        for future in under_way:
            future.cancel()


def plan_layout(scene: Scene, request: AtlasRequest, layout: Layout) -> LayoutResult:
    """Plan a pot from one layout, on the calling thread alone."""
    try:
        result = plan(
            scene_at(scene, layout),
            Pot((layout.ball,), request.pocket),
            request.noise,
            request.budget,
            _seed(request.seed, layout),
            executor=_Immediately(),
        )
    except ValueError as error:  # the cue has no clearance
        return LayoutResult(layout, Status.INVALID_REQUEST, str(error))
    found = LayoutResult(layout, result.status, result.message, result.simulations)
    best = result.best
    if best is None:
        return found
    return replace(
        found,
        successes=best.successes,
        trials=best.trials,
        kind=best.kind,
        stroke=best.stroke.offsets,
    )


class _Immediately:
    """Executor that runs each task at once, on the calling thread."""

    def submit(self, work: Any, /, *arguments: Any) -> Future[Any]:
        """Run a task."""
        future: Future[Any] = Future()
        future.set_result(work(*arguments))
        return future


def _seed(seed: int, layout: Layout) -> int:
    """Seed of a layout: it depends on the layout, not on the order of the computation."""
    text = repr((seed, layout.ball, *layout.ball_place, *layout.cue_place))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8])

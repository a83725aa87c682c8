"""An atlas made: each place planned by itself, by whatever executor there is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
import hashlib
from itertools import islice
from queue import SimpleQueue
from typing import Any, TypeAlias

from billiard_shot.planning.atlas.places import Place, places_of, scene_at
from billiard_shot.planning.atlas.request import AtlasRequest, settled
from billiard_shot.planning.chance import wilson
from billiard_shot.planning.plan import plan
from billiard_shot.planning.runner import Submits
from billiard_shot.planning.targets import Pot
from billiard_shot.scene import Scene
from billiard_shot.status import Status

Offsets: TypeAlias = tuple[float, float, float, float, float]
# Places handed to an executor at a time: enough for any number of workers that one planning
# process can feed, and few enough that an atlas of any size needs little memory.
AHEAD = 256


@dataclass(frozen=True, slots=True)
class PlaceChance:
    """
    How surely a ball is potted from one place.

    Attributes
    ----------
    place : Place
    status : Status
        OK; NO_PLAN, if no stroke was found; or INVALID_REQUEST, if there is no room for the cue
        within the robot's limits.
    message : str
        The same in a line.
    successes, trials : int
        Of the best stroke, under noise, in strokes that had no part in choosing it.
    simulations : int
        Strokes that were simulated in all.
    kind : str
        What players call the best stroke; empty without one.
    stroke : (float, float, float, float, float) or None
        a, b [ball radii], elevation, azimuth [rad] and speed [m/s] of the best stroke.

    """

    place: Place
    status: Status
    message: str
    successes: int
    trials: int
    simulations: int
    kind: str
    stroke: Offsets | None

    @property
    def success(self) -> float:
        """Part of the trials that potted the ball; 0 if no stroke was found that does."""
        return self.successes / self.trials if self.trials else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Interval of 95 % around it (Wilson); (0, 1), nothing is known, without a stroke."""
        return wilson(self.successes, self.trials)


def atlas(
    scene: Scene,
    request: AtlasRequest,
    places: Iterable[Place] | None = None,
    executor: Executor | Submits | None = None,
) -> Iterator[PlaceChance]:
    """
    Plan a pot from every place, and yield what came of each as soon as it is known.

    The same scene, request and place give the same result, whoever works it out and when; only
    their order differs. Whoever has enough closes the generator: places that nobody works at are
    given back.

    Parameters
    ----------
    scene : Scene
        With the balls that are not moved; its section `robot` says what strokes can be played.
    request : AtlasRequest
    places : iterable of Place, optional
        Those that are wanted; by default all that `places_of` lists.
    executor : optional
        What works at several places at once: an executor of `concurrent.futures`, a Dask client's
        `get_executor()`, or anything else with a method `submit` that gives futures. By default
        this thread, one place after the other.

    Yields
    ------
    PlaceChance

    Raises
    ------
    ValueError
        At once, if the request does not fit the scene.

    """
    request = settled(scene, request)
    wanted = iter(places_of(scene, request) if places is None else places)
    if executor is None:
        return (chance_at(scene, request, place) for place in wanted)
    return _as_completed(scene, request, wanted, executor)


def _as_completed(
    scene: Scene, request: AtlasRequest, places: Iterator[Place], executor: Executor | Submits
) -> Iterator[PlaceChance]:
    ended: SimpleQueue[Future[PlaceChance]] = SimpleQueue()
    under_way: set[Future[PlaceChance]] = set()

    def submit(place: Place) -> None:
        future = executor.submit(chance_at, scene, request, place)
        under_way.add(future)
        future.add_done_callback(ended.put)

    try:
        for place in islice(places, AHEAD):
            submit(place)
        while under_way:
            future = ended.get()
            under_way.discard(future)
            for place in islice(places, 1):
                submit(place)
            yield future.result()
    finally:
        for future in under_way:
            future.cancel()


def chance_at(scene: Scene, request: AtlasRequest, place: Place) -> PlaceChance:
    """Plan a pot from one place, on this thread alone."""
    result = plan(
        scene_at(scene, place),
        Pot(place.ball, request.pocket),
        request.noise,
        request.budget,
        _seed(request.seed, place),
        executor=_Here(),
    )
    best = result.best
    if best is None:
        return PlaceChance(
            place,
            result.status,
            result.message,
            0,
            0,
            result.simulations,
            '',
            None,
        )
    return PlaceChance(
        place,
        result.status,
        result.message,
        best.successes,
        best.trials,
        result.simulations,
        best.kind,
        best.stroke.offsets,
    )


class _Here:
    """Executor that does everything at once, on the calling thread."""

    def submit(self, work: Any, /, *arguments: Any) -> Future[Any]:
        """Do a piece of work."""
        future: Future[Any] = Future()
        future.set_result(work(*arguments))
        return future


def _seed(seed: int, place: Place) -> int:
    """Seed of a place: other places draw other numbers, in whatever order their turn comes."""
    text = repr((seed, place.ball, *place.ball_place, *place.cue_place))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8])

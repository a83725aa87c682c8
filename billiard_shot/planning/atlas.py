"""
An atlas: how surely a target is reached from where, over a grid of places of two balls.

Each place of the two balls is a piece of work of its own, which any executor may do, near or far.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.plan import plan
from billiard_shot.planning.runner import Submits
from billiard_shot.planning.targets import target_of
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placing import CUE_BALL

Place = tuple[float, float]
AT_ONCE = 64  # pieces of work that are given away at a time


@dataclass(frozen=True, slots=True)
class Chart:
    """
    What an atlas is about.

    Parameters
    ----------
    scene : Scene
        With a table, and the ball that moves; other balls stay where they are.
    target : mapping
        As of `plan`.
    ball : str
        The object ball, which is put to each place of the grid.
    columns, rows : int
        Places along the table and across it, for each of the two balls.
    noise : Noise
    budget, seed : int
        Of each plan.

    """

    scene: Scene
    target: Mapping[str, Any]
    ball: str
    columns: int
    rows: int
    noise: Noise
    budget: int
    seed: int

    def __post_init__(self) -> None:
        target_of(self.scene, self.target)
        if self.scene.table is None:
            raise ValueError('scene: an atlas needs one with a table')
        if self.ball not in self.scene.balls or self.ball == CUE_BALL:
            raise ValueError(f'ball: there is no ball {self.ball!r} beside the cue ball')
        for name in ('columns', 'rows', 'budget'):
            if getattr(self, name) < 1:
                raise ValueError(
                    f'{name}: {getattr(self, name)!r} is not allowed; it must be at least 1'
                )

    @property
    def places(self) -> list[Place]:
        """Places (columns x rows) of the grid, column by column [m]."""
        table = self.scene.table
        assert table is not None
        sides = ((table.length, self.columns), (table.width, self.rows))
        x, y = (size * ((np.arange(count) + 0.5) / count - 0.5) for size, count in sides)
        return [(float(u), float(v)) for u in x for v in y]

    def says(self) -> dict[str, Any]:
        """All that the results depend on, as JSON has it."""
        data: dict[str, Any] = json.loads(json.dumps({
            'scene': self.scene.to_dict(derived=True), 'target': dict(self.target),
            'ball': self.ball, 'columns': self.columns, 'rows': self.rows,
            'noise': [self.noise.a, self.noise.b, self.noise.elevation_deg,
                      self.noise.azimuth_deg, self.noise.speed],
            'budget': self.budget, 'seed': self.seed,
        }))
        return data


def chance_at(chart: Chart, cue: Place, ball: Place) -> float | None:
    """Chance of success with the two balls at such places; None if they cannot lie so."""
    balls = {**chart.scene.balls, CUE_BALL: cue, chart.ball: ball}
    try:
        scene = replace(chart.scene, balls=balls)
        target_of(scene, chart.target)
    except ValueError:
        return None
    result = plan(
        scene, chart.target, chart.noise, chart.budget, chart.seed, executor=InPlace()
    )
    return result.best.success if result.best else 0.0


class InPlace:
    """An executor that does the work at once, itself."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Do a piece of work."""
        future: Future[Any] = Future()
        try:
            future.set_result(work(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


def compute_atlas(
    chart: Chart, executor: Executor | Submits, file: Path,
    report: Callable[[int], object] | None = None,
) -> NDArray[np.float64]:
    """
    Compute an atlas, and keep what is known in a file.

    What the file already has, of the same chart, is not computed again: an atlas that was
    interrupted goes on.

    Parameters
    ----------
    chart : Chart
    executor : executor
        Anything with `submit`, as executors of `concurrent.futures` and clients of Dask have it.
    file : Path
        A line of JSON for the chart, and one for each place.
    report : callable, optional
        Called with how many places are done.

    Returns
    -------
    chances : (columns * rows, columns * rows) float array
        For each place of the object ball (rows) and of the cue ball (columns) the chance of
        success; NaN where the balls cannot lie so.

    Raises
    ------
    ValueError
        If the file is of another chart, or cannot be read.

    """
    places = chart.places
    known = _known(chart, file)
    open_ = [(i, j) for i in range(len(places)) for j in range(len(places)) if (i, j) not in known]
    with file.open('a', encoding='utf-8') as out:
        if not out.tell():
            out.write(json.dumps(chart.says()) + '\n')
        for begin in range(0, len(open_), AT_ONCE):
            part = open_[begin : begin + AT_ONCE]
            futures = [
                executor.submit(chance_at, chart, places[j], places[i]) for i, j in part
            ]
            for (i, j), future in zip(part, futures, strict=True):
                known[i, j] = future.result()
                out.write(json.dumps([i, j, known[i, j]]) + '\n')
                out.flush()
                if report:
                    report(len(known))
    chances = np.full((len(places), len(places)), np.nan)
    for (i, j), chance in known.items():
        chances[i, j] = np.nan if chance is None else chance
    return chances


def _known(chart: Chart, file: Path) -> dict[tuple[int, int], float | None]:
    """Read what a file has of a chart; a last line that was not finished does not count."""
    if not file.exists() or not file.stat().st_size:
        return {}
    lines = file.read_text(encoding='utf-8').splitlines(keepends=True)
    if not lines[-1].endswith('\n'):
        file.write_text(''.join(lines := lines[:-1]), encoding='utf-8')
    found = list(_read(lines, file))
    if not found:
        return {}
    if found[0] != chart.says():
        raise ValueError(f'{file}: is of another atlas; take another file, or delete it')
    return {(i, j): chance for i, j, chance in found[1:]}


def _read(lines: Iterable[str], file: Path) -> Iterator[Any]:
    for number, line in enumerate(lines, 1):
        try:
            yield json.loads(line)
        except json.JSONDecodeError as error:
            raise ValueError(f'{file}: line {number}: {error}') from None

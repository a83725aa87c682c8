"""shots(): all direct shots of many tables at once, each with its stroke and its chance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.impact.options import BISTIFFNESS
from billiard_shot.notebook import Tabular
from billiard_shot.planning import direct_shots, pockets
from billiard_shot.planning.problem import limits_of
from billiard_shot.planning.within_noise import noise_of, strike_alone
from billiard_shot.records import Array, as_rows, column, Storage
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import A, B, ELEVATION, offset_columns, OFFSETS, SPEED
from billiard_shot.shot.effects import model_of, StrikeModel
from billiard_shot.shot.lowest_elevation import raising_of
from billiard_shot.table.model.geometry import POCKETS
from billiard_shot.table.motion.cloth import rolling_share
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.layout import lay_out
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import ManyStates, table_states, TableStates
from billiard_shot.table.run.task import in_threads

OFFSET = 0.02  # ball radii: error of a whose effect is extrapolated


@dataclass(frozen=True, eq=False)
class DirectShots(Tabular):
    """
    Direct shots of many tables, in the order of tables, balls and pockets.

    Attributes
    ----------
    names : tuple of str
        The balls.
    tables : int
        Number of tables.
    rows : (n,) array of DirectShot
        The rows that were found, of which all else are columns.
    table : (n,) int array
        The table of each shot.
    ball : (n,) int array
        The ball to be potted, as an index in `names`.
    pocket : (n,) int array
        As an index in `POCKET_NAMES`.
    cut : (n,) float array
        Angle between the paths of the cue ball and of the line of centres [rad], positive if the
        ball goes off to the left.
    distance : (n,) float array
        How far the cue ball goes to the ball [m].
    way : (n,) float array
        How far the ball goes to the middle of the hole [m].
    chance : (n,) float array
        Probability that the ball falls into the pocket, under the errors of the player. It does
        not say where the cue ball goes.

    """

    names: tuple[str, ...]
    tables: int
    rows: NDArray[np.void]
    table = column('rows', 'table')
    ball = column('rows', 'ball')
    pocket = column('rows', 'pocket')
    cut = column('rows', 'cut')
    distance = column('rows', 'distance')
    way = column('rows', 'way')
    chance = column('rows', 'chance')

    @cached_property
    def offsets(self) -> Array:
        """
        The strokes (n, 5): a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.

        They hit the middle of the cue ball, with the cue as low as clearance allows.
        """
        middle = np.zeros((2, len(self)))
        return np.column_stack([*middle, *(self.rows[name] for name in OFFSETS[ELEVATION:])])

    def __len__(self) -> int:
        """Return the number of shots."""
        return len(self.rows)

    def __repr__(self) -> str:
        return f'DirectShots({len(self)} on {self.tables} tables)'

    @property
    def best(self) -> Array:
        """Chance of the best shot of each table (tables,), 0 if there is none."""
        best = np.zeros(self.tables)
        np.maximum.at(best, self.table, self.chance)
        return best

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame`, with a row for each shot."""
        return {
            'table': self.table,
            'ball': [self.names[i] for i in self.ball.tolist()],
            'pocket': [POCKET_NAMES[i] for i in self.pocket.tolist()],
            'chance': self.chance,
            'cut_deg': np.degrees(self.cut),
            'distance': self.distance,
            'way': self.way,
            **offset_columns(self.offsets),
        }


def shots(
    scene: SceneLike,
    states: ManyStates,
    legal: Sequence[str] | ArrayLike | None = None,
    noise: str | Noise | Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> DirectShots:
    """
    Find the direct shots of many tables whose balls rest, and their chances.

    The cue ball sends the ball straight into the pocket. The chance follows from the geometry, the
    throw and the openings of the pockets, without a simulation of the shot: see docs/batches.md
    for its error. `plan` finds better strokes, and the other kinds of shots.

    Parameters
    ----------
    scene : Scene, str or Path
        With a table that has pockets; its sections `robot` and `noise` describe the player. Its
        balls do not count here.
    states : TableStates, mapping of str to BallState, or sequence of such mappings
        As of `simulate_batch`; velocities and spins do not count. The cue ball is `cue`. A table
        without the cue ball has no shots.
    legal : sequence of str, or (tables, balls) array_like of bool, optional
        The balls that may be potted; by default all but the cue ball.
    noise : str, Noise or mapping, optional
        As of `plan`.
    workers : int, optional
        Threads; by default as many as there are cores.

    Raises
    ------
    ValueError
        If the scene has no pockets or the tables have no cue ball, or a name or an array makes no
        sense.

    """
    scene = Scene.load(scene)
    if scene.table is None or not scene.table.pockets:
        raise ValueError('scene must have a table with pockets')
    tables = table_states(states)
    if CUE_BALL not in tables.names:
        got = ', '.join(tables.names)
        raise ValueError(f'states must have the ball {CUE_BALL!r}, got {got}')
    places, kinds = places_and_kinds(tables, _legal(tables.names, tables.present.shape, legal))
    cue = tables.names.index(CUE_BALL)
    kinds[:, cue] = np.minimum(kinds[:, cue], pockets.PRESENT)
    kinds[~np.isfinite(places).all(axis=(1, 2)), cue] = pockets.NO_BALL
    spread = noise_of(scene, noise)
    pockets.openings_of(*params_on_table(scene))  # once, before the threads

    def find(part: slice) -> NDArray[np.void]:
        run = direct_shots.find_direct_shots.current()
        *given, found = arguments_of(run.storage, scene, spread, places[part], kinds[part], cue)
        count = run(*given, found)
        rows = as_rows(direct_shots.DirectShot, found)[:count]
        rows['table'] += part.start
        return rows

    rows = np.concatenate(in_threads(find, len(tables), workers))
    return DirectShots(tables.names, len(tables), rows)


def arguments_of(
    storage: Storage, scene: Scene, noise: Noise, places: Array, kinds: NDArray[np.int64], cue: int
) -> tuple[Any, ...]:
    """Return the arguments of `find_direct_shots` for tables of a scene and a player."""
    params, table = params_on_table(scene)
    return (
        lay_out(storage, params, table),
        *map(storage.array, (pockets.openings_of(params, table), pockets.AXES, places, kinds)),
        cue,
        _player(storage, scene, noise, kinds.shape[1]),
        storage.records(
            direct_shots.DirectShot, POCKETS * int((kinds == pockets.LEGAL).sum()) + 1
        ),
    )


def places_and_kinds(
    tables: TableStates, legal: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.int64]]:
    """Return where balls lie (tables, balls, 2) [m], and their kinds; `legal` marks balls."""
    kinds = np.where(tables.present, pockets.PRESENT, pockets.NO_BALL)
    kinds[tables.present & legal] = pockets.LEGAL
    return np.where(tables.present[..., np.newaxis], tables.position[..., :2], 0.0), kinds


def _legal(
    names: tuple[str, ...], shape: tuple[int, ...], legal: Sequence[str] | ArrayLike | None
) -> NDArray[np.bool_]:
    """Read which balls may be potted, as a mask that has the shape (tables, balls) or (balls,)."""
    if legal is None:
        return np.ones(shape, np.bool_)
    given = np.asarray(legal)
    if given.dtype == np.bool_:
        if given.shape != shape:
            raise ValueError(f'legal must be of shape {shape}, got {given.shape}')
        return given
    wanted = [str(name) for name in given.ravel().tolist()]
    for name in wanted:
        if name not in names:
            raise ValueError(f'legal must be of {", ".join(names)}, got {name!r}')
    return np.array([name in wanted for name in names])


def _player(storage: Storage, scene: Scene, noise: Noise, balls: int) -> direct_shots.PlayerRecord:
    """Collect the strokes, the limits and the errors of a player, at tables with n balls."""
    limits = limits_of(scene, None, noise)
    robot, margins = limits.robot, limits.margins
    model = model_of(scene)
    strikes = strikes_of(model)
    playable = np.isfinite(strikes).all(axis=(0, 1))
    steepest = direct_shots.ELEVATION_STEP * (int(np.argmin(np.append(playable, False))) - 1)
    lowest, highest = limits.elevations
    a, _, _, azimuth, speed = noise.sigmas(scene.ball.radius).tolist()
    raising = raising_of(storage, scene, min(highest, steepest), margins.elevation)
    obstacles = raising.obstacles._replace(balls=storage.zeros(balls, 2))
    stroke = np.zeros(len(OFFSETS))
    stroke[B] = -margins.b
    return direct_shots.PlayerRecord(
        direct_shots.CentralStrikes(*(storage.array(np.nan_to_num(each)) for each in strikes)),
        a,
        azimuth,
        speed,
        noise.balls,
        model.tip_duration if model.law == BISTIFFNESS else 0.0,
        float(robot.speed_min),
        float(robot.speed_max),
        max(lowest, margins.elevation),
        raising._replace(obstacles=obstacles),
        storage.array(stroke),
    )


@lru_cache(maxsize=8)
def strikes_of(model: StrikeModel) -> direct_shots.CentralStrikes:
    """Solve strokes in the middle; NaN where they fail."""
    strokes = np.zeros((3, len(direct_shots.STRIKE_SPEEDS), direct_shots.ELEVATION_COUNT, 5))
    strokes[..., ELEVATION] = direct_shots.ELEVATION_STEP * np.arange(direct_shots.ELEVATION_COUNT)
    strokes[..., SPEED] = np.reshape(direct_shots.STRIKE_SPEEDS, (-1, 1))
    strokes[1, ..., A], strokes[2, ..., A] = -OFFSET, OFFSET
    struck = strike_alone(model, strokes.reshape(-1, 5))
    played = np.where(struck.fails, np.nan, 1.0).reshape(*strokes.shape[:-1], 1)
    velocity, surface = (
        played * each.reshape(*strokes.shape[:-1], 3) / strokes[..., [SPEED]]
        for each in struck[:2]
    )
    across, turning = ((each[2] - each[1]) / (2.0 * OFFSET) for each in (velocity, surface))
    # a ball that rolls has the angular momentum about its lowest point that it had before
    share = 1.0 / rolling_share(model.surface)
    rolling = (1.0 - share) * across[..., 1] - share * turning[..., 0]
    return direct_shots.CentralStrikes(
        forward=velocity[0, ..., 0],
        roll=surface[0, ..., 1],
        across=across[..., 1],
        rolling_across=rolling,
        side=turning[..., 2],
    )

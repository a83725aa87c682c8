"""Strokes to think of: places in hand, direct shots, safeties, breaks; all with clearance."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.rack import scene_of
from billiard_shot.game.referee import start
from billiard_shot.game.state import Call, Decision, Game, NO_CALL, State
from billiard_shot.game.valuation import EQUAL, rule_on, RuledBatch, values
from billiard_shot.planning.plan import cue_ball_at, places_all_over
from billiard_shot.planning.problem import limits_of, raise_for_clearance
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.planning.within_noise import along_azimuth, play_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.scene.player import AZIMUTH, ELEVATION, SPEED, with_errors
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.ghost_ball import grazing
from billiard_shot.shot.predict import predict_batch
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates

ROUNDING = 1e-9  # degrees


def raised(scene: Scene, offsets: Array) -> tuple[Array, NDArray[np.bool_]]:
    """
    Raise the cue as little as it needs for clearance, and keep the speed within its limits.

    Parameters
    ----------
    scene : Scene
        With its `robot`, `noise` and balls.
    offsets : (n, 5) float array

    Returns
    -------
    offsets : (n, 5) float array
        NaN for strokes without clearance.
    playable : (n,) bool array
        Whether a stroke is within the limits of the robot.

    """
    limits, robot = limits_of(scene, None, scene.noise), scene.robot
    found = offsets.copy()
    found[:, SPEED] = np.clip(found[:, SPEED], robot.speed_min, robot.speed_max)
    found = raise_for_clearance(scene, limits, found)
    return found, limits.allows_azimuth(offsets[:, AZIMUTH]) & np.isfinite(found).all(axis=1)


def playable_stroke(
    scene: Scene, degrees: Sequence[float], *, stated: bool, aimed: bool
) -> Stroke:
    """
    Make a stroke that its player can play in spite of its errors.

    Parameters
    ----------
    scene : Scene
        With its `robot`, `noise` and balls.
    degrees : sequence of 5 floats
        a, b, elevation, azimuth, speed as of `Stroke.from_offsets`; angles in degrees.
    stated : bool
        Whether the elevation is given; otherwise it is the lowest one with room for errors.
    aimed : bool
        Whether the azimuth is that of the cue ball, not of the cue: with side spin they differ.

    Raises
    ------
    ValueError
        If a number is beyond the limits of the scene, or the cue has no room for errors.

    """
    a, b, elevation, azimuth, speed = degrees
    wanted = Stroke.from_offsets(
        a, b, elevation_deg=elevation, azimuth_deg=azimuth, speed=speed
    ).offsets
    robot, highest = scene.robot, scene.robot.elevation_max_deg
    for name, value, low, high, unit in (
        ('distance from the middle', math.hypot(a, b), 0.0, robot.offset_max, 'ball radii'),
        ('ELEVATION', elevation, 0.0, highest, 'degrees'),
        ('SPEED', speed, robot.speed_min, robot.speed_max, 'm/s'),
    ):
        if not low <= value <= high:
            raise refused(value, f'{low:g} to {high:g}', name, unit)
    limits, row = limits_of(scene, None, scene.noise), np.array([wanted])
    row = raise_for_clearance(scene, limits, row)
    lowest = math.degrees(row[0, ELEVATION])
    if math.isnan(lowest):
        raise ValueError(f'the cue has no room there at any elevation up to {highest:g} degrees')
    if stated and lowest > elevation + ROUNDING:
        allowed = f'at least {math.ceil(10.0 * lowest) / 10.0:g}, to leave room for errors'
        raise refused(elevation, allowed, 'ELEVATION', 'degrees')
    if aimed:
        row = along_azimuth(model_of(scene), row)
    return Stroke.from_offsets(*row[0].tolist())


def places_to_try(state: State) -> Array:
    """List places (n, 2) [m], all over the table, where the cue ball in hand may lie."""
    places = places_all_over(state, state.in_hand)
    return places[[not state.no_place(x, y) for x, y in places.tolist()]]


def direct_shots(scene: Scene, state: State, places: Array | None = None) -> DirectShots:
    """
    Find the direct shots of the player at the table.

    Parameters
    ----------
    scene : Scene
        Table, noise and limits.
    state : State
    places : (n, 2) float array, optional
        Places of the cue ball [m], one for each table; by default that of the state.

    """
    return shots(scene, placed(state, places), state.game.targets(state))


class ListedShot(NamedTuple):
    """A direct shot as people choose it."""

    call: Call
    chance: float  # that the ball falls
    azimuth: float  # of the path of the cue ball [rad]
    speed: float  # of the cue [m/s]


def listed_shots(scene: Scene, state: State) -> list[ListedShot]:
    """List the direct shots of a state, the best chance first; none without pockets."""
    if not state.game.pockets:
        return []
    direct = direct_shots(scene, state)
    best_first = np.argsort(-direct.chance, kind='stable').tolist()
    return [
        ListedShot(
            call_of(direct, i),
            float(direct.chance[i]),
            *direct.offsets[i, [AZIMUTH, SPEED]].tolist(),
        )
        for i in best_first
    ]


def call_of(direct: DirectShots, number: int) -> Call:
    """Call a direct shot."""
    ball, pocket = int(direct.ball[number]), int(direct.pocket[number])
    return Call(ball=direct.names[ball], pocket=POCKET_NAMES[pocket])


def placed(state: State, places: Array | None = None) -> TableStates:
    """Return the balls of a state as an array of tables; see `direct_shots`."""
    if places is None:
        places = np.array([state.balls[CUE_BALL]])
    others = {ball: state.balls[ball] for ball in state.object_balls}
    return cue_ball_at(places, others, state.radius)


FULLNESS = 0.0, 0.3, -0.3, 0.6, -0.6, 0.85, -0.85, 0.97, -0.97  # of the line past the ball
SOFT = 0.5, 1.0, 1.7, 2.8  # m/s of the cue
KICK_SPEEDS = 1.5, 2.5  # m/s of the cue
KICKS = 120  # directions of strokes by cushions


def towards(scene: Scene, balls: tuple[str, ...]) -> Array:
    """List strokes (n, 5) straight at balls, full to thin, at several speeds."""
    x, y = scene.balls[CUE_BALL]
    rows = []
    for ball in balls:
        along, across = scene.balls[ball][0] - x, scene.balls[ball][1] - y
        half = grazing(math.hypot(along, across), 2.0 * scene.ball.radius)
        for full in FULLNESS:
            azimuth = math.atan2(across, along) + full * half
            rows += [(0.0, b, 0.0, azimuth, speed) for speed in SOFT for b in (0.0, -0.25)]
    offsets, playable = raised(scene, np.array(rows).reshape(-1, 5))
    return offsets[playable]


def all_round(scene: Scene) -> Array:
    """List strokes (n, 5) in all directions: most balls can be met by cushions."""
    azimuths = np.linspace(-math.pi, math.pi, KICKS, endpoint=False)
    rows = [(0.0, 0.0, 0.0, azimuth, speed) for azimuth in azimuths for speed in KICK_SPEEDS]
    offsets, playable = raised(scene, np.array(rows))
    return offsets[playable]


def hit_something(scene: Scene, state: State) -> Decision:
    """
    Decide on any stroke that meets a legal ball first; none if there is no such stroke.

    It is not to keep the turn: a call says so, or else the stated chance.
    """
    targets = state.game.targets(state)
    for offsets in (towards(scene, targets), all_round(scene)):
        run = predict_batch(scene, offsets=offsets)
        wanted = [run.names.index(ball) for ball in targets]
        met = np.isin(run.first_met[:, run.names.index(CUE_BALL)], wanted)
        legal = np.flatnonzero(met & ~run.miscue)
        if len(legal):
            stroke = Stroke.from_offsets(*offsets[legal[-1]].tolist())
            alone = state.game.players == 1  # then a safety ends the visit, and with it the rack
            call = Call(safety=True) if state.game.calls and not alone else NO_CALL
            success = None if call.passes else 0.0
            return Decision(stroke, call, success=success, reason='no direct shot')
    return Decision(reason='no stroke meets a legal ball')


def break_stroke(scene: Scene) -> Stroke:
    """Return the stroke at the ball nearest to the head of the table, as hard as the robot can."""
    x, y = scene.balls[CUE_BALL]
    apex = min(scene.object_balls.values(), key=lambda place: place[0])
    azimuth = math.atan2(apex[1] - y, apex[0] - x)
    offsets = np.array([[0.0, 0.0, 0.0, azimuth, scene.robot.speed_max]])
    return Stroke.from_offsets(*raised(scene, offsets)[0][0].tolist())


# The cue ball lies close behind the head string: all breaks from further back were worse. The
# distance is relative to the length; places beside the long string are relative to the width.
# Points that are aimed at: sideways of the apex ball, in ball radii. Points of contact of the tip:
# b, in ball radii.
BEHIND, PLACES_BESIDE = 0.01, (0.0, 0.15, 0.3, 0.44)
AIMS, BREAK_TIPS = (-0.3, 0.0, 0.3), (-0.15, 0.1)
# Racks of each round, the same ones for all breaks, and how many breaks at most go on after one. A
# break that is worse than the best one by so many standard errors of the difference does not.
BREAK_ROUNDS, BREAKS_LEFT, SURELY = (12, 24, 24), 8, 2.0


def best_break(scene: Scene, game: Game | str) -> tuple[Place, Stroke]:
    """
    Return the place of the cue ball (x, y) [m] and the stroke of the break that is best.

    The best break has the largest mean value of the states that it leaves. Of breaks that may be
    equally good, it is the one that keeps the turn most often.
    """
    return _search(replace(scene, balls={}), game)


def best_break_of(scene: Scene, state: State) -> Stroke:
    """Return the best break of a state whose cue ball lies where it may not be placed anew."""
    strokes = break_strokes(scene, state)
    batch = break_racks(scene, state, strokes, range(sum(BREAK_ROUNDS)))
    won = values(scene, state.player, batch, EQUAL).reshape(len(strokes), -1).mean(axis=1)
    return Stroke.from_offsets(*strokes[np.argmax(won), 2:].tolist())


@lru_cache(maxsize=16)
def _search(scene: Scene, game: Game | str) -> tuple[Place, Stroke]:
    strokes = break_strokes(scene, start(game, scene))
    found = np.zeros((2, len(strokes), 0))  # the value of each rack, and whether the turn is kept
    for racks in BREAK_ROUNDS:
        seeds = range(found.shape[2], found.shape[2] + racks)
        batch = break_racks(scene, game, strokes, seeds)
        new = np.array([values(scene, 0, batch, EQUAL), batch.keeps(0)])
        found = np.concatenate([found, new.reshape(2, len(strokes), racks)], axis=2)
        won = found[0]
        order = np.argsort(-won.mean(axis=1), kind='stable')[:BREAKS_LEFT]
        behind = won[order[0]] - won[order]
        error = behind.std(axis=1) / math.sqrt(won.shape[1])
        going = order[behind.mean(axis=1) <= SURELY * error]
        strokes, found = strokes[going], found[:, going]
    x, y, *offsets = strokes[np.argmax(found[1].mean(axis=1))].tolist()
    return (x, y), Stroke.from_offsets(*offsets)


def break_strokes(scene: Scene, state: State) -> Array:
    """
    List breaks (n, 7): place x, y of the cue ball [m], and the offsets of the stroke.

    The cue ball is placed if it is in hand. They aim at the ball that is nearest to the head.
    """
    balls = (place for ball, place in state.balls.items() if ball != CUE_BALL)
    apex = min(balls, key=lambda place: place[0])
    x, speed = -(0.25 + BEHIND) * state.length, scene.robot.speed_max
    placed = [state]
    if state.places_cue_ball:
        placed = [state.with_cue_ball(x, beside * state.width) for beside in PLACES_BESIDE]
    found = []
    for there in placed:
        x, y = there.balls[CUE_BALL]
        rows = [
            (0.0, b, 0.0, math.atan2(apex[1] + aim * state.radius - y, apex[0] - x), speed)
            for aim, b in itertools.product(AIMS, BREAK_TIPS)
        ]
        offsets, playable = raised(scene_of(scene, there), np.array(rows))
        places = np.broadcast_to((x, y), (len(offsets), 2))
        found.append(np.column_stack([places, offsets])[playable])
    return np.concatenate(found)


def break_racks(
    scene: Scene, game: Game | str | State, strokes: Array, seeds: range
) -> RuledBatch:
    """
    Play breaks with the errors of the player; a stroke without room for the cue is refused.

    Parameters
    ----------
    scene : Scene
    game : Game, str or State
        Racked anew for each seed, or a state with the cue ball placed, for all of them.
    strokes : (n, 7) float array
        See `break_strokes`.
    seeds : range
        Of racks and errors, the same ones for each break.

    Returns
    -------
    RuledBatch
        (n racks,), all racks of the first break, then of the next one.

    """
    if isinstance(game, State):
        states = [game] * len(seeds)
    else:
        place = strokes[0, :2].tolist()
        states = [start(game, scene, seed).with_cue_ball(*place) for seed in seeds]
    names = tuple(sorted(states[0].balls, key=lambda ball: ball != CUE_BALL))
    position = np.full((len(strokes), len(states), len(names), 3), scene.ball.radius)
    position[..., :2] = [[state.balls[name] for name in names] for state in states]
    position[:, :, 0, :2] = strokes[:, np.newaxis, :2]
    draws = [np.random.default_rng(seed).standard_normal(5) for seed in seeds]
    sigmas = scene.noise.sigmas(scene.ball.radius)
    errors = np.array(draws) * sigmas
    played = with_errors(strokes[:, np.newaxis, 2:], errors).reshape(-1, 5)
    tables = TableStates(names, position.reshape(-1, len(names), 3))
    run = play_within_noise(scene, played, sigmas, tables)
    return rule_on(states[0], [NO_CALL] * len(played), run)

"""Ideas of a player: strokes with their calls, played with the errors of the player and valued."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game import valuation
from billiard_shot.game.state import Call, NO_CALL, State
from billiard_shot.game.strokes import all_round, call_of, raised, towards
from billiard_shot.planning import within_noise
from billiard_shot.planning.plan import candidates
from billiard_shot.planning.problem import places_around
from billiard_shot.planning.shots import DirectShots
from billiard_shot.planning.targets import Pot
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import A, AZIMUTH, B, SPEED, with_errors
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.play import StrokeBatch
from billiard_shot.table.model.motion import NOTHING
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates

FOLLOWED_ENDS = 1 / 6  # share of the end states of a stroke whose next shots are followed


class Position(NamedTuple):
    """A state with the cue ball placed, the scene with its balls, and how well both play."""

    state: State
    scene: Scene
    skills: valuation.Skills = valuation.EQUAL


class Idea(NamedTuple):
    """A stroke to be tried with errors."""

    position: Position
    offsets: Array  # (5,) a, b, elevation, azimuth, speed
    call: Call
    guess: float  # its value without errors, times the chance of its shot


class RatedIdea(NamedTuple):
    """An idea that was tried with errors."""

    idea: Idea
    value: float  # mean
    success: float  # share of the executions that keep the turn
    turn: float = 0.0  # rad: mean error of the azimuth of these

    @property
    def turned(self) -> Idea:
        """The idea with its azimuth in the middle of those that kept the turn."""
        offsets = self.idea.offsets.copy()
        if not self.idea.call.passes:
            offsets[AZIMUTH] += self.turn
        return self.idea._replace(offsets=offsets)


def rule_strokes(
    position: Position, run: StrokeBatch, calls: Sequence[Call], plies: int = 1
) -> tuple[valuation.RuledBatch, NDArray[np.bool_], Array]:
    """
    Rule on strokes that were played, m for each of n calls, one call after the other.

    Returns the rulings (n m,), whether each stroke keeps the turn (n, m), and its value (n, m) by
    the next shot; with no ply, whether the turn is kept. For `plies` see `rate`.
    """
    state, scene, skills = position
    shape = len(calls), len(run.status) // len(calls)
    every = [call for call in calls for _ in range(shape[1])]
    batch = valuation.rule_on(state, every, run)
    kept = batch.keeps(state.player)
    value = valuation.values(scene, state.player, batch, skills) if plies else kept.astype(float)
    return batch, kept.reshape(shape), value.reshape(shape)


def rate(
    ideas: Sequence[Idea], errors: Array, plies: int, draw: np.random.Generator
) -> list[RatedIdea]:
    """
    Try ideas with the same errors.

    Parameters
    ----------
    ideas : sequence of Idea
    errors : (samples, 5) float array
        Added to a, b, elevation, azimuth and speed.
    plies : int
        2: end states in which the turn goes on are valued by two shots; 1: by the next shot, see
        `values`; 0: the value is the success.
    draw : numpy.random.Generator
        Of the places of the balls, if they are not exact.

    """
    rated: list[RatedIdea] = []
    for position in {id(idea.position): idea.position for idea in ideas}.values():
        own = [idea for idea in ideas if idea.position is position]
        strokes = with_errors(np.array([idea.offsets for idea in own])[:, np.newaxis], errors)
        run = _tried(position.scene, strokes.reshape(-1, 5), len(errors), draw)
        batch, kept, value = rule_strokes(position, run, [idea.call for idea in own], plies)
        mean, success = value.mean(axis=1), kept.mean(axis=1)
        if plies > 1:
            some = kept & (np.cumsum(kept, axis=1) <= max(1, round(FOLLOWED_ENDS * len(errors))))
            some[[idea.call.passes for idea in own]] = False
            chosen = np.flatnonzero(some)
            first = value.ravel()[chosen]
            change = np.zeros(value.shape)
            change.ravel()[chosen] = _second(position, batch.take(chosen), first) - first
            mean += success * change.sum(axis=1) / np.maximum(some.sum(axis=1), 1)
        turn = (kept @ errors[:, AZIMUTH]) / np.maximum(kept.sum(axis=1), 1)
        rated += map(RatedIdea, own, mean.tolist(), success.tolist(), turn.tolist())
    return rated


def _second(position: Position, batch: valuation.RuledBatch, first: Array) -> Array:
    state, scene, skills = position
    return valuation.second_ply(scene, state.player, batch, first, skills)


def _tried(scene: Scene, strokes: Array, samples: int, draw: np.random.Generator) -> StrokeBatch:
    """
    Play strokes (n samples, 5) on tables whose object balls lie a little beside their places.

    So balls that touch have gaps, or touch elsewhere. All places are relative to the cue ball. The
    same tables are drawn for each of the n strokes.
    """
    sigma = scene.noise.balls
    if not sigma or scene.table is None:
        return within_noise.predict_within_noise(scene, strokes)
    names = tuple(sorted(scene.balls, key=lambda ball: ball != CUE_BALL))
    believed, radius = np.array([scene.balls[name] for name in names]), scene.ball.radius
    half = 0.5 * np.array([scene.table.length, scene.table.width]) - radius
    places = places_around(believed, sigma, half, radius, draw, samples)
    places += believed[0] - places[:, :1]
    position = np.full((*places.shape[:2], 3), radius)
    position[..., :2] = places
    tables = TableStates(names, np.tile(position, (len(strokes) // samples, 1, 1)))
    return within_noise.play_within_noise(scene, strokes, scene.noise.sigmas(radius), tables)


SPEED_FACTORS = 0.75, 1.0, 1.4, 2.0  # relative to the speed of the direct shot
BREAK_FACTORS = 3.2, 4.5  # with which a rack is broken that follows another one
# a and b, relative to the largest offset of the robot: stun, draw and follow, and side spin
TIP_OFFSETS = (
    (0.0, 0.0),
    (0.0, 0.4),
    (0.0, 0.8),
    (0.0, -0.4),
    (0.0, -0.8),
    (0.5, 0.0),
    (-0.5, 0.0),
    (0.5, 0.5),
    (-0.5, 0.5),
)
# Changes of the direction of the ball [rad] that are tried for each stroke, because of throw.
AIM_CHANGES = np.radians([-3.0, -1.5, 0.0, 1.5, 3.0])
FOLLOWED = 5  # strokes of a direct shot, in the mean, whose end states are followed by another
MIN_POTTING_DIRECTIONS = 3  # directions that have to pot; with fewer the guess is smaller
SAFETY_BALLS = 4  # balls at which safeties are aimed
HEIGHT, FASTER = 0.1, 0.2  # standard deviations of variations: of b, and of the logarithm of speed
INDIRECT = 1500  # simulated strokes of a search for combinations and cushions
INDIRECT_CHANCE = 0.5  # chance of such a stroke, before it is tried with errors


def pots(
    position: Position, direct: DirectShots, which: NDArray[np.int64], tips: int, plies: int
) -> list[Idea]:
    """
    Aim strokes of direct shots, at several speeds and points of contact.

    Parameters
    ----------
    position : Position
    direct : DirectShots
    which : (k,) int array
        Of these shots.
    tips : int
        Points of contact of the tip.
    plies : int
        As of `rate`.

    """
    state, scene, _ = position
    racked = state.game.reracked and len(state.object_balls) == len(state.game.balls)
    factors = SPEED_FACTORS + (BREAK_FACTORS if racked else ())
    offsets, shot = _aimed(scene, direct, which, tips, factors)
    if not len(shot):
        return []
    turns = AIM_CHANGES * (
        2.0
        * scene.ball.radius
        * np.cos(direct.cut[shot, np.newaxis])
        / direct.distance[shot, np.newaxis]
    )
    tried = np.repeat(offsets[:, np.newaxis], len(AIM_CHANGES), axis=1)
    tried[..., AZIMUTH] += turns
    calls = [call_of(direct, number) for number in shot.tolist()]
    run = within_noise.predict_within_noise(scene, tried.reshape(-1, 5))
    batch, kept, value = rule_strokes(position, run, calls, plies)
    # Aim at the middle of the directions that pot.
    count = np.maximum(kept.sum(axis=1), 1)
    middle = (kept * turns).sum(axis=1) / count
    offsets[:, AZIMUTH] += middle
    guess = (kept * value).sum(axis=1) / count
    if plies > 1:
        best = np.argsort(-guess, kind='stable')[: FOLLOWED * len(which)]
        best = best[kept[best].any(axis=1)]
        away = np.abs(np.where(kept, turns - middle[:, np.newaxis], np.inf))
        chosen = best * len(AIM_CHANGES) + np.argmin(away[best], axis=1)
        first = value.ravel()[chosen]
        guess[best] += _second(position, batch.take(chosen), first) - first
    share = np.minimum(kept.sum(axis=1), MIN_POTTING_DIRECTIONS) / MIN_POTTING_DIRECTIONS
    guess *= direct.chance[shot] * share
    offsets, playable = raised(scene, offsets)  # which are turned since
    return _ideas(position, offsets, calls, guess * playable)


def _aimed(
    scene: Scene,
    direct: DirectShots,
    which: NDArray[np.int64],
    tips: int,
    factors: tuple[float, ...],
) -> tuple[Array, NDArray[np.int64]]:
    """Make strokes (n, 5) of several speeds and spins, and the numbers (n,) of their shots."""
    grid = np.array([(a, b, factor) for a, b in TIP_OFFSETS[:tips] for factor in factors])
    shot = np.repeat(which, len(grid))
    offsets = direct.offsets[shot].copy()
    a, b, factor = np.tile(grid, (len(which), 1)).T
    offsets[:, A], offsets[:, B] = scene.robot.offset_max * a, scene.robot.offset_max * b
    offsets[:, SPEED] *= factor
    offsets, playable = raised(scene, offsets)
    offsets, shot = offsets[playable], shot[playable]
    aside = offsets[:, A] != 0.0  # without side spin the ball goes straight on
    offsets[aside] = within_noise.along_azimuth(model_of(scene), offsets[aside])
    return offsets, shot


def indirect_pots(position: Position) -> list[Idea]:
    """Search for combinations, kicks and banks that keep the turn."""
    state, scene, _ = position
    rules = state.game
    wanted = rules.targets(state) if rules.calls else state.object_balls
    constraints = {'first_contact': rules.targets(state)}
    try:
        found = candidates(scene, Pot(wanted), budget=INDIRECT, constraints=constraints)
    except ValueError:  # the cue has no clearance in any direction
        return []
    offsets = found.offsets[found.penalty == 0.0]
    if not len(offsets):
        return []
    run = within_noise.predict_within_noise(scene, offsets)
    balls = [run.names.index(ball) for ball in wanted]
    first = np.argmax(run.pocket[:, balls] != NOTHING, axis=1)
    calls = [
        Call(ball=wanted[i], pocket=POCKET_NAMES[row[balls[i]]]) if row[balls[i]] >= 0 else NO_CALL
        for i, row in zip(first.tolist(), run.pocket.tolist(), strict=True)
    ]
    _, kept, value = rule_strokes(position, run, calls)
    return _ideas(position, offsets, calls, (kept * value)[:, 0] * INDIRECT_CHANCE)


def safeties(position: Position) -> list[Idea]:
    """
    List strokes at the nearest balls, and all round, as safeties and as push-outs.

    In a game without calls a ball that falls keeps the turn: there they are strokes as any other.
    """
    state, scene, _ = position
    x, y = state.balls[CUE_BALL]
    near = sorted(
        state.game.targets(state),
        key=lambda ball: np.hypot(state.balls[ball][0] - x, state.balls[ball][1] - y),
    )
    offsets = np.concatenate([towards(scene, tuple(near[:SAFETY_BALLS])), all_round(scene)])
    if not len(offsets):
        return []
    kinds = [Call(safety=True) if state.game.calls else NO_CALL]
    if state.phase == 'second':
        kinds.append(Call(push_out=True))
    result, found = within_noise.predict_within_noise(scene, offsets), []
    for kind in kinds:
        calls = [kind] * len(offsets)
        _, _, value = rule_strokes(position, result, calls)
        found += _ideas(position, offsets, calls, value[:, 0])
    return found


def variations(idea: Idea, count: int, draw: np.random.Generator) -> list[Idea]:
    """Vary height of the tip, azimuth and speed of an idea at random."""
    scene = idea.position.scene
    offsets = np.repeat(idea.offsets[np.newaxis], count, axis=0)
    change = draw.standard_normal((count, 3))
    offsets[:, B] += HEIGHT * change[:, 0]
    offsets[:, AZIMUTH] += scene.noise.sigmas(scene.ball.radius)[AZIMUTH] * change[:, 1]
    offsets[:, SPEED] *= np.exp(FASTER * change[:, 2])
    offsets, playable = raised(scene, offsets)
    playable &= ~within_noise.strike_alone(
        model_of(scene), offsets
    ).fails  # with wider offsets tips slide
    playable &= np.hypot(offsets[:, A], offsets[:, B]) <= scene.robot.offset_max
    return _ideas(idea.position, offsets, [idea.call] * count, playable.astype(float))


def _ideas(position: Position, offsets: Array, calls: list[Call], guess: Array) -> list[Idea]:
    """List the strokes whose guess is above zero."""
    return [
        Idea(position, offsets[i], calls[i], float(guess[i]))
        for i in np.flatnonzero(guess > 0.0).tolist()
    ]

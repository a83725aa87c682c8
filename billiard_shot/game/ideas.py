"""Ideas: strokes that a player thinks of, with their calls; each played once without errors."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.agent import scene_of
from billiard_shot.game.batch_outcomes import rule_on, RuledBatch
from billiard_shot.game.call import Call, NO_CALL
from billiard_shot.game.clearance import raised
from billiard_shot.game.game import find_game
from billiard_shot.game.pot_candidates import pot_candidates
from billiard_shot.game.safe_stroke import all_round, towards
from billiard_shot.game.second_ply import second_ply
from billiard_shot.game.state import State
from billiard_shot.game.valuation import values
from billiard_shot.planning.candidate_strokes import candidates
from billiard_shot.planning.limits import A, AZIMUTH, B, SPEED
from billiard_shot.planning.shots import DirectShots
from billiard_shot.planning.targets import Pot
from billiard_shot.planning.within_noise import predict_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.run import POCKET_NAMES

FOLLOWED = 60  # pots whose end states are followed by a second shot
MIN_POTTING_DIRECTIONS = 3  # directions that have to pot; with fewer the guess is smaller
SAFETY_BALLS = 4  # balls at which safeties are aimed
HEIGHT, FASTER = 0.1, 0.2  # standard deviations of variations: of b, and of the logarithm of speed
INDIRECT = 1500  # simulated strokes of a search for combinations and cushions
INDIRECT_CHANCE = 0.5  # chance of such a stroke, before it is tried with errors


class Position(NamedTuple):
    """A state with the cue ball placed, and the scene with its balls."""

    state: State
    scene: Scene

    def play(self, offsets: Array, calls: list[Call]) -> RuledBatch:
        """Play strokes (n, 5) as accurately as the errors of the player call for."""
        return rule_on(self.state, calls, predict_within_noise(self.scene, offsets))


class Idea(NamedTuple):
    """
    A stroke to be tried with errors.

    Attributes
    ----------
    position : Position
    offsets : (5,) float array
    call : Call
    guess : float
        Its value without errors, times the chance of its shot.

    """

    position: Position
    offsets: Array
    call: Call
    guess: float


def position_of(scene: Scene, state: State) -> Position:
    """Return the position of a state whose cue ball is placed."""
    return Position(state, scene_of(scene, state))


def call_of(direct: DirectShots, number: int) -> Call:
    """Call a direct shot."""
    ball, pocket = int(direct.ball[number]), int(direct.pocket[number])
    return Call(ball=direct.names[ball], pocket=POCKET_NAMES[pocket])


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
    state, scene = position
    made = pot_candidates(scene, direct, which, tips=tips)
    count, turns = made.offsets.shape[:2]
    if not count:
        return []
    calls = [call_of(direct, shot) for shot in made.shot.tolist()]
    batch = position.play(
        made.offsets.reshape(-1, 5), [call for call in calls for _ in range(turns)]
    )
    kept = batch.keeps(state.player).reshape(count, turns)
    value = kept.astype(float)
    if plies > 0:
        value = values(scene, state.player, batch).reshape(count, turns)
    # Aim at the middle of the directions that pot.
    weight = kept.sum(axis=1)
    middle = (kept * np.arange(turns)).sum(axis=1) / np.maximum(weight, 1)
    low = np.floor(middle).astype(int)
    rows, high = np.arange(count), np.minimum(low + 1, turns - 1)
    part = (middle - low)[:, np.newaxis]
    offsets = made.offsets[rows, low] * (1.0 - part) + made.offsets[rows, high] * part
    guess = (kept * value).sum(axis=1) / np.maximum(weight, 1)
    if plies > 1:
        best = np.argsort(-guess, kind='stable')[:FOLLOWED]
        best = best[weight[best] > 0]
        away = np.abs(np.where(kept, np.arange(turns), np.inf) - middle[:, np.newaxis])
        chosen = best * turns + np.argmin(away[best], axis=1)
        first = value.ravel()[chosen]
        guess[best] += second_ply(scene, state.player, batch.take(chosen), first) - first
    guess *= (
        direct.chance[made.shot]
        * np.minimum(weight, MIN_POTTING_DIRECTIONS)
        / MIN_POTTING_DIRECTIONS
    )
    offsets, playable = raised(scene, offsets)  # which are turned since
    return _ideas(position, offsets, calls, guess * playable)


def indirect_pots(position: Position) -> list[Idea]:
    """Search for combinations, kicks and banks that keep the turn."""
    state, scene = position
    rules = find_game(state.game)
    wanted = rules.targets(state) if rules.calls else state.object_balls
    constraints = {'first_contact': rules.targets(state)}
    try:
        found = candidates(scene, Pot(wanted), budget=INDIRECT, constraints=constraints)
    except ValueError:  # the cue has no clearance in any direction
        return []
    offsets = found.offsets[found.penalty == 0.0]
    if not len(offsets):
        return []
    run = predict_within_noise(scene, offsets).run
    balls = [run.names.index(ball) for ball in wanted]
    first = np.argmax(run.pocket[:, balls] != NOTHING, axis=1)
    calls = [
        Call(ball=wanted[i], pocket=POCKET_NAMES[row[balls[i]]]) if row[balls[i]] >= 0 else NO_CALL
        for i, row in zip(first.tolist(), run.pocket.tolist(), strict=True)
    ]
    batch = position.play(offsets, calls)
    guess = values(scene, state.player, batch) * batch.keeps(state.player) * INDIRECT_CHANCE
    return _ideas(position, offsets, calls, guess)


def safeties(position: Position) -> list[Idea]:
    """List strokes at the nearest balls, and all round, as safeties."""
    state, scene = position
    x, y = state.balls[CUE_BALL]
    near = sorted(
        find_game(state.game).targets(state),
        key=lambda ball: np.hypot(state.balls[ball][0] - x, state.balls[ball][1] - y),
    )
    offsets = np.concatenate([towards(scene, tuple(near[:SAFETY_BALLS])), all_round(scene)])
    if not len(offsets):
        return []
    calls = [Call(safety=True)] * len(offsets)
    guess = values(scene, state.player, position.play(offsets, calls))
    return _ideas(position, offsets, calls, guess)


def variations(idea: Idea, count: int, draw: np.random.Generator) -> list[Idea]:
    """Vary height of the tip, azimuth and speed of an idea at random."""
    scene = idea.position.scene
    offsets = np.repeat(idea.offsets[np.newaxis], count, axis=0)
    change = draw.standard_normal((count, 3))
    offsets[:, B] += HEIGHT * change[:, 0]
    offsets[:, AZIMUTH] += scene.noise.sigmas(scene.ball.radius)[AZIMUTH] * change[:, 1]
    offsets[:, SPEED] *= np.exp(FASTER * change[:, 2])
    offsets, playable = raised(scene, offsets)
    playable &= np.hypot(offsets[:, A], offsets[:, B]) <= scene.robot.offset_max
    return _ideas(idea.position, offsets, [idea.call] * count, playable.astype(float))


def _ideas(position: Position, offsets: Array, calls: list[Call], guess: Array) -> list[Idea]:
    """List the strokes whose guess is above zero."""
    return [
        Idea(position, offsets[i], calls[i], float(guess[i]))
        for i in np.flatnonzero(guess > 0.0).tolist()
    ]

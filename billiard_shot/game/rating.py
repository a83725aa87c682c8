"""Ideas played with the errors of the player: value, success, and where they succeed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.batch_outcomes import rule_on, RuledBatch
from billiard_shot.game.call import Call
from billiard_shot.game.second_ply import second_ply
from billiard_shot.game.state import State
from billiard_shot.game.valuation import values
from billiard_shot.planning.within_noise import predict_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.player import AZIMUTH, with_errors
from billiard_shot.shot.stroke_batch import StrokeBatch

FOLLOWED_ENDS = 8  # end states of a stroke whose next shots are followed


class Position(NamedTuple):
    """A state with the cue ball placed, and the scene with its balls."""

    state: State
    scene: Scene


class Idea(NamedTuple):
    """A stroke to be tried with errors."""

    position: Position
    offsets: Array  # (5,) a, b, elevation, azimuth, speed
    call: Call
    guess: float  # its value without errors, times the chance of its shot


class Rated(NamedTuple):
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
) -> tuple[RuledBatch, NDArray[np.bool_], Array]:
    """
    Rule on strokes that were played, m for each of n calls, one call after the other.

    Returns the rulings (n m,), whether each stroke keeps the turn (n, m), and its value (n, m) by
    the next shot; with no ply, whether the turn is kept. For `plies` see `rate`.
    """
    state, scene = position
    shape = len(calls), len(run.status) // len(calls)
    every = [call for call in calls for _ in range(shape[1])]
    batch = rule_on(state, every, run)
    kept = batch.keeps(state.player)
    value = values(scene, state.player, batch) if plies else kept.astype(float)
    return batch, kept.reshape(shape), value.reshape(shape)


def rate(ideas: Sequence[Idea], errors: Array, plies: int) -> list[Rated]:
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

    """
    rated: list[Rated] = []
    for position in {id(idea.position): idea.position for idea in ideas}.values():
        own = [idea for idea in ideas if idea.position is position]
        strokes = with_errors(np.array([idea.offsets for idea in own])[:, np.newaxis], errors)
        run = predict_within_noise(position.scene, strokes.reshape(-1, 5))
        batch, kept, value = rule_strokes(position, run, [idea.call for idea in own], plies)
        mean, success = value.mean(axis=1), kept.mean(axis=1)
        if plies > 1:
            some = kept & (np.cumsum(kept, axis=1) <= FOLLOWED_ENDS)
            some[[idea.call.passes for idea in own]] = False
            chosen = np.flatnonzero(some)
            first = value.ravel()[chosen]
            change = np.zeros(value.shape)
            second = second_ply(position.scene, position.state.player, batch.take(chosen), first)
            change.ravel()[chosen] = second - first
            mean += success * change.sum(axis=1) / np.maximum(some.sum(axis=1), 1)
        turn = (kept @ errors[:, AZIMUTH]) / np.maximum(kept.sum(axis=1), 1)
        rated += map(Rated, own, mean.tolist(), success.tolist(), turn.tolist())
    return rated

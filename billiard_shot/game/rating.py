"""Ideas tried with the errors of the player: value, success, and where they succeed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from billiard_shot.game.ideas import Idea
from billiard_shot.game.second_ply import second_ply
from billiard_shot.game.valuation import values
from billiard_shot.planning.limits import AZIMUTH
from billiard_shot.records import Array
from billiard_shot.scene.player import with_errors

FOLLOWED_ENDS = 8  # end states of a stroke whose next shots are followed


class Rated(NamedTuple):
    """
    An idea with its value and success under errors.

    Attributes
    ----------
    idea : Idea
    value, success : float
        Mean value; share of the executions that keep the turn.
    turn : float
        Mean error of the azimuth of these executions [rad].

    """

    idea: Idea
    value: float
    success: float
    turn: float = 0.0

    @property
    def turned(self) -> Idea:
        """The idea with its azimuth in the middle of those that kept the turn."""
        offsets = self.idea.offsets.copy()
        if not self.idea.call.safety:
            offsets[AZIMUTH] += self.turn
        return self.idea._replace(offsets=offsets)


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
    samples = len(errors)
    for position in {id(idea.position): idea.position for idea in ideas}.values():
        own = [idea for idea in ideas if idea.position is position]
        state, scene = position
        played = with_errors(np.array([idea.offsets for idea in own])[:, np.newaxis], errors)
        calls = [idea.call for idea in own for _ in range(samples)]
        batch = position.play(played.reshape(-1, 5), calls)
        kept = batch.keeps(state.player).reshape(-1, samples)
        value = kept.astype(float)
        if plies > 0:
            value = values(scene, state.player, batch).reshape(-1, samples)
        mean, success = value.mean(axis=1), kept.mean(axis=1)
        if plies > 1:
            pots = np.array([not idea.call.safety for idea in own])
            some = kept & (np.cumsum(kept, axis=1) <= FOLLOWED_ENDS) & pots[:, np.newaxis]
            chosen = np.flatnonzero(some)
            first = value.ravel()[chosen]
            change = np.zeros(value.shape)
            second = second_ply(scene, state.player, batch.take(chosen), first)
            change.ravel()[chosen] = second - first
            mean += success * change.sum(axis=1) / np.maximum(some.sum(axis=1), 1)
        turn = (kept @ errors[:, AZIMUTH]) / np.maximum(kept.sum(axis=1), 1)
        rated += map(Rated, own, mean.tolist(), success.tolist(), turn.tolist())
    return rated

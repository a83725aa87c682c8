"""
The agent `player`: the shot with the largest probability to win the rack, the leave included.

It tries direct shots at several speeds and spins, without errors at first; then the best of them
with the errors of the player. Each end state is valued by what can follow. If no pot is good,
combinations, cushions, safeties and push-outs compete with the pots by the same values.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
import math
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game import strokes, valuation
from billiard_shot.game.ideas import (
    Idea,
    indirect_pots,
    Position,
    pots,
    rate,
    RatedIdea,
    safeties,
    variations,
)
from billiard_shot.game.rack import scene_of
from billiard_shot.game.referee import choose
from billiard_shot.game.state import Call, Decision, Ruling, State
from billiard_shot.planning.plan import best_in_hand
from billiard_shot.planning.shots import DirectShots
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused
from billiard_shot.scene.fields import as_float, positive, whole
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.scene.player import ModelError
from billiard_shot.shot.stroke import Stroke

SHOTS, TIPS = 12, 9  # direct shots that are tried, at points of contact of the tip
PLACES_IN_HAND, TIPS_IN_HAND = 8, 5  # places of the cue ball in hand that are tried; tips at each
# Ideas race: they are tried with some errors, and the best third of them with more errors.
FINALISTS, FIRST_ERRORS, SECOND_ERRORS = 40, 12, 48
IDEAS_AT_ONCE = 10  # ideas that are tried between two readings of the clock
VARIED, VARIATIONS = 3, 12  # of the best, ideas that are varied, and variations of each
WINNERS, ERRORS_EACH = 5, 96  # the best of all, and errors of each
MORE_ERRORS = 200  # with which the success of the best one is stated
POOR = 0.6  # success below which other strokes compete
OTHERS = 16  # of which so many of each kind are tried with errors
# A stroke into touching balls takes long. If more pairs touch than so many, at distances [m] up to
# this, ideas and errors are fewer: each by the square root of the ratio.
FEW_TOUCHING, TOUCHING = 4, 1e-3
TIME_RESERVE = 10.0  # decisions for which the time of a rack has to last


class Option(NamedTuple):
    """A decision of a player, and what it is worth."""

    decision: Decision  # with the chance of its shot
    value: float  # probability to win
    place: Place  # of the cue ball [m], also if it was in hand


class Player:
    """
    Plays for the rack.

    Parameters
    ----------
    scene : Scene
        With which it plans: table, noise, limits.
    seed : int
        Of its samples.
    effort : float
        Multiplies the numbers of ideas and of errors that are tried, above 0.
    plies : int
        2: looks at the next two shots of an end state; 1: at the next one; 0: at none.
    safe : bool
        Whether safeties and push-outs are played.
    seconds : float, optional
        Time for the place of the cue ball and the stroke together [s], above 0; by default there
        is no limit. The player decides on the best stroke so far before the time is over. With a
        limit the same seed may give other decisions.
    opponent : float
        Probability that a shot of the other player pots and leaves the next one, from 0 to 1. The
        player counts on 0.9 for itself.

    """

    def __init__(
        self,
        scene: Scene,
        seed: int,
        *,
        effort: float = 1.0,
        plies: int = 2,
        safe: bool = True,
        seconds: float | None = None,
        opponent: float = valuation.SHOT,
    ) -> None:
        if plies not in (0, 1, 2):
            raise refused(plies, '0, 1 or 2', 'plies')
        # The errors of the scene count as if they were the player's.
        self._scene = replace(scene, noise=scene.planned_noise, model_error=ModelError())
        self._draw = np.random.default_rng(seed)
        self._effort, self._plies = positive('effort', effort, ''), plies
        self._share = 1.0  # of the ideas and errors
        self._safe = safe
        if not 0.0 <= as_float(opponent) <= 1.0:
            raise refused(opponent, '0 to 1', 'opponent')
        self._skills = valuation.Skills(valuation.SHOT, opponent)
        self._seconds = math.inf if seconds is None else positive('seconds', seconds, 's')
        self._planned: tuple[State, list[RatedIdea], float] | None = None

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball for the stroke that it then plays."""
        if state.phase == 'break':
            return strokes.best_break(self._scene, state.game)[0]
        start = perf_counter()
        best = self._in_time(state, start)
        if not best:
            x, y = strokes.places_to_try(state)[0].tolist()
            return x, y
        there = best[0].idea.position.state
        self._planned = there, best, perf_counter() - start
        return there.balls[CUE_BALL]

    def decide(self, state: State) -> Decision:
        """Decide on the stroke with the largest value."""
        planned, self._planned = self._planned, None
        if state.choices:
            return Decision(choice=self._choice(state))
        if state.phase == 'break':
            return Decision(self._break(state), reason='break')
        best, taken = planned[1:] if planned and planned[0] == state else ([], 0.0)
        if not best or (best[0].success < POOR and 2.0 * taken < self._limit(state)):
            best = self._in_time(state, perf_counter() - taken)
        if not best:
            return strokes.hit_something(scene_of(self._scene, state), state)
        return _decision(best)

    def options(self, state: State, n: int = 5) -> list[Option]:
        """
        List the best decisions, with the places of a cue ball in hand.

        Parameters
        ----------
        state : State
            Without choices, after the break.
        n : int
            Largest number of decisions, at least 1.

        Raises
        ------
        ValueError
            If the state asks for a choice or a break, or n makes no sense.

        """
        n = whole('n', n, 1)
        if state.choices or state.phase == 'break':
            raise refused(state.choices or state.phase, 'a state after the break', 'state')
        best = self._in_time(state, perf_counter())[:n]
        return [
            Option(_decision([each]), each.value, each.idea.position.state.balls[CUE_BALL])
            for each in best
        ]

    def _break(self, state: State) -> Stroke:
        """Return the best break of the game or, if the cue ball lies elsewhere, of this state."""
        place, stroke = strokes.best_break(self._scene, state.game)
        if state.balls[CUE_BALL] == place:
            return stroke
        return strokes.best_break_of(self._scene, state)

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Learn nothing."""

    def _choice(self, state: State) -> str:
        """Take the choice with the largest value for this player."""
        found = {}
        for choice in state.choices:
            after = choose(state, choice)
            if after.phase == 'break':
                found[choice] = 0.5 if after.player == state.player else 0.45
                continue
            chance = np.zeros(1)
            if CUE_BALL in after.balls:
                chance = strokes.direct_shots(self._scene, after).best
            left = _shots_left(self._scene, after)
            found[choice] = float(
                valuation.value(after, state.player, chance, left, self._skills)[0]
            )
        return max(found, key=lambda choice: found[choice])

    def _limit(self, state: State) -> float:
        """Time for the cue ball's place and the stroke together [s]."""
        if state.time_left is None:
            return self._seconds
        return min(self._seconds, state.time_left[state.player] / TIME_RESERVE)

    def _in_time(self, state: State, start: float) -> list[RatedIdea]:
        """Think until the next step would end too late after the start [s]."""
        end, before, longest = start + self._limit(state), perf_counter(), 0.0
        pairs = combinations([state.balls[ball] for ball in state.object_balls], 2)
        touching = sum(math.dist(*pair) < 2.0 * state.radius + TOUCHING for pair in pairs)
        self._share = math.sqrt(FEW_TOUCHING / max(touching, FEW_TOUCHING))
        best: list[RatedIdea] = []
        for step in self._steps(state):
            best = step
            now = perf_counter()
            longest, before = max(longest, now - before), now
            if now + longest > end:
                break
        return best

    def _steps(self, state: State) -> Iterator[list[RatedIdea]]:
        """Yield the best strokes so far after each step, the best one first."""
        places = strokes.places_to_try(state) if state.places_cue_ball else None
        direct = strokes.direct_shots(self._scene, state, places)
        best: list[RatedIdea] = []
        ideas: list[Idea] = []
        for position, which in self._positions(state, places, direct):
            if not best:
                best = [self._as_it_is(position, direct, int(which[0]))]
                yield best
            tips = TIPS if places is None else TIPS_IN_HAND
            ideas += pots(position, direct, which, tips, self._plies)
            yield best
        # If no direction pots, the direct shot itself shows why: it may scratch, or hit twice.
        for rated in self._tried(ideas or [each.idea for each in best], FINALISTS):
            best = rated
            yield best
        if places is not None or (best and best[0].success >= POOR):
            return
        position = self._position(state)
        kinds = [indirect_pots]
        if self._safe and state.game.players > 1:
            kinds.append(safeties)
        # Only the best idea of each kind was tried with new errors: the others may be overrated.
        chosen, others = best[:1], best[1:]
        for kind in kinds:
            found: list[RatedIdea] = []
            for found in self._tried(kind(position), OTHERS):
                yield _by_value(chosen + found[:1]) + others
            chosen += found[:1]

    def _positions(
        self, state: State, places: Array | None, direct: DirectShots
    ) -> Iterator[tuple[Position, NDArray[np.int64]]]:
        """Yield positions, and numbers of the direct shots that are tried there."""
        if places is None:
            best = np.argsort(-direct.chance, kind='stable')[: self._many(SHOTS)]
            if len(best):
                yield self._position(state), best
            return
        order = best_in_hand(direct)
        pair = np.column_stack([direct.ball, direct.pocket])[order]
        _, first = np.unique(pair, axis=0, return_index=True)
        for number in order[np.sort(first)][: self._many(PLACES_IN_HAND)].tolist():
            there = state.with_cue_ball(*places[direct.table[number]].tolist())
            yield self._position(there), np.array([number])

    def _position(self, state: State) -> Position:
        return Position(state, scene_of(self._scene, state), self._skills)

    def _as_it_is(self, position: Position, direct: DirectShots, number: int) -> RatedIdea:
        """Take a direct shot by its chance, without having tried it."""
        chance, game = direct.chance[number], position.state.game
        left = _shots_left(position.scene, position.state)
        won = float(valuation.at_table(np.array([chance]), game, left, self._skills)[0])
        idea = Idea(position, direct.offsets[number], strokes.call_of(direct, number), won)
        return RatedIdea(idea, won, float(chance))

    def _tried(self, ideas: list[Idea], finalists: int) -> Iterator[list[RatedIdea]]:
        """Try the best ideas with errors, then the best of these with more errors."""
        ranked = sorted(ideas, key=lambda idea: -idea.guess)[: self._many(finalists)]
        errors = self._errors(FIRST_ERRORS), self._errors(SECOND_ERRORS)
        rated: list[RatedIdea] = []
        for i in range(0, len(ranked), IDEAS_AT_ONCE):
            rated = _by_value(rated + self._rate(ranked[i : i + IDEAS_AT_ONCE], errors[0]))
            yield rated
        if not rated:
            return
        rated = self._raced(rated, errors[1])
        yield rated
        for each in rated[: self._fewer(VARIED)]:
            some = variations(each.turned, self._many(VARIATIONS), self._draw)
            rated += self._raced(_by_value(self._rate(some, errors[0])), errors[1])
        rated = _by_value(rated)
        yield rated
        some = [each.turned for each in rated[: self._fewer(WINNERS)]]
        again = _by_value(self._rate(some, self._errors(ERRORS_EACH)))
        yield again
        # The largest of several estimates is too large: state the one of new errors.
        yield self._rate([again[0].idea], self._errors(MORE_ERRORS)) + again[1:]

    def _raced(self, rated: list[RatedIdea], errors: Array) -> list[RatedIdea]:
        """Try the best third of ideas again, with more errors; return it, the best idea first."""
        kept = rated[: max(1, len(rated) // 3)]
        return _by_value(self._rate([each.idea for each in kept], errors))

    def _rate(self, ideas: list[Idea], errors: Array) -> list[RatedIdea]:
        return rate(ideas, errors, self._plies, self._draw)

    def _many(self, count: int) -> int:
        return self._fewer(count * self._effort)

    def _fewer(self, count: float) -> int:
        return max(1, round(count * self._share))

    def _errors(self, count: int) -> Array:
        """Draw errors of executions (samples, 5)."""
        sigmas = self._scene.noise.sigmas(self._scene.ball.radius)
        return self._draw.standard_normal((self._many(count), 5)) * sigmas


def _decision(rated: list[RatedIdea]) -> Decision:
    best = rated[0]
    call = best.idea.call
    reason = f'{_in_words(call)}: wins in {100.0 * best.value:.0f} %'
    other = [each for each in rated if each.idea.call.ball != call.ball]
    if other:
        reason += f', {_in_words(other[0].idea.call)} in {100.0 * other[0].value:.0f} %'
    return Decision(
        Stroke.from_offsets(*best.idea.offsets.tolist()),
        call,
        success=None if call.passes else best.success,
        reason=reason,
    )


def _shots_left(scene: Scene, state: State) -> NDArray[np.int64]:
    """Count the shots (1, 2) that the players need in a state, wherever the cue ball is."""
    anywhere = np.zeros((1, 2))
    given = [state], np.zeros(1, np.int64), strokes.placed(state, anywhere)
    return valuation.shots_left(*given, valuation.extra_shots(scene, *given))


def _by_value(rated: list[RatedIdea]) -> list[RatedIdea]:
    return sorted(rated, key=lambda each: -each.value)


def _in_words(call: Call) -> str:
    if call.ball:
        return f'{call.ball} to {call.pocket}'
    if call.push_out:
        return 'push-out'
    return 'safety' if call.safety else 'no ball'


make = Player

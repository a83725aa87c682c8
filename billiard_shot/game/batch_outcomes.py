"""Outcomes of a batch of strokes at one state, ruled on."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.call import Call
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.referee import settled
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene.placement import CUE_BALL, head_string
from billiard_shot.shot.stroke_batch import StrokeBatch
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.table_states import TableStates


class RuledBatch(NamedTuple):
    """Strokes that were played in a simulation, with their rulings."""

    # The different ones. Their states tell which balls are left, not where these rest.
    kinds: tuple[Ruling, ...]
    kind: NDArray[np.int64]  # (n,) the ruling of each stroke
    states: TableStates  # the balls as they rest, or back where a ruling puts them

    @property
    def after(self) -> list[State]:
        """The states that the different rulings lead to."""
        return [ruling.state for ruling in self.kinds]

    def take(self, which: NDArray[np.int64]) -> 'RuledBatch':
        """Select some of the strokes."""
        return RuledBatch(self.kinds, self.kind[which], self.states.take(which))

    def keeps(self, player: int) -> NDArray[np.bool_]:
        """Whether each stroke (n,) of a player keeps the turn, or wins."""
        kept = [
            after.winner == player if after.over else ruling.legal and after.player == player
            for ruling in self.kinds
            for after in [ruling.state]
        ]
        return np.array(kept, np.bool_)[self.kind]


def rule_on(state: State, calls: Sequence[Call], run: StrokeBatch) -> RuledBatch:
    """
    Rule on a batch of strokes.

    Parameters
    ----------
    state : State
        Before the strokes, with the cue ball placed.
    calls : sequence of Call
        (n,)
    run : StrokeBatch
        (n,) on tables with the balls of the state.

    """
    cue = run.names.index(CUE_BALL)
    to_cushion = run.to_cushion.copy()
    if state.phase != 'break':  # rules ask whether any ball was driven to a cushion, not which
        to_cushion[:, cue] = to_cushion.any(axis=1)
        to_cushion[:, [i for i in range(len(run.names)) if i != cue]] = False
    balls = *run.pocket.T, *run.off_table.T, *to_cushion.T
    columns = [run.refused, run.double_hit, run.first_met[:, cue], *balls]
    different, number = np.unique(np.array(columns, np.int64), axis=1, return_inverse=True)
    outcomes = [_outcome(state, run.names, row) for row in different.T.tolist()]
    pairs = zip(calls, number.ravel().tolist(), strict=True)
    numbers: dict[tuple[Call, int], int] = {}
    kind = np.array([numbers.setdefault(pair, len(numbers)) for pair in pairs], np.int64)
    rule = state.game.rule
    kinds = tuple(settled(rule(state, call, outcomes[i]), outcomes[i]) for call, i in numbers)
    return RuledBatch(kinds, kind, _restored(run.states, kinds, kind, state.radius))


def _restored(
    states: TableStates, kinds: Sequence[Ruling], kind: NDArray[np.int64], radius: float
) -> TableStates:
    """Put the balls of a table back if its ruling restores it."""
    position, present = states.position.copy(), states.present
    for number, ruling in enumerate(kinds):
        if ruling.restore:
            rows, balls = kind == number, ruling.state.balls
            present[rows] = [name in balls for name in states.names]
            for i, name in enumerate(states.names):
                if name in balls:
                    position[rows, i] = (*balls[name], radius)
    return TableStates(states.names, position, present=present)


def _outcome(state: State, names: tuple[str, ...], row: list[int]) -> Outcome:
    """Read an outcome; its places are those before the shot, of the balls that are left."""
    count, (refused, double_hit, first), balls = len(names), row[:3], row[3:]
    if refused:
        return Outcome(refused='it is refused')
    pockets, off, cushion = (balls[i : i + count] for i in range(0, 3 * count, count))
    met = None if first == NOTHING else names[first]
    outcome = Outcome(
        first_contact=met,
        pocketed=tuple(
            (name, POCKET_NAMES[pocket])
            for name, pocket in zip(names, pockets, strict=True)
            if pocket != NOTHING
        ),
        off_table=tuple(name for name, gone in zip(names, off, strict=True) if gone),
        to_cushion=frozenset(name for name, met in zip(names, cushion, strict=True) if met),
        # A batch does not tell whether the cue ball crossed the head string before: assume not.
        from_kitchen=met is not None and state.balls[met][0] < head_string(state),
        double_hit=bool(double_hit),
    )
    places = {ball: at for ball, at in state.balls.items() if ball not in outcome.gone}
    return replace(outcome, places=places)

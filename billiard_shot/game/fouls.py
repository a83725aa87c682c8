"""
The standard fouls of pool, and how a turn goes on after a shot.

Rules are those of the World Pool-Billiard Association, The Rules of Play, 15 March 2016, part 6.
Fouls of a person (foot, clothes, conduct) are not here: a robot cannot commit them.
"""

from collections.abc import Container
from dataclasses import replace
from typing import Any

from billiard_shot.game.outcome import Outcome
from billiard_shot.game.ruling import Foul
from billiard_shot.game.state import added, State
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.words import ball_in_words


def standard_fouls(
    state: State,
    outcome: Outcome,
    targets: Container[str] | None,
    *,
    rail: bool = True,
) -> tuple[Foul, ...]:
    """
    Find the standard fouls of a shot.

    Parameters
    ----------
    state : State
        Before the shot.
    outcome : Outcome
    targets : container of str, optional
        The balls that may be met first; None if any may be.
    rail : bool
        Whether a ball has to fall or to be driven to a cushion (6.3).

    """
    if outcome.refused:
        return (Foul('6.6', f'the stroke cannot be played: {outcome.refused}'),)
    fouls = []
    first = outcome.first_contact
    if outcome.scratched:
        where = dict(outcome.pocketed).get(CUE_BALL)
        how = 'falls into a pocket' if where else 'leaves the table'
        fouls.append(Foul('6.1', f'the cue ball {how}'))
    if targets is not None and first is not None and first not in targets:
        fouls.append(Foul('6.2', f'ball {ball_in_words(first)} is met first'))
    if rail and first is None:
        fouls.append(Foul('6.3', 'the cue ball meets no ball'))
    elif rail and not outcome.pocketed and not outcome.to_cushion and not outcome.off_table:
        fouls.append(Foul('6.3', 'after the first contact no ball falls or meets a cushion'))
    for ball in outcome.off_table:
        if ball != CUE_BALL:
            fouls.append(Foul('6.5', f'ball {ball} leaves the table'))
    if outcome.double_hit:
        fouls.append(Foul('6.7', 'the cue hits the cue ball twice'))
    if state.in_hand == 'kitchen' and outcome.from_kitchen:
        fouls.append(Foul('6.11', f'ball {first} behind the head string is met first'))
    return tuple(fouls)


def after_shot(state: State, fouls: tuple[Foul, ...], *, keeps: bool, **changes: Any) -> State:
    """
    Return the state after a shot: who plays, and the count of fouls.

    Parameters
    ----------
    state : State
        Before the shot.
    fouls : tuple of Foul
    keeps : bool
        Whether the player goes on; it does not after a foul.
    **changes
        Other fields of the new state.

    """
    change = 1 if fouls else -state.fouls[state.player]
    new = {
        'player': state.player if keeps and not fouls else state.other,
        'fouls': added(state.fouls, state.player, change),
        'shots': state.shots + 1,
        'phase': 'play',
        'in_hand': '',
        'choices': (),
    }
    return replace(state, **{**new, **changes})


def in_words(fouls: tuple[Foul, ...], otherwise: str) -> str:
    """Write fouls in one line, or another text if there are none."""
    return 'foul ' + '; '.join(map(str, fouls)) if fouls else otherwise

"""Checks of decisions and outcomes against the state of the game that they meet."""

from collections.abc import Collection
from typing import Any

from billiard_shot.game.call import Call, Decision
from billiard_shot.game.outcome import Outcome
from billiard_shot.game.state import State
from billiard_shot.scene.errors import InputError, Mistake, must_be, refused, suggestion


def check_names(*checks: tuple[str, Collection[Any], Collection[Any]]) -> None:
    """Raise InputError if a name is not allowed; each check has a field, names, allowed names."""
    mistakes = [
        Mistake(
            (field,),
            must_be(f'one of {", ".join(map(repr, allowed))}', name) + suggestion(allowed, name),
        )
        for field, names, allowed in checks
        for name in names
        if name not in allowed
    ]
    if mistakes:
        raise InputError(mistakes)


def check_call(state: State, call: Call) -> None:
    """Raise InputError if a call names a ball that the game does not have."""
    check_names(('call.ball', (call.ball,), (None, *state.game.balls)))


def illegal(state: State, decision: Decision) -> str:
    """Say why a decision is not allowed in a state; empty if it is."""
    if decision.choice not in (state.choices or ('',)):
        return f'{decision.choice!r} is not a choice'
    try:
        check_call(state, decision.call)
    except InputError as error:
        return str(error)
    return ''


def check_outcome(state: State, outcome: Outcome) -> None:
    """Raise InputError if an outcome names no ball of the table or miscounts."""
    balls, others = tuple(state.balls), state.object_balls
    check_names(
        ('first_contact', (outcome.first_contact,), (None, *others)),
        ('pocketed', [ball for ball, _ in outcome.pocketed], balls),
        ('off_table', outcome.off_table, balls),
        ('to_cushion', outcome.to_cushion, balls),
        ('met', outcome.met, others),
    )
    counts = outcome.cushions_before
    if len(counts) != len(outcome.met) or any(count < 0 for count in counts):
        raise refused(counts, f'{len(outcome.met)} numbers, each at least 0', 'cushions_before')

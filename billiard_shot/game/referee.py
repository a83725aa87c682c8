"""The referee: rules on shots by their outcomes, and carries out what players choose."""

from dataclasses import replace
import math

from billiard_shot.game.call import Call, NO_CALL
from billiard_shot.game.checks import check_call, check_outcome
from billiard_shot.game.fouls import in_words
from billiard_shot.game.outcome import Outcome, outcome_of, ShotLike
from billiard_shot.game.racking import rack_state
from billiard_shot.game.ruling import Foul, Ruling
from billiard_shot.game.spots import spotted
from billiard_shot.game.state import added, State
from billiard_shot.scene.errors import refused
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.values import as_float


def judge(
    state: State, call: Call = NO_CALL, shot: ShotLike | None = None, seconds: float = 0.0
) -> Ruling:
    """
    Rule on a shot.

    Parameters
    ----------
    state : State
        Before the shot, with the cue ball placed.
    call : Call
    shot : Shot or Outcome
        What happened. None if the player concedes the shot: that is a foul (6.15).
    seconds : float
        Time that the player took [s], at least 0; it counts if the game has a limit.

    Raises
    ------
    ValueError
        If the state waits for something else than a shot; or, with field, value and the allowed
        names, for a ball or a pocket that is not there.

    """
    if state.over:
        raise ValueError('state: the game is over; nothing more can be played')
    if state.choices:
        raise ValueError(f'state: waits for a choice of {", ".join(state.choices)}')
    if CUE_BALL not in state.balls:
        raise ValueError('state: waits for the cue ball to be placed')
    state = _with_time_taken(state, seconds)
    if state.time_left is not None and state.time_left[state.player] < 0.0:
        return _lost(state, Foul('6.15', 'the time of the player is used up'))
    if shot is None:
        shot = Outcome(refused='the player names no stroke', places=state.balls)
    outcome = outcome_of(shot)
    check_call(state, call)
    check_outcome(state, outcome)
    ruling = settled(state.game.rule(state, call, outcome), outcome)
    return replace(ruling, state=ruling.arrange(ruling.state)) if ruling.arrange else ruling


def settled(ruling: Ruling, outcome: Outcome) -> Ruling:
    """Put the balls of a ruling where the outcome says that they rest, and spot balls."""
    state = ruling.state
    balls = dict(state.balls if ruling.restore or outcome.refused else outcome.places)
    if state.in_hand:
        balls.pop(CUE_BALL, None)
    if ruling.spot:
        balls = spotted(state, balls, ruling.spot)
    return replace(ruling, state=replace(state, balls=balls), miscue=outcome.miscue)


def choose(state: State, choice: str, seconds: float = 0.0) -> State:
    """
    Carry out one of the choices that the rules offer.

    Parameters
    ----------
    state : State
        With `choices`.
    choice : str
        One of them.
    seconds : float
        Time that the player took [s], at least 0.

    Raises
    ------
    ValueError
        If the state does not offer the choice.

    """
    if choice not in state.choices:
        offered = f'one of {", ".join(state.choices)}' if state.choices else 'empty'
        raise refused(choice, offered, 'choice')
    state = replace(_with_time_taken(state, seconds), choices=())
    without_cue = {ball: place for ball, place in state.balls.items() if ball != CUE_BALL}
    match choice:
        case 'kitchen':
            return replace(state, in_hand='kitchen', balls=without_cue)
        case 'pass':
            return replace(state, player=state.other)
        case 'break' | 'rebreak':
            player = state.other if choice == 'rebreak' else state.player
            in_hand = state.game.in_hand
            again = replace(state, player=player, phase='break', in_hand=in_hand)
            return rack_state(replace(again, seed=state.seed + 1))
    return state


def concede(state: State, why: str) -> Ruling:
    """Rule that the player at the table loses the rack, such as for an illegal move."""
    return _lost(state, Foul('6.17', why))


def _lost(state: State, foul: Foul) -> Ruling:
    winner = state.other if state.game.players > 1 else None
    over = replace(state, over=True, winner=winner, shots=state.shots + 1)
    return Ruling(over, (foul,), in_words((foul,), ''))


def _with_time_taken(state: State, seconds: float) -> State:
    if not 0.0 <= as_float(seconds) < math.inf:
        raise refused(seconds, 'a finite number at least 0', 'seconds', 's')
    if state.time_left is None:
        return state
    return replace(state, time_left=added(state.time_left, state.player, -seconds))

"""The referee: rules on shots by their outcomes, with fouls, spots and racks."""

from collections.abc import Collection, Container, Iterable, Mapping
from dataclasses import replace
import math
from typing import Any

from billiard_shot.game.state import (
    added,
    Call,
    Decision,
    find_game,
    Foul,
    Game,
    NO_CALL,
    Outcome,
    outcome_of,
    Ruling,
    ShotLike,
    State,
)
from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import InputError, Mistake, must_be, refused, suggestion
from billiard_shot.scene.fields import as_float, positive, whole
from billiard_shot.scene.placement import CUE_BALL, head_string, Place, Rack, racked
from billiard_shot.table.run.results import ball_in_words


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
    return state.but(**{**new, **changes})


def in_words(fouls: tuple[Foul, ...], otherwise: str) -> str:
    """Write fouls in one line, or another text if there are none."""
    return 'foul ' + '; '.join(map(str, fouls)) if fouls else otherwise


def falls_in_words(outcome: Outcome) -> str:
    """Say which object balls fall."""
    if len(outcome.fallen) > 1:
        return f'{", ".join(outcome.fallen)} fall'
    return f'{outcome.fallen[0]} falls' if outcome.fallen else 'no ball falls'


SPOT_GAP = 1e-4  # m: a spotted ball must not touch the cue ball (WPA 1.4)


def rack_of(layout: str, state: State, balls: tuple[str, ...]) -> dict[str, Place]:
    """
    Rack balls by the seed of a state [m].

    Parameters
    ----------
    layout : str
        As of `Rack`: `eight_ball` or `nine_ball`.
    state : State
        Gives sizes and seed.
    balls : tuple of str
        Those of the layout that are there.

    """
    places = racked(Rack(layout, seed=state.seed), state, state.radius)
    return {ball: place for ball, place in places.items() if ball in balls}


def foot_spot(state: State) -> Place:
    """Return the foot spot [m]."""
    return -head_string(state), 0.0


def head_spot(state: State) -> Place:
    """Return the head spot [m]."""
    return head_string(state), 0.0


def spotted(state: State, balls: Mapping[str, Place], back: Iterable[str]) -> dict[str, Place]:
    """
    Put balls back onto the table (WPA 1.4).

    Each lies on the long string, as near to the foot spot as it can, towards the foot; if the
    string is blocked there, towards the head.

    Parameters
    ----------
    state : State
        Gives the sizes.
    balls : mapping of str to (x, y)
        The balls on the table [m].
    back : iterable of str
        The balls that go back, in this order.

    """
    found = dict(balls)
    spot = foot_spot(state)[0]
    end = 0.5 * state.length - state.radius
    for ball in back:
        beside = [spot]
        for other, (x, y) in found.items():
            reach = _reach(state, other) ** 2 - y * y
            if reach > 0.0:
                beside += [x - math.sqrt(reach), x + math.sqrt(reach)]
        down = sorted(x for x in beside if spot <= x <= end)
        up = sorted((x for x in beside if -end <= x < spot), reverse=True)
        found[ball] = next((x, 0.0) for x in down + up if is_free(state, found, (x, 0.0)))
    return found


def is_free(state: State, balls: Mapping[str, Place], place: Place) -> bool:
    """Whether a ball at a place [m] overlaps no other, and does not touch the cue ball."""
    return all(
        math.dist(place, other) >= _reach(state, ball) - rounding.PLACE
        for ball, other in balls.items()
    )


def _reach(state: State, ball: str) -> float:
    return 2.0 * state.radius + (SPOT_GAP if ball == CUE_BALL else 0.0)


def start(
    game: str | Game,
    scene: SceneLike,
    seed: int = 0,
    breaker: int = 0,
    balls: int | None = None,
    target: int | None = None,
    time_limit: float | None = None,
) -> State:
    """
    Rack the balls, and return the first state of a game.

    Parameters
    ----------
    game : str or Game
        See `find_game`.
    scene : Scene, str or Path
        Its table and the radius of its balls; its `balls` do not count here.
    seed : int
        Of the rack, at least 0.
    breaker : int
        Who plays first, 0 or 1.
    balls : int, optional
        How many of the balls of the game are racked, the first ones; by default all.
    target : int, optional
        Points that win, in games with points; by default those of the game.
    time_limit : float, optional
        Time of each player for the rack [s], above 0; by default there is no limit.

    Raises
    ------
    ValueError
        If the request is invalid, or the table is not one for this game.

    """
    rules, scene = find_game(game), Scene.load(scene)
    if scene.table is None or scene.table.pockets != rules.pockets:
        needed = 'with' if rules.pockets else 'without'
        raise ValueError(f'scene: {rules.name} needs a table {needed} pockets')
    count = len(rules.balls) if balls is None else whole('balls', balls, 1)
    if count > len(rules.balls):
        raise refused(balls, f'at most {len(rules.balls)}', 'balls')
    state = State(
        game=rules,
        length=scene.table.length,
        width=scene.table.width,
        radius=scene.ball.radius,
        player=breaker,
        breaker=breaker,
        phase=rules.phase,
        in_hand=rules.in_hand,
        target=rules.goal if target is None else whole('target', target, 1),
        time_left=None if time_limit is None else 2 * (positive('time_limit', time_limit, 's'),),
        seed=seed,
    )
    return rack_state(state, rules.balls[:count])


def rack_state(state: State, balls: tuple[str, ...] = ()) -> State:
    """Return a state with the balls of its game, or some of them, racked by its seed."""
    game = state.game
    return replace(state, balls=dict(game.rack(state, balls or game.balls)))


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
    after = replace(ruling.state)  # which checks it
    return replace(ruling, state=ruling.arrange(after) if ruling.arrange else after)


def settled(ruling: Ruling, outcome: Outcome) -> Ruling:
    """Put the balls of a ruling where the outcome says that they rest, and spot balls."""
    state = ruling.state
    balls = dict(state.balls if ruling.restore or outcome.refused else outcome.places)
    if state.in_hand:
        balls.pop(CUE_BALL, None)
    if ruling.spot:
        balls = spotted(state, balls, ruling.spot)
    return replace(ruling, state=state.but(balls=balls), miscue=outcome.miscue)


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

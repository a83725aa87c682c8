"""
Straight pool: World Pool-Billiard Association, The Rules of Play, 15 March 2016, part 4.

Numbers of rules are those of that edition. Its game is 14.1 continuous.
"""

from dataclasses import replace
import math
import random

from billiard_shot.game import referee
from billiard_shot.game.state import added, Call, Foul, Game, Outcome, Ruling, State
from billiard_shot.scene.placement import CUE_BALL, Place, Rack, sites

FIFTEEN = tuple(str(ball) for ball in range(1, 16))
DRIVEN_IN_BREAK = 2  # object balls that an opening break without its ball must drive (4.3)
BREAKING_FOUL, STANDARD_FOUL, THIRD_FOUL = 2, 1, 15  # points (4.10, 4.9, 4.11)
FOULS_IN_A_ROW = 3


def needs(state: State, player: int) -> tuple[str, ...]:
    """List balls on the table, at most as many as the points that a player needs."""
    return state.object_balls[: max(0, state.target - state.scores[player])]


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot of straight pool."""
    breaks = state.phase == 'break'
    fouls = referee.standard_fouls(state, outcome, None, rail=not breaks)
    made = (call.ball, call.pocket) in outcome.pocketed and not call.safety
    if breaks and not made:
        driven = outcome.to_cushion
        if CUE_BALL not in driven or len(driven - {CUE_BALL}) < DRIVEN_IN_BREAK:
            return _breaking_foul(state, outcome, fouls)
    if fouls:
        return _foul(state, outcome, fouls)
    if not made:
        after = referee.after_shot(state, (), keeps=False)
        text = 'safety' if call.safety else 'the called ball does not fall'
        return Ruling(after, (), text, outcome.fallen)
    scores = added(state.scores, state.player, len(outcome.fallen))
    after = referee.after_shot(state, (), keeps=True, scores=scores)
    text = f'ball {call.ball} falls as called, {scores[state.player]} points'
    if scores[state.player] >= state.target:
        after = replace(after, over=True, winner=state.player)
    elif len(set(state.object_balls) - outcome.gone) <= 1:
        return Ruling(after, (), text, arrange=_rack_again)
    return Ruling(after, (), text)


def _breaking_foul(state: State, outcome: Outcome, fouls: tuple[Foul, ...]) -> Ruling:
    """Rule on an opening break that drives too few balls (4.3, 4.10); it is no standard foul."""
    fouls = (*fouls, Foul('4.10', 'the opening break drives too few balls to cushions'))
    after = referee.after_shot(
        state,
        fouls,
        keeps=False,
        scores=added(state.scores, state.player, -BREAKING_FOUL),
        in_hand='kitchen' if outcome.scratched else '',
        choices=('accept', 'rebreak'),
    )
    after = replace(after, fouls=state.fouls)
    return Ruling(after, fouls, referee.in_words(fouls, ''), _object_balls(outcome))


def _foul(state: State, outcome: Outcome, fouls: tuple[Foul, ...]) -> Ruling:
    """Rule on a standard foul (4.9), and on the third one in a row (4.11)."""
    in_hand = outcome.scratched or any(foul.rule == '6.11' for foul in fouls)
    after = referee.after_shot(
        state,
        fouls,
        keeps=False,
        scores=added(state.scores, state.player, -STANDARD_FOUL),
        in_hand='kitchen' if in_hand else '',
    )
    if after.fouls[state.player] < FOULS_IN_A_ROW:
        return Ruling(after, fouls, referee.in_words(fouls, ''), _object_balls(outcome))
    fouls = (*fouls, Foul('6.14', f'{FOULS_IN_A_ROW} consecutive fouls'))
    after = replace(
        after,
        player=state.player,
        fouls=added(after.fouls, state.player, -after.fouls[state.player]),
        phase='break',
        in_hand='kitchen',
        scores=added(after.scores, state.player, -THIRD_FOUL),
    )
    return Ruling(after, fouls, referee.in_words(fouls, ''), arrange=_rack_all)


def _object_balls(outcome: Outcome) -> tuple[str, ...]:
    """List the object balls that go back onto the table."""
    return tuple(sorted(outcome.gone - {CUE_BALL}, key=int))


def _rack_all(state: State) -> State:
    return referee.rack_state(replace(state, seed=state.seed + 1))


def _rack_again(state: State) -> State:
    """Rack fourteen balls, or all, and move what is in the way (4.8)."""
    left = {ball: place for ball, place in state.balls.items() if ball != CUE_BALL}
    cue = state.balls[CUE_BALL]
    cue_interferes = _interferes(state, cue)
    ball, place = next(iter(left.items()), ('', None))
    again = replace(state, seed=state.seed + 1)
    if place is None or (_interferes(state, place) and cue_interferes):
        again = referee.rack_state(again)
    else:
        if _interferes(state, place):
            place = _first_free(state, {CUE_BALL: cue}, referee.head_spot(state), (0.0, 0.0))
        again = referee.rack_state(again, (ball, *(each for each in FIFTEEN if each != ball)))
        again = replace(again, balls={**again.balls, ball: place})
    if not cue_interferes:
        return replace(again, balls={**again.balls, CUE_BALL: cue})
    if place is None or _interferes(state, place) or place[0] >= referee.head_spot(state)[0]:
        return replace(again, in_hand='kitchen')
    spot = _first_free(state, {ball: place}, referee.head_spot(state), (0.0, 0.0))
    return replace(again, balls={**again.balls, CUE_BALL: spot})


def _first_free(state: State, balls: dict[str, Place], *spots: Place) -> Place:
    return next(spot for spot in spots if referee.is_free(state, balls, spot))


def _interferes(state: State, place: Place) -> bool:
    """Whether a ball overlaps the outline of the rack: a triangle around fifteen balls."""
    x, y = place[0] - referee.foot_spot(state)[0], abs(place[1])
    back = 4.0 * 2.0 * state.radius * math.sqrt(0.75)
    outside = max(0.5 * math.sqrt(3.0) * y - 0.5 * x, x - back)  # from the centres of the balls
    return outside < 2.0 * state.radius


def rack(state: State, balls: tuple[str, ...]) -> dict[str, Place]:
    """Rack the balls in an order drawn from the seed; the first one lies at the apex (4.2)."""
    others = list(balls[1:]) if len(balls) > 1 else []
    random.Random(state.seed).shuffle(others)
    spacing = 2.0 * state.radius + Rack('eight_ball').gap
    places = sites([1, 2, 3, 4, 5], referee.foot_spot(state)[0], spacing)
    return dict(zip((balls[0], *others), places, strict=False))


GAME = Game(
    name='straight_pool',
    rule=rule,
    rack=rack,
    balls=FIFTEEN,
    needs=needs,
    shared=False,
    goal=150,
    reracked=1,
)

"""
Nine-ball: World Pool-Billiard Association, The Rules of Play, 15 March 2016, part 2.

Numbers of rules are those of that edition.
"""

from functools import partial

from billiard_shot.game import referee
from billiard_shot.game.state import Call, Foul, Game, Outcome, Ruling, State
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.results import plural

DRIVEN_IN_BREAK = 4  # object balls that a break without a pot has to drive to cushions (2.3)
FOULS_THAT_LOSE = 3  # consecutive fouls (2.8, 6.14)


def targets(state: State) -> tuple[str, ...]:
    """Return the ball that must be met first: the lowest one."""
    return tuple(sorted(state.object_balls, key=int)[:1])


def rotation_fouls(
    state: State, outcome: Outcome, break_rule: str, *, pushes: bool
) -> tuple[Foul, ...]:
    """
    Find the fouls of a shot of nine-ball or ten-ball.

    A push-out suspends 6.2 and 6.3 (2.4, 9.4). A break has its own rule on cushions, which the
    games number differently.
    """
    breaks = state.phase == 'break'
    first = None if pushes else targets(state)
    fouls = referee.standard_fouls(state, outcome, first, rail=not (pushes or breaks))
    driven = (outcome.to_cushion | outcome.gone) - {CUE_BALL}
    if breaks and not outcome.fallen and len(driven) < DRIVEN_IN_BREAK:
        fouls += (Foul(break_rule, f'the break drives {plural(len(driven), "ball")} to cushions'),)
    return fouls


def third_foul(state: State, fouls: tuple[Foul, ...]) -> Ruling | None:
    """Rule that the third foul in a row loses the rack (6.14); None if it is not the third."""
    if not fouls or state.fouls[state.player] + 1 < FOULS_THAT_LOSE:
        return None
    fouls += (Foul('6.14', f'{FOULS_THAT_LOSE} consecutive fouls'),)
    after = referee.after_shot(state, fouls, keeps=False, over=True, winner=state.other)
    return Ruling(after, fouls, referee.in_words(fouls, ''))


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot of nine-ball."""
    breaks = state.phase == 'break'
    pushes = call.push_out and state.phase == 'second'
    fouls = rotation_fouls(state, outcome, '2.3', pushes=pushes)
    if lost := third_foul(state, fouls):
        return lost
    if '9' in outcome.fallen and not fouls and not pushes:
        after = referee.after_shot(state, fouls, keeps=True, over=True, winner=state.player)
        return Ruling(after, fouls, 'the 9 falls')
    spot = ('9',) if '9' in outcome.gone else ()
    if pushes and not fouls:
        after = referee.after_shot(state, fouls, keeps=False, choices=('accept', 'pass'))
        return Ruling(after, fouls, 'push-out', spot)
    after = referee.after_shot(
        state,
        fouls,
        keeps=bool(outcome.fallen),
        phase='second' if breaks and not fouls else 'play',
        in_hand='anywhere' if fouls else '',
    )
    return Ruling(after, fouls, referee.in_words(fouls, referee.falls_in_words(outcome)), spot)


GAME = Game(
    name='nine_ball',
    rule=rule,
    targets=targets,
    rack=partial(referee.rack_of, 'nine_ball'),  # 2.2
    balls=tuple(str(ball) for ball in range(1, 10)),
    calls=False,
    decisive='9',
)

"""
Ten-ball: World Pool-Billiard Association, The Rules of Play, 15 March 2016, part 9.

Numbers of rules are those of that edition. After the break, ball and pocket are called.
"""

from functools import partial

from billiard_shot.game.referee import after_shot, falls_in_words, in_words, rack_of
from billiard_shot.game.rules.nine_ball import rotation_fouls, targets, third_foul
from billiard_shot.game.state import Call, Game, Outcome, Ruling, State


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot of ten-ball."""
    breaks = state.phase == 'break'
    pushes = call.push_out and state.phase == 'second'
    fouls = rotation_fouls(state, outcome, '9.3', pushes=pushes)
    if lost := third_foul(state, fouls):
        return lost
    spot = ('10',) if '10' in outcome.gone else ()
    if fouls:
        after = after_shot(state, fouls, keeps=False, in_hand='anywhere')
        return Ruling(after, fouls, in_words(fouls, ''), spot)
    if breaks:  # nothing is called (9.3)
        after = after_shot(state, fouls, keeps=bool(outcome.fallen), phase='second')
        return Ruling(after, fouls, falls_in_words(outcome), spot)
    if pushes:
        after = after_shot(state, fouls, keeps=False, choices=('accept', 'pass'))
        return Ruling(after, fouls, 'push-out', spot)
    if (call.ball, call.pocket) in outcome.pocketed and not call.safety:
        won = call.ball == '10' and len(state.object_balls) == 1
        winner = state.player if won else None
        after = after_shot(state, fouls, keeps=True, over=won, winner=winner)
        return Ruling(after, fouls, f'ball {call.ball} falls as called', () if won else spot)
    # The other player may hand the shot back if a ball fell that was not called (9.6, 9.7).
    choices = ('accept', 'pass') if outcome.fallen else ()
    after = after_shot(state, fouls, keeps=False, choices=choices)
    text = 'safety' if call.safety else 'the called ball does not fall'
    return Ruling(after, fouls, text, spot)


GAME = Game(
    name='ten_ball',
    rule=rule,
    targets=targets,
    rack=partial(rack_of, 'ten_ball'),  # 9.2
    balls=tuple(str(ball) for ball in range(1, 11)),
    decisive='10',
)

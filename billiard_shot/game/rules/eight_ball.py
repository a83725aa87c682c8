"""
Eight-ball: World Pool-Billiard Association, The Rules of Play, 15 March 2016, part 3.

Numbers of rules are those of that edition. Three consecutive fouls have no penalty in it (3.10).
"""

from functools import partial

from billiard_shot.game.referee import (
    after_shot,
    falls_in_words,
    in_words,
    rack_of,
    standard_fouls,
)
from billiard_shot.game.state import Call, Game, Outcome, Ruling, State
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.results import plural

SOLIDS = tuple(str(ball) for ball in range(1, 8))
STRIPES = tuple(str(ball) for ball in range(9, 16))
BALLS_OF_GROUPS = {'solids': SOLIDS, 'stripes': STRIPES}
DRIVEN_IN_BREAK = 4  # object balls that a break without a pot has to drive to cushions (3.3)


def targets(state: State) -> tuple[str, ...]:
    """Balls that may be met first and called (3.4, 3.6): the group, and after it the 8."""
    group = BALLS_OF_GROUPS.get(state.groups[state.player], (*SOLIDS, *STRIPES))
    return tuple(ball for ball in state.object_balls if ball in group) or ('8',)


def needs(state: State, player: int) -> tuple[str, ...]:
    """
    List the balls of a player: those of the group, and the 8.

    If the table is open, the player at the table has the smaller group.
    """
    lying = {
        name: [ball for ball in state.object_balls if ball in group]
        for name, group in BALLS_OF_GROUPS.items()
    }
    mine = state.groups[player]
    if not mine:
        smaller, larger = sorted(lying, key=lambda name: len(lying[name]))
        mine = smaller if player == state.player else larger
    return (*lying[mine], *(ball for ball in state.object_balls if ball == '8'))


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule on a shot of eight-ball."""
    if state.phase == 'break':
        return _break(state, outcome)
    fouls = standard_fouls(state, outcome, targets(state))
    called = (call.ball, call.pocket) in outcome.pocketed
    made = called and call.ball in targets(state) and not fouls
    if '8' in outcome.gone:
        won = made and call.ball == '8' and not call.safety
        winner = state.player if won else state.other
        text = 'the 8 falls as called' if won else in_words(fouls, _why_lost(state, outcome, call))
        after = after_shot(state, fouls, keeps=won, over=True, winner=winner)
        return Ruling(after, fouls, text)
    groups = state.groups
    if made and not groups[state.player] and not call.safety:
        mine = 'solids' if call.ball in SOLIDS else 'stripes'
        other = 'stripes' if mine == 'solids' else 'solids'
        groups = (mine, other) if state.player == 0 else (other, mine)
    keeps = made and not call.safety
    after = after_shot(
        state, fouls, keeps=keeps, in_hand='anywhere' if fouls else '', groups=groups
    )
    if keeps:
        text = f'ball {call.ball} falls as called'
    else:
        text = in_words(fouls, 'safety' if call.safety else 'the called ball does not fall')
    return Ruling(after, fouls, text)


def _why_lost(state: State, outcome: Outcome, call: Call) -> str:
    """Say why a shot without a foul in which the 8 is gone loses (3.8)."""
    if '8' in outcome.off_table:
        return '3.8: the 8 leaves the table'
    if targets(state) != ('8',):
        return '3.8: the 8 falls before the group is cleared'
    return '3.8: the 8 falls into a pocket that was not called'


def _break(state: State, outcome: Outcome) -> Ruling:
    """Rule on the break (3.3)."""
    fouls = standard_fouls(state, outcome, None, rail=False)
    driven = (outcome.to_cushion | outcome.gone) - {CUE_BALL}
    legal = bool(outcome.fallen) or len(driven) >= DRIVEN_IN_BREAK
    in_hand = 'kitchen' if outcome.scratched or outcome.refused else ''
    choices: tuple[str, ...] = ()
    keeps = bool(outcome.fallen)
    text = f'the break is legal, {falls_in_words(outcome)}'
    if '8' in outcome.gone:
        # The 8 goes back, or the player at the table breaks again.
        keeps, choices, text = legal, ('accept', 'break'), 'the 8 falls in the break'
        in_hand = 'kitchen' if fouls else ''
    elif not legal:
        choices = ('accept', 'break', 'rebreak')
        text = f'3.3: no legal break, {plural(len(driven), "ball")} driven to cushions'
    elif fouls and not in_hand:
        choices = ('accept', 'kitchen')
    after = after_shot(state, fouls, keeps=keeps, in_hand=in_hand, choices=choices)
    return Ruling(after, fouls, in_words(fouls, text), ('8',) if '8' in outcome.gone else ())


GAME = Game(
    name='eight_ball',
    rule=rule,
    targets=targets,
    rack=partial(rack_of, 'eight_ball'),  # 3.2
    balls=(*SOLIDS, '8', *STRIPES),
    decisive='8',
    needs=needs,
    shared=False,
)

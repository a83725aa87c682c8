"""Eight-ball in which fouls restore the table, groups are given, and nothing is called."""

from dataclasses import replace

from billiard_shot.game import find_game
from billiard_shot.game.referee import after_shot, in_words, standard_fouls
from billiard_shot.game.state import Ruling

EIGHT = find_game('eight_ball')


def rule(state, call, outcome):
    """Rule on a shot; whoever breaks has the solids."""
    if not state.groups[0]:
        groups = ('solids', 'stripes') if state.player == 0 else ('stripes', 'solids')
        state = replace(state, groups=groups)
    breaks, targets = state.phase == 'break', EIGHT.targets(state)
    fouls = standard_fouls(state, outcome, None if breaks else targets, rail=not breaks)
    if '8' in outcome.gone and not breaks:
        won = targets == ('8',) and not fouls
        winner = state.player if won else state.other
        after = after_shot(state, fouls, keeps=won, over=True, winner=winner)
        return Ruling(after, fouls, in_words(fouls, 'the 8 falls'))
    keeps = bool({*outcome.fallen} & {*targets})
    after = after_shot(state, fouls, keeps=keeps)
    if fouls and breaks:
        after = replace(after, phase='break', in_hand='kitchen')
    spot = ('8',) if '8' in outcome.gone and not fouls else ()
    return Ruling(after, fouls, in_words(fouls, 'legal'), spot, restore=bool(fouls))


GAME = replace(EIGHT, name='restored', rule=rule, calls=False)

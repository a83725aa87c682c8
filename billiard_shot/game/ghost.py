"""
The ghost: an opponent who never misses, for one player who breaks and has to run out.

The player breaks. After the break the cue ball is in hand anywhere on the table, whatever the
break did; balls that fell stay down, but the decisive ball is spotted. The first foul or shot that
does not keep the turn ends the rack, and the ghost has won. The player's score counts the balls
that fell in the break and in shots that kept the turn, without a foul. Over ten racks of ten-ball
it is that of a test of 100 balls (D. Alciatore, billiards.colostate.edu, has ratings of people).
"""

from dataclasses import replace

from billiard_shot.game.state import added, Call, Game, Outcome, Ruling, State


def ghost(game: Game) -> Game:
    """Return a game of one player, with the rules of a game of two."""

    def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
        ruling = game.rule(state.but(game=game), call, outcome)
        after = ruling.state
        breaks = state.phase == 'break'
        won = after.winner == state.player
        # After a third foul in straight pool the same player breaks again.
        keeps = breaks or (after.player == state.player and not ruling.fouls)
        goes_on = keeps and not after.over
        counts = keeps and not ruling.fouls
        fallen = len(outcome.fallen) - len(ruling.spot) if counts else 0
        alone = after.but(
            game=state.game,
            player=state.player,
            phase='play',
            in_hand='anywhere' if breaks and goes_on else '',
            choices=(),
            scores=added(state.scores, state.player, fallen),
            over=not goes_on,
            winner=state.player if won else None,
        )
        return replace(ruling, state=alone)

    return replace(game, name=f'{game.name}_ghost', rule=rule, players=1)

"""Eight-ball for one player, who has one visit: to run out, from any state after the break."""

from dataclasses import replace

from billiard_shot.game.state import Call, find_game, Outcome, Ruling, State

EIGHT_BALL = find_game('eight_ball')


def rule(state: State, call: Call, outcome: Outcome) -> Ruling:
    """Rule as eight-ball does, and end the rack with the visit."""
    ruling = EIGHT_BALL.rule(replace(state, game=EIGHT_BALL), call, outcome)  # of two players
    after = ruling.state
    won = after.over and after.winner == state.player
    over = after.over or after.player != state.player
    winner = state.player if won else None
    return replace(
        ruling,
        state=replace(
            after, game=state.game, player=state.player, over=over, winner=winner, choices=()
        ),
    )


GAME = replace(EIGHT_BALL, name='tools.run_out', rule=rule, players=1)

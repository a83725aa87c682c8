"""A turn of practice on a table that a camera sees."""

from billiard_shot_msgs.action import PlayTurn
from waiting import PATIENCE

from billiard_shot.game.rack import find_agent
from billiard_shot.ros.turn import GameTable, Turn


def seen_turn(client, scene, state):
    """Make the turn of `player` once two balls are seen; return also what it will have told."""
    said = []

    def wait_until_seen(shot_id, before, places, is_over):
        """Answer that more is seen now: a ball that a camera misses is not potted."""
        assert client.until(is_over, PATIENCE), f'{shot_id}: only {sorted(places)} are seen'

    turn = Turn(
        GameTable(client, scene),
        find_agent('player')(scene, 1),
        lambda stage, message, *_: said.append(message),
        wait_until_seen,
        True,
        state,
    )
    everything = client.until(lambda: len(client.table.balls) == 2, PATIENCE)
    assert everything, 'the camera does not see the cue ball and the 8'
    return turn, said


def cleared(turn, said, cell):
    """Play a turn, which must clear the table; a failure tells all that is known of it."""
    ended = turn.play()
    logs = [f'{node}: {line}' for node in cell.nodes for line in cell.logged(node)]
    parts = [turn.state, *turn.shots, cell.player.balls(), *said, *logs]
    told = '\n'.join(map(str, parts))
    assert ended == (PlayTurn.Result.OVER, 'player 0 wins'), f'{ended}:\n{told}'

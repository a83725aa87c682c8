"""A turn of practice on a table that a camera sees."""

from waiting import PATIENCE

from billiard_shot.game.rack import find_agent
from billiard_shot.ros.turn import GameTable, Turn


def seen_turn(client, scene, state):
    """Make the turn of `player` once two balls are seen; return also what it will have told."""
    said = []
    turn = Turn(
        GameTable(client, scene),
        find_agent('player')(scene, 1),
        lambda stage, message, *_: said.append(message),
        None,
        True,
        state,
    )
    everything = client.until(lambda: len(client.table.balls) == 2, PATIENCE)
    assert everything, 'the camera does not see the cue ball and the 8'
    return turn, said

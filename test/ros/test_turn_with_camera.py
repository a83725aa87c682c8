"""A turn that is played by what a camera sees: detections with errors, tracked."""

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')

from cell import WITH_CAMERA
from seen_turn import cleared, seen_turn

from billiard_shot import Scene
from billiard_shot.game.referee import start

SPACE, NODES = '/turn_seen', WITH_CAMERA


@pytest.mark.slow
def test_a_ball_is_cleared(cell):
    """The 8 of the scene is taken away, and the tracker forgets it."""
    scene = Scene.load('robot_table')
    state = start('practice', scene, seed=1, balls=1)
    turn, said = seen_turn(cell.player, scene, state)
    cleared(turn, said, cell)
    assert '8 off the table' in next(each for each in said if 'put the balls' in each)

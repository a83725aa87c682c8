"""A turn that is played by rendered pictures: nobody but `table_camera` makes detections."""

from dataclasses import replace
from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')
pytest.importorskip('cv2', reason='needs OpenCV, an extra: film')
pytest.importorskip('av', reason='needs PyAV, an extra: film')

from cell import ON_ROBOT_TABLE, PATIENT
from seen_turn import cleared, seen_turn

from billiard_shot import Scene
from billiard_shot.game.referee import start

SPACE = '/cleared'
NODES = {
    'cue_driver': (*PATIENT['cue_driver'], *ON_ROBOT_TABLE, '-p', 'table_timeout:=5.0'),
    'cue_sim': PATIENT['cue_sim'],
    'table_sim': (
        *('-p', 'real_time_factor:=2.0', *ON_ROBOT_TABLE),
        *('-r', 'table_state:=simulated_table'),
    ),
    'table_camera': ON_ROBOT_TABLE,
    'table_tracker': (*ON_ROBOT_TABLE, '-p', 'lost_after:=3.0'),  # of a busy machine
    'predictor': (),
}
BALLS = {'1': (1.245, 0.61), '3': (-1.245, -0.61), '6': (1.245, -0.61)}
"""In the jaws of corner pockets [m]: the test is of pictures, not of the robot's aim."""


@pytest.fixture(scope='module', autouse=True)
def rendered_camera(domain):
    """Run the camera before the cell, which waits for a table."""
    script = Path(__file__).with_name('rendered_camera.py')
    process = subprocess.Popen([sys.executable, script, '--ros-args', '-r', f'__ns:={SPACE}'])
    yield
    process.kill()
    process.wait()


@pytest.mark.slow
def test_three_balls_are_cleared(cell):
    scene = Scene.load('robot_table')
    state = replace(start('practice', scene, seed=1, balls=3), balls=BALLS)
    turn, said = seen_turn(cell.player, scene, state)
    cleared(turn, said, cell)
    assert '8 off the table' in next(each for each in said if 'put the balls' in each)

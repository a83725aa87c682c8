"""The recorder as a real process, beside a simulated table."""

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import Strike
from geometry_msgs.msg import Point, Pose, Quaternion
from rcl_interfaces.msg import Log
from std_msgs.msg import Header
from waiting import spin_until

from billiard_shot import predict, Scene, Stroke
from billiard_shot.calibration.reader import read_recording

SPACE = '/recorded'


def test_a_strike_becomes_a_shot_of_a_recording(launch_once, node, tmp_path):
    path, round_tip = tmp_path / 'shots.csv', tmp_path / 'scene.yaml'
    round_tip.write_text('{like: robot_table, cue: {tip_curvature_radius: 0.01}}')
    own = '-p', f'scene:={round_tip}', '-r', f'__ns:={SPACE}'
    launch_once('shot_recorder', '-p', f'file:={path}', *own)
    hidden = '-p', 'speed_scale:=1.2'  # which the encoders do not see
    launch_once('table_sim', '-p', 'real_time_factor:=5.0', *hidden, *own)
    strikes = node.create_publisher(Strike, f'{SPACE}/cue_driver/strike', 10)
    assert spin_until(node, lambda: strikes.get_subscription_count() == 2)
    log = []
    node.create_subscription(Log, '/rosout', log.append, 100)

    def strike(y):
        pose = Pose(position=Point(x=-0.13, y=y, z=0.0286), orientation=Quaternion(w=1.0))
        header = Header(frame_id='table', stamp=node.get_clock().now().to_msg())
        strikes.publish(Strike(header=header, shot_id='first', cue_pose=pose, speed=0.5))

    def sees_the_ball():
        """Strike past the ball; before its first picture, the recorder does not know the ball."""
        strike(0.5)
        spin_until(node, lambda: False, 0.2)
        lines = [each.msg for each in log if each.name == 'recorded.shot_recorder']
        return any(line.startswith('ignored a strike: cue_pose') for line in lines)

    assert spin_until(node, sees_the_ball)
    strike(0.105)
    assert spin_until(node, path.exists)
    assert spin_until(node, path.with_suffix('.yaml').exists)
    recording = read_recording(path)
    (shot,) = recording.shots
    assert (shot.name, shot.struck, recording.scene) == ('first', 'cue', str(round_tip))
    scene = Scene.load(round_tip)
    assert shot.stroke.offsets[0] == pytest.approx(-0.005 / (scene.ball.radius + 0.01), abs=1e-3)
    assert shot.stroke.offsets[4] == pytest.approx(0.5)
    stroke = Stroke.from_offsets(*shot.stroke.offsets[:4], 1.2 * shot.stroke.speed)
    rest = predict(scene, stroke).trajectory.final_position
    assert shot.tracks['cue'].place[-1] == pytest.approx(rest[:2], abs=0.01)

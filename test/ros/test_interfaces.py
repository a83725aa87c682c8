"""The constants of the interfaces say what the library says."""
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallTrajectory
from billiard_shot_msgs.srv import PredictShot

from billiard_shot import Status
from billiard_shot.table.motion import Motion


def constants(interface):
    return {name: getattr(interface, name) for name in dir(interface)
            if name.isupper() and isinstance(getattr(interface, name), int)}


def test_status_constants_are_the_status_enum():
    assert constants(PredictShot.Response) == {status.name: status.value for status in Status}


def test_motion_constants_are_the_motion_codes():
    assert constants(BallTrajectory) == {motion.name: motion.value for motion in Motion}

"""The constants of the interfaces say what the library says."""

from dataclasses import asdict
import math
from pathlib import Path

import pytest
import yaml

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallTrajectory
from billiard_shot_msgs.msg import Status as StatusMessage
import rclpy
from rclpy.exceptions import ParameterException
from rclpy.parameter import Parameter

from billiard_shot import Status
from billiard_shot.cue.controller import Settings
from billiard_shot.cue.mechanism import Alignment
from billiard_shot.cue.simulated import Faults, Imperfections
from billiard_shot.perception.tracker import TrackerSettings
from billiard_shot.ros import parameters
from billiard_shot.ros.cue_driver import CueDriverParameters
from billiard_shot.ros.cue_model import CueModelParameters
from billiard_shot.ros.cue_sim import CueSimParameters
from billiard_shot.ros.parameters import descriptors, TOPIC_NAME
from billiard_shot.ros.planner import PlannerParameters
from billiard_shot.ros.predictor import PredictorParameters
from billiard_shot.ros.table_camera import TableCameraParameters
from billiard_shot.ros.table_display import TableDisplayParameters
from billiard_shot.ros.table_sim import CameraErrors, TableSimParameters
from billiard_shot.ros.table_tracker import TableTrackerParameters
from billiard_shot.scene import Robot
from billiard_shot.table.model.motion import Motion


def constants(interface):
    return {
        name: getattr(interface, name)
        for name in dir(interface)
        if name.isupper() and isinstance(getattr(interface, name), int)
    }


def test_status_constants_are_the_status_enum():
    assert constants(StatusMessage) == {status.name: status.value for status in Status}


PARAMETERS = {
    'predictor': [PredictorParameters],
    'planner': [PlannerParameters, Robot],
    'cue_driver': [CueDriverParameters, Settings],
    'cue_model': [CueModelParameters],
    'cue_sim': [CueSimParameters, Imperfections, Faults],
    'table_sim': [TableSimParameters, CameraErrors, Alignment],
    'table_camera': [TableCameraParameters],
    'table_display': [TableDisplayParameters],
    'table_tracker': [TableTrackerParameters, TrackerSettings],
}
CONFIG = Path(__file__).resolve().parents[2] / 'config'


@pytest.mark.parametrize('node', PARAMETERS)
def test_parameter_files_hold_the_defaults(node):
    """config/: every parameter, with the value that the node has without the file."""
    values = yaml.safe_load((CONFIG / f'{node}.yaml').read_text())['/**']['ros__parameters']
    kinds = PARAMETERS[node]
    assert values == {name: value for kind in kinds for name, value in asdict(kind()).items()}
    for kind in kinds:
        assert all(each.description.endswith('.') for _, each in descriptors(kind))


@pytest.mark.parametrize(
    ('program', 'name', 'value', 'words'),
    [
        ('predictor', 'tolerance', 0.0, 'tolerance'),
        ('predictor', 'tolerance', math.nan, 'tolerance'),
        ('predictor', 'tolerance', 1, 'tolerance'),
        ('predictor', 'sample_count', -1, 'sample_count'),
        ('cue_sim', 'command_loss_rate', 2.0, 'command_loss_rate'),
        ('table_sim', 'real_time_factor', 0.0, 'real_time_factor'),
        ('planner', 'target', '{rest: 3}', 'rest must be two finite numbers'),
        ('planner', 'target', '{rest: [', 'is not YAML'),
        ('cue_driver', 'mechanism', 'no_such.yaml', 'no_such.yaml'),
        ('cue_driver', 'joint_names', ['a', 'b'], 'joint_names'),
        ('cue_driver', 'estop_timeout', math.nan, 'estop_timeout'),
        ('cue_driver', 'controller', '9x', 'topic must be words'),
        ('table_camera', 'corners', [1.0, 2.0], 'u and v of four corners'),
        ('table_camera', 'balls', [''], 'balls'),
    ],
)
def test_bad_values_are_refused_by_name(node, program, name, value, words):
    """In this process: that a node then ends with one line, other tests show for each node."""
    strict = rclpy.create_node('strict', parameter_overrides=[Parameter(name, value=value)])
    with pytest.raises(ParameterException, match=words):
        parameters.declare(strict, *PARAMETERS[program])
    strict.destroy_node()


def read_only(node):
    return {
        name for kind in PARAMETERS[node] for name, each in descriptors(kind) if each.read_only
    }


def test_what_only_the_start_decides():
    """All parameters of these nodes but frames, and the errors and faults of simulations."""
    for node, settable in {
        'cue_model': set(),
        'cue_sim': {*asdict(Faults())},
        'table_sim': {'frame', *asdict(CameraErrors()), *asdict(Alignment())},
        'table_tracker': {'frame'},
    }.items():
        names = {name for kind in PARAMETERS[node] for name in asdict(kind())}
        assert names - read_only(node) == settable


def test_bounds_are_those_of_the_fields():
    found = dict(descriptors(Robot))
    speed, azimuth = (found[name].floating_point_range[0] for name in ('speed_min', 'azimuth_deg'))
    assert (speed.from_value, speed.to_value) == (0.0, math.inf)
    assert (azimuth.from_value, azimuth.to_value) == (-360.0, 360.0)
    budget = dict(descriptors(PlannerParameters))['budget'].integer_range[0]
    assert (budget.from_value, budget.to_value) == (1, 10_000_000)


@pytest.mark.parametrize('name', ['a', '/a/b_2', '~/a', '_a'])
def test_names_of_topics(name):
    assert TOPIC_NAME.fullmatch(name)


@pytest.mark.parametrize('name', ['', ' ', 'a b', '9x', 'a//b', 'a/', 'a~b', '~', 'a/2', 'ä'])
def test_names_that_no_topic_can_have(name):
    assert not TOPIC_NAME.fullmatch(name)


def test_motion_constants_are_the_motion_codes():
    codes = {motion.name: motion.value for motion in Motion if motion != Motion.ABSENT}
    assert constants(BallTrajectory) == codes

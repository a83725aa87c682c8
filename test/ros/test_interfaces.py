"""The constants of the interfaces say what the library says."""

from pathlib import Path
import re

import pytest
import yaml

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallTrajectory
from billiard_shot_msgs.msg import Status as StatusMessage

from billiard_shot import Status
from billiard_shot.ros import cue_parameters, parameters, plan_parameters, table_parameters
from billiard_shot.table.motion import Motion


def constants(interface):
    return {
        name: getattr(interface, name)
        for name in dir(interface)
        if name.isupper() and isinstance(getattr(interface, name), int)
    }


def test_status_constants_are_the_status_enum():
    assert constants(StatusMessage) == {status.name: status.value for status in Status}


@pytest.mark.parametrize(
    ('node', 'declared'),
    [
        ('predictor', parameters.PREDICTOR),
        ('planner', plan_parameters.PLANNER),
        ('cue_driver', cue_parameters.CUE_DRIVER),
        ('cue_model', cue_parameters.CUE_MODEL),
        ('cue_sim', cue_parameters.CUE_SIM),
        ('table_sim', cue_parameters.TABLE_SIM),
        ('table_display', cue_parameters.TABLE_DISPLAY),
        ('table_tracker', table_parameters.TABLE_TRACKER),
    ],
)
def test_parameter_files_hold_the_defaults(node, declared):
    """config/: every parameter, with the value that the node has without the file."""
    file = Path(__file__).resolve().parents[2] / 'config' / f'{node}.yaml'
    assert yaml.safe_load(file.read_text())['/**']['ros__parameters'] == {
        parameter.name: parameter.default for parameter in declared
    }
    for parameter in declared:
        assert parameter.description.endswith('.')


def test_the_page_names_the_read_only_parameters_of_the_driver():
    page = (Path(__file__).resolve().parents[2] / 'docs' / 'cue.md').read_text()
    listed = set(re.findall(r'`(\w+)`', page[page.index('Read-only are') :].partition(':')[0]))
    assert listed == {each.name for each in cue_parameters.CUE_DRIVER if each.read_only}


def test_motion_constants_are_the_motion_codes():
    codes = {motion.name: motion.value for motion in Motion if motion != Motion.ABSENT}
    assert constants(BallTrajectory) == codes

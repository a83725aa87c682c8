"""Parameters of the nodes around the mechanical cue."""

from dataclasses import fields, replace
from typing import Any

from rclpy.node import Node

from billiard_shot.cue.job import Settings
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.simulated import Faults, Imperfections
from billiard_shot.ros.parameters import Parameter, TABLE_FRAME
from billiard_shot.scene import Scene


def guided_scene(name_or_path: str) -> Scene:
    """
    Load a scene whose cue is one that bearings guide, as the mechanism's is.

    Raises
    ------
    ValueError
        If there is no such scene, or its cue is not guided.

    """
    scene = Scene.load(name_or_path)
    if not scene.cue.guided:
        raise ValueError(
            f'scene: {name_or_path!r} is not allowed; its cue must be guided, as that of the '
            'mechanism is and as in the scenes paper and robot_table'
        )
    return scene


def _six_names(names: list[str]) -> None:
    if len(set(names)) != len(JOINTS) or not all(names):
        raise ValueError(
            f'joint_names: {list(names)} is not allowed; it must be {len(JOINTS)} '
            f'different names, in the order {", ".join(JOINTS)}'
        )


def _topic(name: str) -> None:
    if not name or ' ' in name:
        raise ValueError(f'topic {name!r} is not allowed; it must be the name of a topic')


SCENE = Parameter(
    'scene',
    'paper',
    'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file; its cue is '
    'guided.',
    check=guided_scene,
)
MECHANISM = Parameter(
    'mechanism',
    '',
    'Path of a YAML file with the mechanism; empty: the one in the library.',
    check=Mechanism.load,
)
JOINT_NAMES = Parameter(
    'joint_names',
    list(JOINTS),
    f'Names of the joints in the messages, in the order {", ".join(JOINTS)}.',
    check=_six_names,
)
INCLINE_JOINT = Parameter(
    'incline_joint',
    'incline_angle',
    'Name under which the elevation of the cue is published in joint_states.',
)
NICENESS = Parameter(
    'niceness',
    -10,
    'Scheduling priority that the node asks for, lower is more urgent; where it '
    'may not have it, it goes on without.',
    limits=(-20, 19),
    read_only=True,
)
TIMEOUT = {'unit': 's', 'limits': (0.05, 2.0)}
"""Longer silence than the upper limit is too long to wait for a stop."""

CUE_DRIVER = (
    TABLE_FRAME,
    SCENE,
    MECHANISM,
    JOINT_NAMES,
    Parameter('autostart', False, 'Configure and activate the node as it starts.', read_only=True),
    INCLINE_JOINT,
    Parameter(
        'incline_topic',
        '~/incline_angle',
        'Topic of the commanded angle of the incline.',
        check=_topic,
        read_only=True,
    ),
    Parameter(
        'actuation_topic',
        '~/actuation',
        'Topic of the commanded trajectories.',
        check=_topic,
        read_only=True,
    ),
    NICENESS,
    Parameter(
        'period', 0.02, 'Time between two commands.', unit='s', limits=(0.001, 0.1), read_only=True
    ),
    Parameter(
        'estop_timeout',
        0.5,
        'Silence on `estop` for longer than this is an emergency stop.',
        **TIMEOUT,
    ),
    Parameter(
        'interlock_timeout',
        0.5,
        'Silence on `interlock` for longer than this means that it is open.',
        **TIMEOUT,
    ),
    Parameter(
        'joints_timeout',
        0.5,
        'Silence on `joint_states` for longer than this is a fault.',
        **TIMEOUT,
    ),
    Parameter(
        'arm_timeout',
        5.0,
        'Armed for longer than this without firing, the cue disarms.',
        unit='s',
        limits=(0.1, 60.0),
    ),
    Parameter('settle_time', 0.1, 'Time from armed to the stroke.', unit='s', limits=(0.0, 10.0)),
    Parameter(
        'order_longest',
        600.0,
        'Longest time for which a goal may be valid.',
        unit='s',
        limits=(1.0, 3600.0),
    ),
    Parameter(
        'late',
        2.0,
        'How late the mechanism may be, which may take a while to hear the first command; '
        'later is a fault.',
        unit='s',
        limits=(0.1, 30.0),
    ),
    Parameter(
        'aim_tolerance',
        2e-4,
        'How near a joint must be to where it should, as a part of its range.',
        limits=(1e-9, 0.01),
    ),
    Parameter(
        'brake_tolerance',
        0.005,
        'How far the cue may go beyond where it should stop; farther is a fault.',
        unit='m',
        limits=(1e-4, 0.02),
    ),
    Parameter(
        'table_tolerance',
        0.001,
        'How far a ball may lie from where the plan has it.',
        unit='m',
        limits=(0.0, 0.02),
    ),
)

CUE_SIM = (
    replace(MECHANISM, read_only=True),
    replace(JOINT_NAMES, read_only=True),
    Parameter(
        'actuation_topic',
        'cue_driver/actuation',
        'Topic of the commanded trajectories.',
        check=_topic,
        read_only=True,
    ),
    NICENESS,
    Parameter(
        'deadline',
        0.5,
        'Without a command for longer than this the mechanism stops by itself; a command '
        'older than this is refused.',
        **TIMEOUT,
        read_only=True,
    ),
    Parameter(
        'rate',
        200.0,
        'How often joint_states is published.',
        unit='Hz',
        limits=(10.0, 1000.0),
        read_only=True,
    ),
    Parameter('seed', 0, 'Seed of everything random.', limits=(0, 2**31 - 1), read_only=True),
    Parameter(
        'bandwidth',
        150.0,
        'Natural frequency of the control loops.',
        unit='rad/s',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
    Parameter(
        'latency',
        0.0,
        'Time from a command to what it does.',
        unit='s',
        limits=(0.0, 1.0),
        read_only=True,
    ),
    Parameter(
        'noise',
        0.0,
        'Standard deviation of what disturbs the accelerations, relative to the largest ones.',
        limits=(0.0, 1.0),
        read_only=True,
    ),
    Parameter(
        'backlash',
        0.0,
        'Play of each joint, relative to its range.',
        limits=(0.0, 0.1),
        read_only=True,
    ),
    Parameter(
        'encoder_step',
        0.0,
        'Smallest difference that the encoders tell, relative to the range of the joint.',
        limits=(0.0, 0.1),
        read_only=True,
    ),
    Parameter('stuck_incline', False, 'Fault: the actuator of the incline does not move.'),
    Parameter('lost_encoder', False, 'Fault: joint_states has no numbers.'),
    Parameter(
        'late_brake',
        0.0,
        'Fault: the stroke brakes so much later than it should.',
        unit='s',
        limits=(0.0, 10.0),
    ),
    Parameter('dropped', 0.0, 'Fault: part of the commands that are lost.', limits=(0.0, 1.0)),
    Parameter('no_ball', False, 'Fault: the cue meets no ball.'),
)

TABLE_SIM = (
    TABLE_FRAME,
    replace(SCENE, read_only=True),
    Parameter(
        'strike_topic',
        'cue_driver/strike',
        'Topic of the measured strikes.',
        check=_topic,
        read_only=True,
    ),
    Parameter(
        'rate',
        30.0,
        'How often table_state is published while balls move.',
        unit='Hz',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
    Parameter(
        'haste',
        1.0,
        'How many times faster than real the balls move.',
        limits=(1e-3, 1e6),
        read_only=True,
    ),
)

TABLE_DISPLAY = (
    TABLE_FRAME,
    Parameter(
        'scene',
        'paper',
        'Table, and balls until table_state has come in: name of a bundled scene, or path of a '
        'YAML file.',
        check=Scene.load,
    ),
    MECHANISM,
    JOINT_NAMES,
)

CUE_MODEL = (
    TABLE_FRAME,
    MECHANISM,
    JOINT_NAMES,
    INCLINE_JOINT,
    Parameter(
        'rate',
        50.0,
        'How often transforms are published at most.',
        unit='Hz',
        limits=(1.0, 1000.0),
    ),
)


def read_into(kind: type, node: Node) -> Any:
    """Dataclass whose fields are the node's parameters of the same names."""
    return kind(**{field.name: node.get_parameter(field.name).value for field in fields(kind)})


def imperfections_of(node: Node) -> Imperfections:
    """How imperfect the simulated mechanism is wanted."""
    return read_into(Imperfections, node)


def faults_of(node: Node) -> Faults:
    """Which faults are wanted now."""
    return read_into(Faults, node)


def settings_of(node: Node) -> Settings:
    """
    Read what the controller goes by.

    Raises
    ------
    ValueError
        If the time-outs are too short for the period of the commands.

    """
    settings: Settings = read_into(Settings, node)
    period = node.get_parameter('period').value
    if settings.longest_pause < 2.0 * period:
        raise ValueError(
            f'estop_timeout, interlock_timeout, joints_timeout: {2 * settings.longest_pause:g} s '
            f'is not allowed; each must be at least four times the period of {period:g} s'
        )
    return settings

"""Parameters of the nodes around the mechanical cue."""

from dataclasses import fields, replace
from typing import Any

from rclpy.node import Node

from billiard_shot.cue.execution import Settings
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.simulated import Faults, Imperfections
from billiard_shot.ros.parameters import Parameter, TABLE_FRAME
from billiard_shot.scene import Scene


def guided_scene(name_or_path: str) -> Scene:
    """
    Load a scene, and check that its cue is guided, as the cue of the mechanism is.

    Raises
    ------
    ValueError
        If there is no such scene, or its cue is not guided.

    """
    scene = Scene.load(name_or_path)
    if not scene.cue.guided:
        raise ValueError(
            f'scene: {name_or_path!r} is not allowed; its cue must be guided, as in '
            'the scenes paper and robot_table'
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
    'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file. Its cue '
    'must be guided.',
    check=guided_scene,
)
MECHANISM = Parameter(
    'mechanism',
    '',
    'Path of a YAML file with the mechanism. If it is empty, the default mechanism is used.',
    check=Mechanism.load,
)
JOINT_NAMES = Parameter(
    'joint_names',
    list(JOINTS),
    f'Names of the joints in messages, in the order {", ".join(JOINTS)}.',
    check=_six_names,
)
INCLINE_JOINT = Parameter(
    'incline_joint',
    'incline_angle',
    'Name of the joint in joint_states that has the elevation of the cue.',
)
NICENESS = Parameter(
    'niceness',
    -10,
    'Niceness that the process requests; lower is more urgent. If the request is denied, the node '
    'runs without it.',
    limits=(-20, 19),
    read_only=True,
)


def _timeout(name: str, description: str, read_only: bool = False) -> Parameter:
    """Make the parameter of a time-out for a stop, at most 2 s: a later stop would be too late."""
    return Parameter(name, 0.5, description, unit='s', limits=(0.05, 2.0), read_only=read_only)


def _topic_parameter(name: str, default: str, description: str) -> Parameter:
    return Parameter(name, default, description, check=_topic, read_only=True)


def _interface(name: str) -> None:
    if name not in (TOPIC, FOLLOW_JOINT_TRAJECTORY):
        raise ValueError(
            f'interface must be {TOPIC!r} or {FOLLOW_JOINT_TRAJECTORY!r}, got {name!r}'
        )


TOPIC, FOLLOW_JOINT_TRAJECTORY = 'topic', 'follow_joint_trajectory'

CUE_DRIVER = (
    TABLE_FRAME,
    SCENE,
    MECHANISM,
    JOINT_NAMES,
    Parameter('autostart', False, 'Configure and activate the node at start-up.', read_only=True),
    INCLINE_JOINT,
    _topic_parameter(
        'incline_topic', '~/incline_angle', 'Topic of the commanded elevation of the cue.'
    ),
    Parameter(
        'interface',
        TOPIC,
        'How the mechanism is commanded: `topic`, a trajectory on `actuation_topic`, or '
        '`follow_joint_trajectory`, goals to the `controller`.',
        check=_interface,
        read_only=True,
    ),
    _topic_parameter(
        'actuation_topic',
        '~/actuation',
        'Topic of the commanded trajectories, if `interface` is `topic`.',
    ),
    _topic_parameter(
        'controller',
        'joint_trajectory_controller/follow_joint_trajectory',
        'Action of the controller, if `interface` is `follow_joint_trajectory`.',
    ),
    NICENESS,
    Parameter(
        'period', 0.02, 'Time between two commands.', unit='s', limits=(0.001, 0.1), read_only=True
    ),
    _timeout(
        'estop_timeout', 'If `estop` is silent for longer than this, it is an emergency stop.'
    ),
    _timeout(
        'interlock_timeout',
        'If `interlock` is silent for longer than this, it counts as open.',
    ),
    _timeout(
        'joint_states_timeout',
        'If `joint_states` is silent for longer than this, it is a fault.',
    ),
    Parameter(
        'arm_timeout',
        5.0,
        'If the cue is armed for longer than this without firing, it disarms.',
        unit='s',
        limits=(0.1, 60.0),
    ),
    Parameter(
        'settle_time',
        0.1,
        'Time from armed to the start of the stroke; below arm_timeout.',
        unit='s',
        limits=(0.0, 10.0),
    ),
    Parameter(
        'max_goal_validity',
        600.0,
        'Longest time for which a goal may be valid.',
        unit='s',
        limits=(1.0, 3600.0),
    ),
    Parameter(
        'motion_timeout',
        2.0,
        'Longest allowed delay behind the commanded trajectory, start-up included; beyond it the '
        'driver faults.',
        unit='s',
        limits=(0.1, 30.0),
    ),
    Parameter(
        'aim_tolerance',
        2e-4,
        'Largest error of the position of a joint, relative to its range.',
        limits=(1e-9, 0.01),
    ),
    Parameter(
        'brake_tolerance',
        0.005,
        'Largest distance by which the cue may overrun its planned stop; beyond it the driver '
        'faults.',
        unit='m',
        limits=(1e-4, 0.02),
    ),
    Parameter(
        'table_timeout',
        1.0,
        'Longest time since a message on `table_state` and, before aiming, since the last '
        'detection of each ball.',
        unit='s',
        limits=(0.05, 5.0),
        read_only=True,
    ),
    Parameter(
        'unseen_timeout',
        10.0,
        'Longest time since the last detection of each ball while a shot is aimed, because the '
        'cue hides balls.',
        unit='s',
        limits=(0.05, 60.0),
        read_only=True,
    ),
    Parameter(
        'stamp_tolerance',
        0.1,
        'Largest lead of the time of a detection ahead of the clock.',
        unit='s',
        limits=(0.0, 1.0),
        read_only=True,
    ),
    Parameter(
        'table_tolerance',
        0.001,
        'Largest distance of a ball from its planned place.',
        unit='m',
        limits=(0.0, 0.02),
    ),
)

CUE_SIM = (
    replace(MECHANISM, read_only=True),
    replace(JOINT_NAMES, read_only=True),
    _topic_parameter(
        'actuation_topic', 'cue_driver/actuation', 'Topic of the commanded trajectories.'
    ),
    NICENESS,
    _timeout(
        'command_timeout',
        'If no command arrives for longer than this, the mechanism stops. A command older than '
        'this is refused.',
        read_only=True,
    ),
    Parameter(
        'rate',
        200.0,
        'Rate at which joint_states is published.',
        unit='Hz',
        limits=(10.0, 1000.0),
        read_only=True,
    ),
    Parameter('seed', 0, 'Seed of all random numbers.', limits=(0, 2**31 - 1), read_only=True),
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
        'Delay from a command to its effect.',
        unit='s',
        limits=(0.0, 1.0),
        read_only=True,
    ),
    Parameter(
        'noise',
        0.0,
        'Standard deviation of the disturbance accelerations, relative to the largest '
        'accelerations.',
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
        'Resolution of the encoders, relative to the range of the joint.',
        limits=(0.0, 0.1),
        read_only=True,
    ),
    Parameter('stuck_incline', False, 'Fault: the actuator of the incline does not move.'),
    Parameter('lost_encoder', False, 'Fault: all numbers in joint_states are NaN.'),
    Parameter(
        'late_brake',
        0.0,
        'Fault: delay of the brake of the stroke.',
        unit='s',
        limits=(0.0, 10.0),
    ),
    Parameter(
        'command_loss_rate',
        0.0,
        'Fault: fraction of the commands that are lost.',
        limits=(0.0, 1.0),
    ),
    Parameter('no_ball', False, 'Fault: the cue meets no ball.'),
)

TABLE_SIM = (
    TABLE_FRAME,
    replace(SCENE, read_only=True),
    _topic_parameter('strike_topic', 'cue_driver/strike', 'Topic of the measured strikes.'),
    Parameter(
        'rate',
        30.0,
        'Rate at which the balls are published.',
        unit='Hz',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
    Parameter(
        'real_time_factor',
        1.0,
        'Speed of the simulation relative to real time.',
        limits=(1e-3, 1e6),
        read_only=True,
    ),
    Parameter(
        'camera',
        False,
        'Whether to publish `detections` of a camera instead of table_state; needs vision_msgs.',
        read_only=True,
    ),
    Parameter(
        'detection_noise',
        0.0005,
        'Standard deviation of a detected position, in each direction.',
        unit='m',
        limits=(1e-6, 0.1),
    ),
    Parameter(
        'detection_loss', 0.0, 'Fraction of the detections that are lost.', limits=(0.0, 1.0)
    ),
    Parameter(
        'detection_swap',
        0.0,
        'Fraction of the pictures in which two balls have the name of the other one.',
        limits=(0.0, 1.0),
    ),
    Parameter('seed', 0, 'Seed of all random numbers.', limits=(0, 2**31 - 1), read_only=True),
)

TABLE_DISPLAY = (
    TABLE_FRAME,
    Parameter(
        'scene',
        'paper',
        'Table, and balls until table_state has been received: name of a bundled scene, or path '
        'of a YAML file.',
        check=Scene.load,
    ),
    MECHANISM,
    JOINT_NAMES,
)

CUE_MODEL = (
    *(
        replace(each, read_only=True)
        for each in (TABLE_FRAME, MECHANISM, JOINT_NAMES, INCLINE_JOINT)
    ),
    Parameter(
        'rate',
        50.0,
        'Highest rate at which transforms are published.',
        unit='Hz',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
)


def read_into(kind: type, node: Node) -> Any:
    """Make a dataclass from the node's parameters with the names of its fields."""
    return kind(**{field.name: node.get_parameter(field.name).value for field in fields(kind)})


def imperfections_of(node: Node) -> Imperfections:
    """Read the imperfections of the simulated mechanism."""
    return read_into(Imperfections, node)


def faults_of(node: Node) -> Faults:
    """Read the current faults of the simulated mechanism."""
    return read_into(Faults, node)


def settings_of(node: Node) -> Settings:
    """
    Read the settings of the controller.

    Raises
    ------
    ValueError
        If the time-outs are too short for the period of the commands, or for `settle_time`.

    """
    settings: Settings = read_into(Settings, node)
    period = node.get_parameter('period').value
    if settings.max_pause < 2.0 * period:
        raise ValueError(
            'estop_timeout, interlock_timeout, joint_states_timeout: '
            f'{2 * settings.max_pause:g} s is not allowed; each must be at least four times the '
            f'period of {period:g} s'
        )
    if settings.settle_time >= settings.arm_timeout:
        raise ValueError(
            f'settle_time: {settings.settle_time:g} s is not allowed; it must be below '
            f'arm_timeout, {settings.arm_timeout:g} s, or the cue would disarm before it fires'
        )
    return settings

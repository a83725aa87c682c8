"""Parameters of the nodes around the mechanical cue."""

from dataclasses import fields, replace

from rclpy.node import Node

from billiard_shot.cue.execution import LATEST_STOP, MIN_DURATION, Settings
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.simulated import Faults, Imperfections
from billiard_shot.ros.parameters import node_parameters, NodeParameter, read_into, TABLE_FRAME
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
            'scene must be one with a guided cue, such as paper and robot_table, got '
            f'{name_or_path!r}'
        )
    return scene


def _six_names(names: list[str]) -> None:
    if len(set(names)) != len(JOINTS) or not all(names):
        raise ValueError(
            f'joint_names must be {len(JOINTS)} different names, in the order '
            f'{", ".join(JOINTS)}, got {list(names)}'
        )


def _topic(name: str) -> None:
    if not name or ' ' in name:
        raise ValueError(f'topic must be the name of a topic, got {name!r}')


SCENE_PARAMETER = NodeParameter(
    'scene',
    'paper',
    'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file. Its cue '
    'must be guided.',
    check=guided_scene,
)
MECHANISM = NodeParameter(
    'mechanism',
    '',
    'Path of a YAML file with the mechanism. If it is empty, the default mechanism is used.',
    check=Mechanism.load,
)
JOINT_NAMES = NodeParameter(
    'joint_names',
    list(JOINTS),
    f'Names of the joints in messages, in the order {", ".join(JOINTS)}.',
    check=_six_names,
)
INCLINE_JOINT = NodeParameter(
    'incline_joint',
    'incline_angle',
    'Name of the joint in joint_states that has the elevation of the cue.',
)
NICENESS = NodeParameter(
    'niceness',
    -10,
    'Niceness that the process requests; lower is more urgent. If the request is denied, the node '
    'runs without it.',
    limits=(-20, 19),
    read_only=True,
)


def _topic_parameter(name: str, default: str, description: str) -> NodeParameter:
    return NodeParameter(name, default, description, check=_topic, read_only=True)


def _interface(name: str) -> None:
    if name not in (TOPIC, FOLLOW_JOINT_TRAJECTORY):
        raise ValueError(
            f'interface must be {TOPIC!r} or {FOLLOW_JOINT_TRAJECTORY!r}, got {name!r}'
        )


TOPIC, FOLLOW_JOINT_TRAJECTORY = 'topic', 'follow_joint_trajectory'

CUE_DRIVER = (
    TABLE_FRAME,
    SCENE_PARAMETER,
    MECHANISM,
    JOINT_NAMES,
    NodeParameter(
        'autostart', False, 'Configure and activate the node at start-up.', read_only=True
    ),
    INCLINE_JOINT,
    _topic_parameter(
        'incline_topic', '~/incline_angle', 'Topic of the commanded elevation of the cue.'
    ),
    NodeParameter(
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
    NodeParameter(
        'period', 0.02, 'Time between two commands.', unit='s', limits=(0.001, 0.1), read_only=True
    ),
    *node_parameters(Settings, read_only=('table_timeout', 'unseen_timeout', 'stamp_tolerance')),
)

CUE_SIM = (
    replace(MECHANISM, read_only=True),
    replace(JOINT_NAMES, read_only=True),
    _topic_parameter(
        'actuation_topic', 'cue_driver/actuation', 'Topic of the commanded trajectories.'
    ),
    NICENESS,
    NodeParameter(
        'command_timeout',
        0.5,
        'If no command arrives for longer than this, the mechanism stops. A command older than '
        'this is refused.',
        unit='s',
        limits=(MIN_DURATION, LATEST_STOP),
        read_only=True,
    ),
    NodeParameter(
        'rate',
        200.0,
        'Rate at which joint_states is published.',
        unit='Hz',
        limits=(10.0, 1000.0),
        read_only=True,
    ),
    NodeParameter('seed', 0, 'Seed of all random numbers.', limits=(0, 2**31 - 1), read_only=True),
    *node_parameters(Imperfections, read_only=(each.name for each in fields(Imperfections))),
    *node_parameters(Faults),
)

TABLE_SIM = (
    TABLE_FRAME,
    replace(SCENE_PARAMETER, read_only=True),
    _topic_parameter('strike_topic', 'cue_driver/strike', 'Topic of the measured strikes.'),
    NodeParameter(
        'rate',
        30.0,
        'Rate at which the balls are published.',
        unit='Hz',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
    NodeParameter(
        'real_time_factor',
        1.0,
        'Speed of the simulation relative to real time.',
        limits=(1e-3, 1e6),
        read_only=True,
    ),
    NodeParameter(
        'camera',
        False,
        'Whether to publish `detections` of a camera instead of table_state; needs vision_msgs.',
        read_only=True,
    ),
    NodeParameter(
        'detection_noise',
        0.0005,
        'Standard deviation of a detected position, in each direction.',
        unit='m',
        limits=(1e-6, 0.1),
    ),
    NodeParameter(
        'detection_loss', 0.0, 'Fraction of the detections that are lost.', limits=(0.0, 1.0)
    ),
    NodeParameter(
        'detection_swap',
        0.0,
        'Fraction of the pictures in which two balls have the name of the other one.',
        limits=(0.0, 1.0),
    ),
    NodeParameter('seed', 0, 'Seed of all random numbers.', limits=(0, 2**31 - 1), read_only=True),
)

TABLE_DISPLAY = (
    TABLE_FRAME,
    NodeParameter(
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
    NodeParameter(
        'rate',
        50.0,
        'Highest rate at which transforms are published.',
        unit='Hz',
        limits=(1.0, 1000.0),
        read_only=True,
    ),
)


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
            'estop_timeout, interlock_timeout, joint_states_timeout must be at least four times '
            f'the period, {period:g}, got {2 * settings.max_pause:g} (s)'
        )
    if settings.settle_time >= settings.arm_timeout:
        raise ValueError(
            f'settle_time must be below arm_timeout, {settings.arm_timeout:g}, or the cue would '
            f'disarm before it fires, got {settings.settle_time:g} (s)'
        )
    return settings

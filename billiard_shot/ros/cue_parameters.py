"""Parameters of the nodes around the mechanical cue."""
from dataclasses import fields
from typing import Any

from rclpy.node import Node

from billiard_shot.cue.job import Settings
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.simulated import Faults, Imperfections
from billiard_shot.ros.parameters import Parameter
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
            'mechanism is, which throws the ball off line as no other does')
    return scene


def _six_names(names: list[str]) -> None:
    if len(set(names)) != len(JOINTS) or not all(names):
        raise ValueError(f'joint_names: {list(names)} is not allowed; it must be {len(JOINTS)} '
                         f'different names, in the order {", ".join(JOINTS)}')


def _topic(name: str) -> None:
    if not name or ' ' in name:
        raise ValueError(f'topic {name!r} is not allowed; it must be the name of a topic')


SCENE = Parameter(
    'scene', 'paper',
    'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file; its cue is '
    'guided.', check=guided_scene)
MECHANISM = Parameter(
    'mechanism', '', 'Path of a YAML file with the mechanism; empty: the one in the library.',
    check=Mechanism.load)
JOINT_NAMES = Parameter(
    'joint_names', list(JOINTS),
    f'Names of the joints in the messages, in the order {", ".join(JOINTS)}.', check=_six_names)
NICENESS = Parameter(
    'niceness', -10, 'Scheduling priority that the node asks for, lower is more urgent; where it '
    'may not have it, it goes on without.', limits=(-20, 19))
SECONDS = {'unit': 's', 'limits': (0.001, 3600.0)}

CUE_DRIVER = (
    SCENE, MECHANISM, JOINT_NAMES,
    Parameter('autostart', False, 'Configure and activate the node as it starts.'),
    Parameter('incline_joint', 'incline_angle',
              'Name under which the elevation of the cue is published in joint_states.'),
    Parameter('incline_topic', '~/incline_angle',
              'Topic of the commanded angle of the incline.', check=_topic),
    Parameter('actuation_topic', '~/actuation',
              'Topic of the commanded trajectories.', check=_topic),
    NICENESS,
    Parameter('period', 0.02, 'Time between two commands.', unit='s', limits=(0.001, 0.1)),
    Parameter('estop_timeout', 0.5,
              'Silence on `estop` for longer than this is an emergency stop.', **SECONDS),
    Parameter('interlock_timeout', 0.5,
              'Silence on `interlock` for longer than this means that it is open.', **SECONDS),
    Parameter('joints_timeout', 0.2,
              'Silence on `joint_states` for longer than this is a fault.', **SECONDS),
    Parameter('arm_timeout', 5.0,
              'Armed for longer than this without firing, the cue disarms.', **SECONDS),
    Parameter('settle_time', 0.1,
              'Time from armed to the stroke.', unit='s', limits=(0.0, 60.0)),
    Parameter('order_longest', 600.0,
              'Longest time for which a goal may be valid.', unit='s', limits=(1.0, 86400.0)),
    Parameter('late', 2.0,
              'How late the mechanism may be, which may take a while to hear the first command; '
              'later is a fault.', **SECONDS),
    Parameter('aim_tolerance', 2e-4,
              'How near a joint must be to where it should, as a part of its range.',
              limits=(1e-9, 0.1)),
    Parameter('brake_tolerance', 0.005,
              'How far the cue may go beyond where it should stop; farther is a fault.',
              unit='m', limits=(1e-4, 0.1)),
    Parameter('table_tolerance', 0.001,
              'How far a ball may lie from where the plan has it.', unit='m', limits=(0.0, 0.1)),
)

CUE_SIM = (
    MECHANISM, JOINT_NAMES,
    Parameter('actuation_topic', 'cue_driver/actuation',
              'Topic of the commanded trajectories.', check=_topic),
    NICENESS,
    Parameter('deadline', 0.2,
              'Without a command for longer than this the mechanism stops by itself.', **SECONDS),
    Parameter('rate', 200.0, 'How often joint_states is published.', unit='Hz',
              limits=(10.0, 1000.0)),
    Parameter('seed', 0, 'Seed of everything random.', limits=(0, 2**31 - 1)),
    Parameter('bandwidth', 150.0, 'Natural frequency of the control loops.',
              unit='rad/s', limits=(1.0, 1000.0)),
    Parameter('latency', 0.0, 'Time from a command to what it does.', unit='s',
              limits=(0.0, 1.0)),
    Parameter('noise', 0.0, 'Standard deviation of what disturbs the accelerations, relative to '
              'the largest ones.', limits=(0.0, 1.0)),
    Parameter('backlash', 0.0, 'Play of each joint, relative to its range.', limits=(0.0, 0.1)),
    Parameter('encoder_step', 0.0, 'Smallest difference that the encoders tell, relative to '
              'the range of the joint.', limits=(0.0, 0.1)),
    Parameter('stuck_incline', False, 'Fault: the actuator of the incline does not move.'),
    Parameter('lost_encoder', False, 'Fault: joint_states has no numbers.'),
    Parameter('late_brake', 0.0, 'Fault: the stroke brakes so much later than it should.',
              unit='s', limits=(0.0, 10.0)),
    Parameter('dropped', 0.0, 'Fault: part of the commands that are lost.', limits=(0.0, 1.0)),
    Parameter('no_ball', False, 'Fault: the cue meets no ball.'),
)

TABLE_SIM = (
    SCENE,
    Parameter('strike_topic', 'cue_driver/strike', 'Topic of the measured strikes.',
              check=_topic),
    Parameter('rate', 30.0, 'How often table_state is published while balls move.', unit='Hz',
              limits=(1.0, 1000.0)),
    Parameter('haste', 1.0, 'How many times faster than real the balls move.',
              limits=(1e-3, 1e6)),
)

TABLE_DISPLAY = (
    Parameter(
        'scene', 'paper',
        'Table, and balls until table_state has come in: name of a bundled scene, or path of a '
        'YAML file.', check=Scene.load),
    MECHANISM, JOINT_NAMES,
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
    """Read what the controller goes by."""
    return read_into(Settings, node)

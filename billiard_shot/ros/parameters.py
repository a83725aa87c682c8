"""Parameters of the nodes: fields of dataclasses, declared with full descriptors and checked."""

from collections.abc import Callable, Iterator
import dataclasses
from dataclasses import dataclass, replace
import math
import re
from typing import Any, ClassVar, TypeVar

from builtin_interfaces.msg import Time
from rcl_interfaces import msg
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Header

from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import descriptions, NUMBER, TAKES, WHOLE, whole_number

K = TypeVar('K')

CHECK = 'check'
MAX_SAMPLES = 10_000  # of the trajectories in one answer
SHOWN_SAMPLES = 200  # of a trajectory that is shown, on `predictor/path` and `planner/best`


def checked(default: Any, check: Callable[[Any], object]) -> Any:
    """Field whose bad values make `check` raise ValueError or OSError."""
    if isinstance(default, list):
        return dataclasses.field(default_factory=default.copy, metadata={CHECK: check})
    return dataclasses.field(default=default, metadata={CHECK: check})


def check_frame_name(name: str) -> None:
    """Raise ValueError if no frame can have a name."""
    if not name or name != name.strip('/ ') or len(name.split()) != 1:
        raise ValueError(
            "frame must be the name of a tf2 frame, without spaces and without '/' at either "
            f'end, got {name!r}'
        )


@dataclass(frozen=True)
class OfTable:
    """
    Parameter of all nodes that use positions on the table.

    Parameters
    ----------
    frame : str
        Frame of the table (REP-103), with its origin on the cloth at the centre of the bed. All
        messages that the node publishes are in this frame. Messages in another frame are refused.

    """

    READ_ONLY: ClassVar[Any] = ()
    frame: str = checked('table', check_frame_name)


def table_header(node: Node, stamp: Time | None = None) -> Header:
    """Make the header of a message of a node: the frame of the table; by default stamped now."""
    if stamp is None:
        stamp = node.get_clock().now().to_msg()
    return Header(frame_id=node.get_parameter('frame').value, stamp=stamp)


def declare(node: Node, *kinds: Any, fixed: Callable[[], str] = lambda: '') -> None:
    """
    Declare the parameters of a node, and refuse bad values from now on.

    The parameters are the fields of the dataclasses `kinds`. `READ_ONLY` of a dataclass names the
    fields whose values can be given only when the node starts; None stands for all fields. `fixed`
    returns why the parameters cannot be set at the moment; '' if they can. A bad value that is
    given at start-up raises rclpy.exceptions.ParameterException.
    """
    declared = {each.name: each for kind in kinds for each in dataclasses.fields(kind)}

    def mistake(setting: 'Parameter[Any]') -> str:
        if setting.name not in declared:
            return ''
        if reason := fixed():
            return f'{setting.name}: {reason}'
        if setting.value is None:  # rcl gives None for an empty list
            return f'{setting.name} must have a value, got none'
        rules = declared[setting.name].metadata
        try:
            if check := rules.get(CHECK) or rules.get(TAKES):
                check(setting.value)
        except (ValueError, OSError) as error:
            return str(error) if CHECK in rules else f'{setting.name} {error}'
        return ''

    def verify(settings: 'list[Parameter[Any]]') -> msg.SetParametersResult:
        reason = next(filter(None, map(mistake, settings)), '')
        return msg.SetParametersResult(successful=not reason, reason=reason)

    node.add_on_set_parameters_callback(verify)
    for kind in kinds:
        defaults = kind()
        for name, descriptor in descriptors(kind):
            node.declare_parameter(name, getattr(defaults, name), descriptor)


def values_of(kind: type[K], node: Node) -> K:
    """Make a dataclass from the node's parameters with the names of its fields."""
    names = (each.name for each in dataclasses.fields(kind))  # type: ignore[arg-type]
    return kind(**{name: node.get_parameter(name).value for name in names})


def descriptors(kind: Any) -> Iterator[tuple[str, msg.ParameterDescriptor]]:
    """Names and descriptors of parameters, as `declare` takes them; rclpy enforces the ranges."""
    words = descriptions(kind)
    for each in dataclasses.fields(kind):
        bounds = each.metadata.get(NUMBER) or each.metadata.get(WHOLE)
        unit = f' Unit: {bounds.unit}.' if bounds and bounds.unit else ''
        descriptor = msg.ParameterDescriptor(
            description=words[each.name].text + unit, read_only=is_read_only(kind, each.name)
        )
        if bounds and WHOLE in each.metadata:
            low, high = bounds.minimum, bounds.maximum
            descriptor.integer_range = [msg.IntegerRange(from_value=low, to_value=high)]
        elif bounds:
            low = float(bounds.above if bounds.minimum is None else bounds.minimum)
            high = math.inf if bounds.maximum is None else float(bounds.maximum)
            descriptor.floating_point_range = [
                msg.FloatingPointRange(from_value=low, to_value=high)
            ]
        yield each.name, descriptor


def is_read_only(kind: Any, name: str) -> bool:
    """Whether the value of a field can be given only when the node starts; see `declare`."""
    fixed = getattr(kind, 'READ_ONLY', ())
    return fixed is None or name in fixed


TOPIC_NAME = re.compile(r'(~?/)?[a-z_]\w*(/[a-z_]\w*)*', re.ASCII | re.IGNORECASE)
"""Names of topics, services and actions that ROS allows."""


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


def within_mechanism(scene: Scene, path: str) -> Scene:
    """Narrow the limits of a scene's robot to those of a mechanism; '' is none."""
    return replace(scene, robot=Mechanism.load(path).within(scene.robot)) if path else scene


def check_topic(name: str) -> None:
    """Raise ValueError if no topic or action can have a name."""
    if not TOPIC_NAME.fullmatch(name):
        raise ValueError(
            'topic must be words of letters, digits and _ with / between them, none of which '
            f'begins with a digit, got {name!r}'
        )


def _check_joints(names: list[str]) -> None:
    if len(set(names)) != len(JOINTS) or not all(names):
        raise ValueError(
            f'joint_names must be {len(JOINTS)} different names, in the order '
            f'{", ".join(JOINTS)}, got {list(names)}'
        )


@dataclass(frozen=True)
class OfGuidedScene:
    """
    Parameter of the nodes whose scene must have a guided cue.

    Parameters
    ----------
    scene : str
        Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file. Its cue
        must be guided.

    """

    scene: str = checked('paper', guided_scene)


@dataclass(frozen=True)
class OfMechanismFile:
    """
    Parameter of the nodes that know the mechanism.

    Parameters
    ----------
    mechanism : str
        Path of a YAML file with the mechanism. If it is empty, the default mechanism is used.

    """

    mechanism: str = checked('', Mechanism.load)


@dataclass(frozen=True)
class OfMechanism(OfMechanismFile):
    """
    Parameters of the nodes that know the mechanism and its joints.

    Parameters
    ----------
    joint_names : list of str
        Names of the joints in messages, in the order base_x, base_y, base_z, azimuth, incline,
        stroke.

    """

    joint_names: list[str] = checked(list(JOINTS), _check_joints)


@dataclass(frozen=True)
class OfUrgent:
    """
    Parameter of the nodes that must not be delayed.

    Parameters
    ----------
    niceness : int
        Niceness that the process requests; lower is more urgent. If the request is denied, the
        node runs without it.

    """

    niceness: int = whole_number(minimum=-20, maximum=19, default=-10)

"""Parameters of the nodes: declared with full descriptors, checked at start-up and when set."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from inspect import cleandoc
import re
from typing import Any

from builtin_interfaces.msg import Time
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter as Setting
from std_msgs.msg import Header

from billiard_shot.scene import Scene
from billiard_shot.scene.fields import NUMBER

MAX_SAMPLES = 10_000
"""Largest number of trajectory samples in one answer."""

FRAME = 'table'
"""Default of the parameter `frame` of all nodes."""


@dataclass(frozen=True, slots=True)
class NodeParameter:
    """
    One parameter of a node.

    Parameters
    ----------
    name : str
    default
        Its type is the type of the parameter.
    description : str
        Meaning of the parameter.
    unit : str
        Unit of the value; '' if it has no unit.
    limits : pair of numbers, optional
        Smallest and largest allowed value.
    check : callable, optional
        Raises ValueError or OSError for bad values within the limits.
    read_only : bool
        Whether the value can be given only when the node starts.

    """

    name: str
    default: Any
    description: str
    unit: str = ''
    limits: tuple[float, float] | None = None
    check: Callable[[Any], object] | None = None
    read_only: bool = False

    @property
    def descriptor(self) -> ParameterDescriptor:
        """Descriptor for `ros2 param describe`; rclpy itself enforces its range."""
        unit = f' Unit: {self.unit}.' if self.unit else ''
        result = ParameterDescriptor(description=self.description + unit, read_only=self.read_only)
        if self.limits and isinstance(self.default, float):
            low, high = self.limits
            result.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        elif self.limits:
            low, high = self.limits
            result.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
        return result


def node_parameters(kind: type, read_only: Iterable[str] = ()) -> tuple[NodeParameter, ...]:
    """
    Parameters for the fields of a dataclass (billiard_shot.scene.fields), with their ranges.

    Parameters
    ----------
    kind : type
        Its docstring describes each field under `Parameters`, in numpydoc form.
    read_only : iterable of str
        Names of the fields whose values can be given only when the node starts.

    """
    text = cleandoc(kind.__doc__ or '') + '\n'
    described = dict(re.findall(r'^(\w+) : .*\n((?:    .+\n)+)', text, re.MULTILINE))
    fixed = set(read_only)
    found = []
    for each in fields(kind):
        words = ' '.join(described[each.name].split())
        bounds = each.metadata.get(NUMBER)
        found.append(
            NodeParameter(
                each.name,
                each.default,
                re.sub(r' \[[^]]*\]\.$', '.', words),  # the unit is named below
                bounds.unit if bounds else '',
                (float(bounds.minimum), float(bounds.maximum)) if bounds else None,
                read_only=each.name in fixed,
            )
        )
    return tuple(found)


def read_into(kind: type, node: Node) -> Any:
    """Make a dataclass from the node's parameters with the names of its fields."""
    return kind(**{field.name: node.get_parameter(field.name).value for field in fields(kind)})


def _frame(name: str) -> None:
    if not name or name != name.strip('/ ') or len(name.split()) != 1:
        raise ValueError(
            "frame must be the name of a tf2 frame, without spaces and without '/' at either "
            f'end, got {name!r}'
        )


TABLE_FRAME = NodeParameter(
    'frame',
    FRAME,
    'Frame of the table (REP-103), with its origin on the cloth at the centre of the bed. All '
    'messages that the node publishes are in this frame. Messages in another frame are refused.',
    check=_frame,
)

PREDICTOR = (
    TABLE_FRAME,
    NodeParameter(
        'scene',
        'paper',
        'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file.',
        check=Scene.load,
    ),
    NodeParameter(
        'tolerance',
        1e-4,
        'Largest error of the trajectory on the cloth, if the request does not give one.',
        unit='m',
        limits=(1e-12, 1.0),
    ),
    NodeParameter(
        'sample_count',
        0,
        'Samples in the trajectory of an answer, if the request does not give a number. With 0 '
        'there are samples at the start, at changes of motion, and at rest.',
        limits=(0, MAX_SAMPLES),
    ),
    NodeParameter(
        'path_samples', 200, 'Number of poses on the topic `~/path`.', limits=(2, MAX_SAMPLES)
    ),
)


def table_header(node: Node, stamp: Time | None = None) -> Header:
    """Make the header of a message of a node: the frame of the table; by default stamped now."""
    if stamp is None:
        stamp = node.get_clock().now().to_msg()
    return Header(frame_id=node.get_parameter('frame').value, stamp=stamp)


def declare(
    node: Node,
    parameters: Iterable[NodeParameter],
    fixed: Callable[[], str] = lambda: '',
) -> None:
    """
    Declare `parameters`, and refuse bad values from now on.

    `fixed` returns why the parameters cannot be set at the moment; '' if they can.

    Raises
    ------
    rclpy.exceptions.ParameterException
        If a value given at start-up has the wrong type, is out of range, or fails its check.

    """
    parameters = tuple(parameters)
    checks = {parameter.name: parameter.check for parameter in parameters}

    def verify(settings: 'list[Setting[Any]]') -> SetParametersResult:
        for setting in settings:
            if setting.name not in checks:
                continue
            if reason := fixed():
                return SetParametersResult(successful=False, reason=f'{setting.name}: {reason}')
            try:
                if check := checks[setting.name]:
                    check(setting.value)
            except (ValueError, OSError) as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(verify)
    for parameter in parameters:
        node.declare_parameter(parameter.name, parameter.default, parameter.descriptor)

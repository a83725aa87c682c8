"""Parameters of the nodes: declared with a full descriptor, checked at start-up and when set."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

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

MAX_SAMPLES = 10_000
"""Largest number of trajectory samples in one answer."""

FRAME = 'table'
"""Default of the parameter `frame` of all nodes."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """
    One parameter of a node.

    Parameters
    ----------
    name, default
        The default's type is the parameter's type.
    description : str
        What it is, in one sentence.
    unit : str
        Unit of its value; '' where it has none.
    limits : pair of numbers, optional
        Smallest and largest allowed value.
    check : callable, optional
        Raises ValueError or OSError for a value that limits cannot rule out.
    read_only : bool
        Whether the value can only be given when the node starts.

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
        """What `ros2 param describe` shows; rclpy itself enforces the range in it."""
        unit = f' Unit: {self.unit}.' if self.unit else ''
        result = ParameterDescriptor(description=self.description + unit, read_only=self.read_only)
        if self.limits and isinstance(self.default, float):
            low, high = self.limits
            result.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        elif self.limits:
            low, high = self.limits
            result.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
        return result


def _frame(name: str) -> None:
    if not name or name != name.strip('/ ') or len(name.split()) != 1:
        raise ValueError(
            f'frame: {name!r} is not allowed; it must be the name of a tf2 frame, without spaces '
            "and without '/' at either end"
        )


TABLE_FRAME = Parameter(
    'frame',
    FRAME,
    'Frame of the table (REP-103), with its origin on the cloth at the centre of the bed: frame '
    'of all messages that the node publishes. Messages in another frame are refused.',
    check=_frame,
)

PREDICTOR = (
    TABLE_FRAME,
    Parameter(
        'scene',
        'paper',
        'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file.',
        check=Scene.load,
    ),
    Parameter(
        'tolerance',
        1e-4,
        'Largest error of the trajectory on the cloth where a request does not say.',
        unit='m',
        limits=(1e-12, 1.0),
    ),
    Parameter(
        'sample_count',
        0,
        'Samples in the trajectory of an answer, if the request does not say. 0: the start, every '
        'change of motion, and the rest.',
        limits=(0, MAX_SAMPLES),
    ),
    Parameter('path_samples', 200, 'Poses on the topic `~/path`.', limits=(2, MAX_SAMPLES)),
)


def table_header(node: Node) -> Header:
    """Header of a message of a node: the frame of the table, and the time now."""
    return Header(
        frame_id=node.get_parameter('frame').value, stamp=node.get_clock().now().to_msg()
    )


def declare(
    node: Node,
    parameters: Iterable[Parameter],
    fixed: Callable[[], str] = lambda: '',
) -> None:
    """
    Declare `parameters`, and refuse bad values from now on.

    `fixed` returns why none of them can be set at the moment; '' if they can.

    Raises
    ------
    rclpy.exceptions.ParameterException
        If a value given at start-up is of another type, out of range, or fails its check.

    """
    parameters = tuple(parameters)
    checks = {parameter.name: parameter.check for parameter in parameters}

    def verify(settings: list[Setting]) -> SetParametersResult:
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

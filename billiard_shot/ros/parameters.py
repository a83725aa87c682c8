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

from billiard_shot.scene import Scene

MAX_SAMPLES = 10_000
"""Largest number of trajectory samples in one answer."""


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

    """

    name: str
    default: Any
    description: str
    unit: str = ''
    limits: tuple[float, float] | None = None
    check: Callable[[Any], object] | None = None

    @property
    def descriptor(self) -> ParameterDescriptor:
        """What `ros2 param describe` shows; rclpy itself enforces the range in it."""
        unit = f' Unit: {self.unit}.' if self.unit else ''
        result = ParameterDescriptor(description=self.description + unit)
        if self.limits and isinstance(self.default, float):
            low, high = self.limits
            result.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        elif self.limits:
            low, high = self.limits
            result.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
        return result


PREDICTOR = (
    Parameter(
        'scene', 'paper',
        'Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file.',
        check=Scene.load,
    ),
    Parameter(
        'tolerance', 1e-4,
        'Largest error of the trajectory on the cloth where a request does not say.',
        unit='m', limits=(1e-12, 1.0),
    ),
    Parameter(
        'sample_count', 200,
        'Samples in the trajectory where a request does not say, and in the path.',
        limits=(2, MAX_SAMPLES),
    ),
)

def declare(node: Node, parameters: Iterable[Parameter]) -> None:
    """
    Declare `parameters`, and refuse bad values from now on.

    Raises
    ------
    rclpy.exceptions.ParameterException
        If a value given at start-up is of another type, out of range, or fails its check.

    """
    parameters = tuple(parameters)
    checks = {parameter.name: parameter.check for parameter in parameters if parameter.check}

    def verify(settings: list[Setting[Any]]) -> SetParametersResult:
        for setting in settings:
            try:
                if setting.name in checks:
                    checks[setting.name](setting.value)
            except (ValueError, OSError) as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(verify)
    for parameter in parameters:
        node.declare_parameter(parameter.name, parameter.default, parameter.descriptor)

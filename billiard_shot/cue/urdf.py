"""The mechanical cue in the Unified Robot Description Format (URDF), made from its mechanism."""

from collections.abc import Iterable, Sequence
import xml.etree.ElementTree as ET

from billiard_shot.cue.kinematics import home
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.model import FIXED, Joint, joints_of


def urdf_of(
    mechanism: Mechanism,
    frame: str = 'table',
    names: Sequence[str] = JOINTS,
    hardware: str = 'mock_components/GenericSystem',
) -> str:
    """
    Return the URDF of a mechanism on a table.

    Parameters
    ----------
    mechanism, frame, names
        Those of `model.joints_of`.
    hardware : str
        Plugin in the tag `ros2_control` that drives the joints `names`.

    """
    robot = ET.Element('robot', name='mechanical_cue')
    ET.SubElement(robot, 'link', name=frame)
    for joint in joints_of(mechanism, frame, names):
        _add_joint(robot, joint)
        _add_link(robot, joint)
    _add_control(robot, mechanism, names, hardware)
    ET.indent(robot)
    # No encoding is declared, because parsers of strings refuse an encoding declaration.
    return f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'


def _add_joint(robot: ET.Element, joint: Joint) -> None:
    element = ET.SubElement(robot, 'joint', name=joint.name, type=joint.kind)
    ET.SubElement(element, 'origin', xyz=_text(joint.origin), rpy=_text((0.0, 0.0, joint.yaw)))
    ET.SubElement(element, 'parent', link=joint.parent)
    ET.SubElement(element, 'child', link=joint.child)
    if joint.kind != FIXED:
        ET.SubElement(element, 'axis', xyz=_text(joint.axis))
        limits = {
            'lower': joint.min,
            'upper': joint.max,
            'velocity': joint.speed,
            'effort': joint.effort,
        }
        ET.SubElement(element, 'limit', {name: repr(value) for name, value in limits.items()})


def _add_link(robot: ET.Element, joint: Joint) -> None:
    link = ET.SubElement(robot, 'link', name=joint.child)
    if joint.part is None:
        return
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=_text(joint.centre))
    ET.SubElement(inertial, 'mass', value=repr(joint.part.mass))
    ixx, iyy, izz = map(repr, joint.part.inertia.tolist())
    ET.SubElement(inertial, 'inertia', ixx=ixx, iyy=iyy, izz=izz, ixy='0.0', ixz='0.0', iyz='0.0')
    for purpose in ('visual', 'collision') if joint.has_shape else ():
        element = ET.SubElement(link, purpose)
        ET.SubElement(element, 'origin', xyz=_text(joint.centre))
        geometry = ET.SubElement(element, 'geometry')
        ET.SubElement(geometry, 'box', size=_text(joint.part.size.tolist()))


def _add_control(
    robot: ET.Element, mechanism: Mechanism, names: Sequence[str], hardware: str
) -> None:
    """Add the interfaces of the joints for ros2_control; they start at rest above the table."""
    control = ET.SubElement(robot, 'ros2_control', name='mechanical_cue', type='system')
    plugin = ET.SubElement(control, 'hardware')
    ET.SubElement(plugin, 'plugin').text = hardware
    ET.SubElement(plugin, 'param', name='calculate_dynamics').text = 'true'  # measured velocities
    for name, position in zip(names, home(mechanism).tolist(), strict=True):
        joint = ET.SubElement(control, 'joint', name=name)
        ET.SubElement(joint, 'command_interface', name='position')
        state = ET.SubElement(joint, 'state_interface', name='position')
        ET.SubElement(state, 'param', name='initial_value').text = repr(position)
        ET.SubElement(joint, 'state_interface', name='velocity')


def _text(numbers: Iterable[float]) -> str:
    return ' '.join(map(repr, numbers))

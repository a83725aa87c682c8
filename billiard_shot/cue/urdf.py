"""The mechanical cue in the Unified Robot Description Format (URDF), made from its mechanism."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
import xml.etree.ElementTree as ET

from billiard_shot.cue.kinematics import home
from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism
from billiard_shot.cue.model import actuator_frame, chain, frame_names, Joint, tip_offset, X_AXIS

ACTUATOR_MASS = 0.01
"""Mass of the part that the actuator moves in the model [kg]; simulators refuse a mass of 0."""


def urdf_of(
    mechanism: Mechanism,
    frame: str = 'table',
    names: Sequence[str] = JOINTS,
    incline_joint: str = 'incline_angle',
    hardware: str = 'mock_components/GenericSystem',
) -> str:
    """
    Return the URDF of a mechanism on a table.

    Parameters
    ----------
    mechanism, frame, names, incline_joint
        Those of `model.chain`.
    hardware : str
        Plugin in the tag `ros2_control` that drives the joints `names`.

    """
    robot = ET.Element('robot', name='mechanical_cue')
    table, *_, cue, tip = frame_names(frame)
    ET.SubElement(robot, 'link', name=table)
    joints = chain(mechanism, frame, names, incline_joint)
    for joint in joints:
        _add_joint(robot, joint)
        _add_link(robot, joint)
    _add_actuator(robot, mechanism, joints[INCLINE], actuator_frame(frame), names[INCLINE])
    fixed = ET.SubElement(robot, 'joint', name='tip', type='fixed')
    ET.SubElement(fixed, 'origin', xyz=_text(tip_offset(mechanism)))
    ET.SubElement(fixed, 'parent', link=cue)
    ET.SubElement(fixed, 'child', link=tip)
    ET.SubElement(robot, 'link', name=tip)
    _add_control(robot, mechanism, names, hardware)
    ET.indent(robot)
    # No encoding is declared, because parsers of strings refuse an encoding declaration.
    return f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'


def _add_actuator(
    robot: ET.Element, mechanism: Mechanism, incline: Joint, frame: str, name: str
) -> None:
    """Add the actuator of the incline, which is commanded by its length."""
    axis = mechanism.incline
    # The force that turns the incline, at the shortest lever.
    effort = incline.effort * incline.speed / axis.speed
    limits = axis.min, axis.max, axis.speed, effort
    part = replace(incline.part, mass=ACTUATOR_MASS)
    joint = Joint(name, incline.parent, frame, False, X_AXIS, *limits, part, (0.0, 0.0, 0.0))
    _add_joint(robot, joint)
    _add_inertial(ET.SubElement(robot, 'link', name=frame), joint)


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


def _add_joint(robot: ET.Element, joint: Joint) -> None:
    kind = 'revolute' if joint.revolute else 'prismatic'
    element = ET.SubElement(robot, 'joint', name=joint.name, type=kind)
    ET.SubElement(element, 'parent', link=joint.parent)
    ET.SubElement(element, 'child', link=joint.child)
    ET.SubElement(element, 'axis', xyz=_text(joint.axis))
    ET.SubElement(
        element,
        'limit',
        lower=repr(joint.min),
        upper=repr(joint.max),
        velocity=repr(joint.speed),
        effort=repr(joint.effort),
    )


def _add_link(robot: ET.Element, joint: Joint) -> None:
    link = ET.SubElement(robot, 'link', name=joint.child)
    _add_inertial(link, joint)
    for purpose in ('visual', 'collision'):
        element = ET.SubElement(link, purpose)
        ET.SubElement(element, 'origin', xyz=_text(joint.centre))
        geometry = ET.SubElement(element, 'geometry')
        ET.SubElement(geometry, 'box', size=_text(joint.part.size.tolist()))


def _add_inertial(link: ET.Element, joint: Joint) -> None:
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=_text(joint.centre))
    ET.SubElement(inertial, 'mass', value=repr(joint.part.mass))
    ixx, iyy, izz = map(repr, joint.part.inertia.tolist())
    ET.SubElement(inertial, 'inertia', ixx=ixx, iyy=iyy, izz=izz, ixy='0.0', ixz='0.0', iyz='0.0')


def _text(numbers: Iterable[float]) -> str:
    return ' '.join(map(repr, numbers))

"""The mechanical cue in the Unified Robot Description Format (URDF), made from its mechanism."""

from collections.abc import Iterable, Sequence
import xml.etree.ElementTree as ET

from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.model import chain, frame_names, Joint, tip_offset


def urdf_of(
    mechanism: Mechanism,
    frame: str = 'table',
    names: Sequence[str] = JOINTS,
    incline_joint: str = 'incline_angle',
) -> str:
    """Return the URDF of a mechanism on a table; the parameters are those of `model.chain`."""
    robot = ET.Element('robot', name='mechanical_cue')
    table, *_, cue, tip = frame_names(frame)
    ET.SubElement(robot, 'link', name=table)
    for joint in chain(mechanism, frame, names, incline_joint):
        _add_joint(robot, joint)
        _add_link(robot, joint)
    fixed = ET.SubElement(robot, 'joint', name='tip', type='fixed')
    ET.SubElement(fixed, 'origin', xyz=_text(tip_offset(mechanism)))
    ET.SubElement(fixed, 'parent', link=cue)
    ET.SubElement(fixed, 'child', link=tip)
    ET.SubElement(robot, 'link', name=tip)
    ET.indent(robot)
    # No encoding is declared, because parsers of strings refuse an encoding declaration.
    return f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'


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
    inertial = ET.SubElement(link, 'inertial')
    ET.SubElement(inertial, 'origin', xyz=_text(joint.centre))
    ET.SubElement(inertial, 'mass', value=repr(joint.part.mass))
    ixx, iyy, izz = map(repr, joint.part.inertia.tolist())
    ET.SubElement(inertial, 'inertia', ixx=ixx, iyy=iyy, izz=izz, ixy='0.0', ixz='0.0', iyz='0.0')
    for purpose in ('visual', 'collision'):
        element = ET.SubElement(link, purpose)
        ET.SubElement(element, 'origin', xyz=_text(joint.centre))
        geometry = ET.SubElement(element, 'geometry')
        ET.SubElement(geometry, 'box', size=_text(joint.part.size.tolist()))


def _text(numbers: Iterable[float]) -> str:
    return ' '.join(map(repr, numbers))

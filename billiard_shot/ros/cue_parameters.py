"""Parameters that several nodes around the mechanical cue have, and their checks."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from dataclasses import dataclass, replace
import re

from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.ros.parameters import checked
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import whole_number

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

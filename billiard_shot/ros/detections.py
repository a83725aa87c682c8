"""Detections of balls in the messages of a camera (vision_msgs/msg/Detection3DArray)."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.perception.gate import (
    check_count,
    check_name,
    check_position,
    MAX_BALLS,
    plane_covariance,
)
from billiard_shot.perception.tracker import Detection
from billiard_shot.records import Array
from billiard_shot.ros.conversions import xyz
from billiard_shot.scene.errors import must_be


class Picture(NamedTuple):
    """Detections of balls in a picture."""

    balls: list[Detection]
    ignored: list[str]  # for each other detection, why it is ignored


def class_names_of(entries: Sequence[str]) -> dict[str, str]:
    """
    Names of balls by class id, from names such as `8` and pairs such as `white=cue`.

    Raises
    ------
    ValueError
        If a side of a pair is empty, or if a name is too long or has characters that do not print.

    """
    names = {}
    for entry in entries:
        class_id, sign, name = entry.partition('=')
        if not class_id or bool(sign) != bool(name):
            allowed = "names such as '8' or pairs such as 'white=cue'"
            raise ValueError(f'class_names {must_be(allowed, entry)}')
        names[class_id] = name or class_id
        check_name('class_names', f'{names[class_id]}_{MAX_BALLS}')  # of the last of its class
    return names


def picture_of(
    detections: Sequence[Any],
    names: Mapping[str, str],
    min_score: float,
    usual_variance: float,
    rotation: Array,
    translation: Array,
) -> Picture:
    """
    Read the detections of a picture.

    Parameters
    ----------
    detections : sequence of vision_msgs.msg.Detection3D
    names : mapping of str to str
        Names of balls by class id; detections of other classes are ignored.
    min_score : float
        Smallest score of a detection; others do not count.
    usual_variance : float
        Variance of x and y of detections without a covariance [m^2].
    rotation, translation : (3, 3) and (3,) ndarray
        From the frame of the picture to that of the table [m].

    Raises
    ------
    ValueError
        If there are more balls than on any table.

    """
    found, ignored = [], []
    for each in detections:
        best = max(each.results, key=lambda result: result.hypothesis.score, default=None)
        if best is None or not best.hypothesis.score >= min_score:
            continue
        if best.hypothesis.class_id in names:
            found.append((each, best))
        else:
            ignored.append(f'class_id {must_be("in class_names", best.hypothesis.class_id)}')
    check_count('detections of balls', found)
    balls = []
    for each, best in found:
        name, centre = names[best.hypothesis.class_id], best.pose.pose.position
        noise = np.reshape(best.pose.covariance, (6, 6))[:3, :3]
        if not best.pose.covariance.any() and xyz(centre) == (0.0, 0.0, 0.0):
            centre = each.bbox.center.position
        with np.errstate(all='ignore'):  # the gate refuses numbers that are not finite
            place = (rotation @ xyz(centre) + translation).tolist()
            turned = (rotation @ noise @ rotation.T).ravel().tolist()
        try:
            check_position(f'position of {name!r}', place)
            xx, xy, yy = plane_covariance(f'covariance of {name!r}', turned)
        except ValueError as error:
            ignored.append(str(error))
            continue
        if not xx * yy > xy * xy:
            xx, xy, yy = usual_variance, 0.0, usual_variance
        balls.append(Detection(name, (place[0], place[1]), (xx, xy, yy)))
    return Picture(balls, ignored)

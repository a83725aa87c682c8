"""Detections of balls in the messages of a camera (vision_msgs/msg/Detection3DArray)."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
import re
from typing import Any

import numpy as np

from billiard_shot.perception import gate
from billiard_shot.perception.tracker import Detection
from billiard_shot.records import Array
from billiard_shot.ros.conversions import xyz
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.placement import CUE_BALL

CLASS = re.compile(r'(?:(?P<class_id>[^=*]+)=)?(?P<name>[^=*]+)(?:\*(?P<count>[1-9]\d?))?')
"""A class of detections: its id, if that is not the name of the ball, and the number of balls."""


def class_names_of(entries: Sequence[str]) -> dict[str, str]:
    """Names of balls by class id, from entries such as `8`, `white=cue` and `solid*7`."""
    names = {}
    for entry in entries:
        found = CLASS.fullmatch(entry)
        most = 1 if found and found['name'] == CUE_BALL else gate.MAX_BALLS
        if not found or int(found['count'] or 1) > most:
            allowed = f"such as '8', 'white=cue' or 'solid*7', with at most {most} balls"
            raise ValueError(f'class_names {must_be(allowed, entry)}')
        names[found['class_id'] or found['name']] = found['name']
        gate.check_name('class_names', f'{found["name"]}_{gate.MAX_BALLS}')  # the longest name
    return names


def class_counts_of(entries: Sequence[str], balls: Iterable[str]) -> dict[str, int]:
    """
    Numbers of balls of classes with more than one, by name.

    A number that is not stated is that of the `balls` of a scene, named `solid`, `solid_2`, ...
    """
    counts = Counter(re.sub(r'_\d+$', '', name) for name in balls)
    for found in filter(None, map(CLASS.fullmatch, entries)):
        if found['count']:
            counts[found['name']] = int(found['count'])
    return counts | Counter([CUE_BALL])


def detected_balls(
    detections: Sequence[Any],
    names: Mapping[str, str],
    min_score: float,
    usual_variance: float,
    rotation: Array,
    translation: Array,
) -> tuple[list[Detection], list[str]]:
    """
    Balls of a picture in the frame of the table, and why each other detection is ignored.

    Detections of classes that have no name in `names`, which are by class id, are ignored, and so
    are those that do not pass the gate. If a detection has no covariance, x and y have the
    `usual_variance` [m^2]. More balls than a table can have raise ValueError.
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
    gate.check_count('detections of balls', found)
    balls = []
    for each, best in found:
        name, centre = names[best.hypothesis.class_id], best.pose.pose.position
        noise = best.pose.covariance.reshape(6, 6)
        if not noise.any() and xyz(centre) == (0.0, 0.0, 0.0):
            centre = each.bbox.center.position
        with np.errstate(all='ignore'):  # the gate refuses numbers that are not finite
            place = (rotation @ xyz(centre) + translation).tolist()
            turned = (rotation @ noise[:3, :3] @ rotation.T).ravel().tolist()
        try:
            gate.check_position(f'position of {name!r}', place)
            xx, xy, yy = gate.plane_covariance(f'covariance of {name!r}', turned)
        except ValueError as error:
            ignored.append(str(error))
            continue
        if not xx * yy > xy * xy:
            xx, xy, yy = usual_variance, 0.0, usual_variance
        balls.append(Detection(name, (place[0], place[1]), (xx, xy, yy)))
    return balls, ignored

"""Parameters of the node that tracks the balls of a table."""

from billiard_shot.cue.tracker import TrackerSettings
from billiard_shot.ros.parameters import NodeParameter, TABLE_FRAME
from billiard_shot.scene import Scene

DEFAULTS = TrackerSettings()


def class_names_of(pairs: list[str]) -> dict[str, str]:
    """
    Names of balls by class id, from pairs such as `white=cue`.

    Raises
    ------
    ValueError
        If a pair has no equals sign, or an empty side.

    """
    names = {}
    for pair in pairs:
        class_id, sign, name = pair.partition('=')
        if not (class_id and sign and name):
            raise ValueError(f"class_names must be pairs such as 'white=cue', got {pair!r}")
        names[class_id] = name
    return names


TABLE_TRACKER = (
    TABLE_FRAME,
    NodeParameter(
        'scene',
        'paper',
        'Radius of the balls, and pockets: name of a bundled scene, or path of a YAML file.',
        check=Scene.load,
        read_only=True,
    ),
    NodeParameter(
        'class_names',
        ['cue=cue'],
        'Names of balls by the class ids of the detections, as pairs such as `white=cue`. Every '
        'other class id is the name of a ball itself.',
        check=class_names_of,
        read_only=True,
    ),
    NodeParameter(
        'detection_noise',
        0.0005,
        'Standard deviation of a detected position, in each direction, if the detection has no '
        'covariance.',
        unit='m',
        limits=(1e-6, 0.1),
        read_only=True,
    ),
    NodeParameter(
        'min_score',
        0.5,
        'Smallest score of a detection that is used.',
        limits=(0.0, 1.0),
        read_only=True,
    ),
    NodeParameter(
        'window',
        DEFAULTS.window,
        'Largest number of detections from which the position of a ball at rest is estimated.',
        limits=(10, 10_000),
        read_only=True,
    ),
    NodeParameter(
        'settled',
        DEFAULTS.settled,
        'Number of detections at one place after which a ball counts as being at rest.',
        limits=(2, 5),
        read_only=True,
    ),
    NodeParameter(
        'lost_after',
        DEFAULTS.lost_after,
        'Time without a detection after which the state of a ball is UNKNOWN.',
        unit='s',
        limits=(0.05, 10.0),
        read_only=True,
    ),
    NodeParameter(
        'repeat_period',
        0.2,
        'Time after which table_state is repeated if there are no detections.',
        unit='s',
        limits=(0.01, 10.0),
        read_only=True,
    ),
)

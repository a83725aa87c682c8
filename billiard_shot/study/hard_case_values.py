"""
Stated results of the hard cases.

The table hard_cases.csv comes from test/study/stated_values.py, which shares no code with the
solver.
"""

import csv
import functools
from importlib import resources

ReferenceValue = tuple[float, tuple[tuple[float, ...], ...]]


@functools.cache
def stated_values() -> dict[tuple[str, str, str], ReferenceValue]:
    """
    Return the results that the cases must give, by family, member and law.

    Returns
    -------
    dict
        Largest error allowed, relative to the speed, and the alternatives (two if law `energetic`
        is discontinuous) of the motion as in `Collision.motion`.

    """
    values: dict[tuple[str, str, str], ReferenceValue] = {}
    with resources.files('billiard_shot.study').joinpath('hard_cases.csv').open() as file:
        for row in csv.DictReader(file):
            key = row['family'], row['member'], row['law']
            _, alternatives = values.get(key, (0.0, ()))
            motion = tuple(float(number) for number in row['motion'].split())
            values[key] = float(row['within']), (*alternatives, motion)
    return values

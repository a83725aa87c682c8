"""Penalties: distances between paths and points."""

import math

import numpy as np
import pytest

from billiard_shot.planning.score import nearest
from billiard_shot.table.model.motion import SegmentRecord


def segment_of(draw):
    """A stretch of motion on the cloth."""
    segment = SegmentRecord()
    segment.position[:2] = draw.uniform(-1.0, 1.0, 2).tolist()
    segment.velocity[:2] = draw.uniform(-2.0, 2.0, 2).tolist()
    segment.acceleration[:2] = draw.uniform(-2.0, 2.0, 2).tolist()
    return segment


def test_a_segment_counts_only_if_it_comes_nearer_than_others():
    draw = np.random.default_rng(1)
    skipped = 0
    for _ in range(400):
        segment, lasting = segment_of(draw), float(draw.choice([0.0, 0.1, 1.0]))
        x, y, least = draw.uniform((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0)).tolist()
        distance = nearest(segment, lasting, x, y, math.inf)
        assert nearest(segment, lasting, x, y, least) == min(distance, least)
        skipped += distance > least
        times = np.linspace(0.0, lasting, 200)[:, np.newaxis]
        p, v, a = (
            np.array(each[:2])
            for each in (segment.position, segment.velocity, segment.acceleration)
        )
        path = p + times * (v + 0.5 * times * a)
        exact = np.hypot(*(path - (x, y)).T).min()
        assert distance == pytest.approx(exact, abs=0.02)  # by straight pieces
    assert 50 < skipped < 350

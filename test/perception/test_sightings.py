"""Balls that have moved are told from balls that were measured with errors."""

from dataclasses import replace
import math

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot.perception.sightings import largest_deviation, moved, Sighting
from billiard_shot.perception.sightings import uncertain as is_uncertain

TOLERANCE = 1e-3


def sightings(places):
    return {name: Sighting(place) for name, place in places.items()}


PLANNED = sightings({'cue': (0.0, 0.0), '8': (0.5, 0.0)})


def uncertain(x, y, deviation):
    return Sighting((x, y), (deviation**2, 0.0, deviation**2))


@pytest.mark.parametrize(
    ('seen', 'words'),
    [
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0)}, ''),
        ({'cue': (0.0005, 0.0), '8': (0.5, -0.0009)}, ''),
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0011)}, "'8' lies 1.1 mm"),
        ({'cue': (0.0, 0.0)}, "'8' of the plan is not on the table"),
        ({'cue': (0.0, 0.0), '8': (0.5, 0.0), '9': (0, 1)}, "'9' is on the table, but not in"),
        ({'cue': (float('nan'), 0.0), '8': (0.5, 0.0)}, "'cue' lies nan"),
    ],
)
def test_exact_positions(seen, words):
    said = moved(PLANNED, sightings(seen), TOLERANCE)
    assert words in said
    assert bool(words) == bool(said)


@pytest.mark.parametrize(
    ('change', 'words'),
    [({'is_seen': False}, "'8' is not seen"), ({'is_moving': True}, "'8' moves")],
)
def test_a_ball_that_is_not_known_to_rest_there(change, words):
    seen = {**PLANNED, '8': replace(PLANNED['8'], **change)}
    assert words in moved(PLANNED, seen, TOLERANCE)


@pytest.mark.parametrize('noise', [0.13e-3, 0.5e-3, 2.3e-3])
def test_the_uncertainty_of_both_positions_is_no_motion(noise):
    """Of 20,000 pairs of single detections of a ball at rest, at most 1 in 3000 differs."""
    random = np.random.default_rng(1)
    wrong = sum(
        bool(
            moved(
                {'8': uncertain(*random.normal(0.0, noise, 2), noise)},
                {'8': uncertain(*random.normal(0.0, noise, 2), noise)},
                0.0,
            )
        )
        for _ in range(20_000)
    )
    assert wrong <= 20_000 / 3000 + 3 * math.sqrt(20_000 / 3000)


@given(
    st.floats(-math.pi, math.pi),
    st.floats(1e-5, 1e-3),
    st.floats(1e-5, 1e-3),
    st.floats(-math.pi, math.pi),
)
def test_only_the_uncertainty_along_the_distance_counts(heading, along, across, turn):
    """Turning everything changes nothing."""

    def said(angle):
        c, s = math.cos(angle), math.sin(angle)
        matrix = np.array([[c, -s], [s, c]])
        (xx, xy), (_, yy) = matrix @ np.diag([along**2, across**2]) @ matrix.T
        planned = {'8': Sighting((0.0, 0.0), (xx, xy, yy))}
        away = TOLERANCE + 4.0 * along
        return [
            bool(moved(planned, sightings({'8': (share * away * c, share * away * s)}), TOLERANCE))
            for share in (0.99, 1.01)
        ]

    assert said(heading) == said(turn) == [False, True]


def test_a_systematic_error_counts_for_plans_but_hides_no_motion():
    """Plan and picture are of one camera: its errors are the same in both."""
    biased = {name: replace(ball, systematic_error=0.5e-3) for name, ball in PLANNED.items()}
    assert largest_deviation(biased) == pytest.approx(0.5e-3)
    both = {'cue': replace(uncertain(0.0, 0.0, 1.2e-3), systematic_error=0.5e-3)}
    assert largest_deviation(both) == pytest.approx(1.3e-3)
    assert not is_uncertain(biased, biased, 1.5e-3)
    assert not moved(biased, biased, TOLERANCE)
    seen = biased | {'8': replace(biased['8'], position=(0.5, 1.1e-3))}
    assert "ball '8' lies 1.1 mm from its planned place" in moved(biased, seen, TOLERANCE)

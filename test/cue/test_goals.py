import pytest

from billiard_shot.cue.goals import check_goal, remember, REMEMBERED
from billiard_shot.cue.outcome import GoalOutcome, RefusedError


def refusal(shot_id='shot', remaining=60.0, played=()):
    with pytest.raises(RefusedError) as caught:
        check_goal(shot_id, remaining, played, 600.0)
    assert str(caught.value)
    return caught.value.outcome


def test_a_shot_is_played_once():
    played = {}
    check_goal('a', 60.0, played, 600.0)
    remember('a', played)
    assert refusal('a', played=played) is GoalOutcome.ALREADY_PLAYED
    check_goal('b', 60.0, played, 600.0)


@pytest.mark.parametrize(
    ('remaining', 'outcome'),
    [
        (0.0, GoalOutcome.ALREADY_EXPIRED),
        (-5.0, GoalOutcome.ALREADY_EXPIRED),
        (float('nan'), GoalOutcome.ALREADY_EXPIRED),
        (600.1, GoalOutcome.INVALID_PLAN),
    ],
)
def test_expiry(remaining, outcome):
    assert refusal(remaining=remaining) is outcome


def test_memory_is_bounded():
    played = {}
    for i in range(REMEMBERED + 10):
        remember(str(i), played)
    assert refusal('10', played=played) is GoalOutcome.ALREADY_PLAYED
    check_goal('9', 60.0, played, 600.0)

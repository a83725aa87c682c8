import pytest

from billiard_shot.cue.inputs import check_goal
from billiard_shot.cue.plan import GoalOutcome, RefusedError


def refusal(shot_id='shot', remaining=60.0, played=()):
    with pytest.raises(RefusedError) as caught:
        check_goal(shot_id, remaining, played, 600.0)
    assert str(caught.value)
    return caught.value.outcome


def test_a_shot_is_played_once():
    check_goal('b', 60.0, ['a'], 600.0)
    assert refusal('a', played=['a']) is GoalOutcome.ALREADY_PLAYED


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

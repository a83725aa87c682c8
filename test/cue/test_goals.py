from plans import plan_of
import pytest

from billiard_shot.cue.goals import check_goal, remember, REMEMBERED, ShotGoal
from billiard_shot.cue.outcome import GoalOutcome, RefusedError


def goal_of(shot_id='shot', remaining=60.0):
    return ShotGoal(plan_of((0.1, 0.1, 0.1, 0.0, 2.0), shot_id=shot_id), remaining)


def refusal(goal, played=()):
    with pytest.raises(RefusedError) as caught:
        check_goal(goal, played, 600.0)
    assert str(caught.value)
    return caught.value.outcome


def test_a_shot_is_played_once():
    played = {}
    check_goal(goal_of('a'), played, 600.0)
    remember('a', played)
    assert refusal(goal_of('a'), played) is GoalOutcome.ALREADY_PLAYED
    check_goal(goal_of('b'), played, 600.0)


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
    assert refusal(goal_of(remaining=remaining)) is outcome


def test_memory_is_bounded():
    played = {}
    for i in range(REMEMBERED + 10):
        remember(str(i), played)
    assert refusal(goal_of('10'), played) is GoalOutcome.ALREADY_PLAYED
    check_goal(goal_of('9'), played, 600.0)

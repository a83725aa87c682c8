from plans import plan_of
import pytest

from billiard_shot.cue.goals import GoalRegistry, REMEMBERED, ShotGoal
from billiard_shot.cue.outcome import GoalOutcome, RefusedError


def goal_of(shot_id='shot', remaining=60.0):
    return ShotGoal(plan_of((0.1, 0.1, 0.1, 0.0, 2.0), shot_id=shot_id), remaining)


def refusal(registry, goal):
    with pytest.raises(RefusedError) as caught:
        registry.check(goal)
    assert str(caught.value)
    return caught.value.outcome


def test_a_shot_is_played_once():
    registry = GoalRegistry(600.0)
    registry.check(goal_of('a'))
    registry.check(goal_of('a'))  # nothing has moved for it yet
    registry.use('a')
    assert refusal(registry, goal_of('a')) is GoalOutcome.ALREADY_PLAYED
    registry.check(goal_of('b'))


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
    assert refusal(GoalRegistry(600.0), goal_of(remaining=remaining)) is outcome


def test_memory_is_bounded():
    registry = GoalRegistry(600.0)
    for i in range(REMEMBERED + 10):
        registry.use(str(i))
    assert refusal(registry, goal_of('10')) is GoalOutcome.ALREADY_PLAYED
    registry.check(goal_of('9'))


def test_new_settings_forget_no_shot():
    before, after = GoalRegistry(600.0), GoalRegistry(60.0)
    before.use('a')
    after.take_over(before)
    assert refusal(after, goal_of('a')) is GoalOutcome.ALREADY_PLAYED

from dataclasses import replace

from plans import goal_of, plan_of
import pytest

from billiard_shot.cue.goals import GoalRegistry, moved, REMEMBERED
from billiard_shot.cue.outcome import Outcome, RefusedError

PLAN = plan_of((0.1, 0.1, 0.1, 0.0, 2.0))


def refusal(registry, goal):
    with pytest.raises(RefusedError) as caught:
        registry.register(goal)
    assert str(caught.value)
    return caught.value.outcome


def test_a_nonce_is_good_for_one_goal():
    registry = GoalRegistry(600.0)
    registry.register(goal_of(PLAN, 'a'))
    assert refusal(registry, goal_of(PLAN, 'a')) is Outcome.NONCE_REPEATED
    registry.register(goal_of(PLAN, 'b'))
    # used up by a refused goal too
    assert refusal(registry, goal_of(PLAN, 'c', remaining=-1.0)) is Outcome.ALREADY_EXPIRED
    assert refusal(registry, goal_of(PLAN, 'c')) is Outcome.NONCE_REPEATED
    assert refusal(registry, goal_of(PLAN, '')) is Outcome.INVALID_PLAN


@pytest.mark.parametrize(
    ('remaining', 'outcome'),
    [
        (0.0, Outcome.ALREADY_EXPIRED),
        (-5.0, Outcome.ALREADY_EXPIRED),
        (float('nan'), Outcome.ALREADY_EXPIRED),
        (600.1, Outcome.INVALID_PLAN),
    ],
)
def test_expiry(remaining, outcome):
    assert refusal(GoalRegistry(600.0), goal_of(PLAN, remaining=remaining)) is outcome


def test_a_changed_plan_is_refused():
    registry = GoalRegistry(600.0)
    other = replace(PLAN, speed=2.5)
    assert refusal(registry, goal_of(other, 'a', seal=PLAN.seal)) is Outcome.PLAN_CHANGED
    registry.register(goal_of(PLAN, 'b'))
    assert refusal(registry, goal_of(other, 'c')) is Outcome.PLAN_CHANGED
    registry.register(goal_of(replace(other, shot_id='another'), 'd'))


def test_memory_is_bounded():
    registry = GoalRegistry(600.0)
    for i in range(REMEMBERED + 10):
        registry.register(goal_of(PLAN, str(i)))
    assert refusal(registry, goal_of(PLAN, '10')) is Outcome.NONCE_REPEATED
    registry.register(goal_of(PLAN, '9'))


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
def test_a_table_that_moved(seen, words):
    said = moved({'cue': (0.0, 0.0), '8': (0.5, 0.0)}, seen, 0.001)
    assert words in said
    assert bool(words) == bool(said)

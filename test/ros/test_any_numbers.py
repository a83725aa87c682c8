"""Any numbers in any field of a message: it is read, or refused by name; nothing else happens."""

from contextlib import suppress
from itertools import cycle

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import (
    BallState,
    Plan,
    Strike,
    StrokeLimits,
    StrokeNoise,
    TableState,
    Target,
)
from billiard_shot_msgs.srv import PredictShot
from hypothesis import example, given
from hypothesis import strategies as st
import numpy as np

from billiard_shot import Scene
from billiard_shot.cue.plan import RefusedError
from billiard_shot.perception.sightings import largest_deviation, moved, Sighting
from billiard_shot.planning.problem import limits_of
from billiard_shot.planning.targets import target_of
from billiard_shot.planning.within_noise import noise_of
from billiard_shot.ros import conversions, plan_conversions, table_display
from billiard_shot.ros.plan_conversions import PlanRequest

SCENE = Scene.load('robot_table')
DEFAULT = PlanRequest(SCENE, {'pot': '8'}, SCENE.noise, {}, 2000, 1)
NUMBERS = st.lists(
    st.floats(width=64) | st.floats(-0.5, 0.5) | st.sampled_from([0.0, 1.0, 1e160, 1e308]),
    min_size=1,
    max_size=60,
)


def fill(message, numbers):
    """Put numbers into all fields of a message that take a float64, over and over."""
    values = cycle(numbers)

    def put(part):
        for field, kind in part.get_fields_and_field_types().items():
            value = getattr(part, field)
            if kind == 'double':
                setattr(part, field, next(values))
            elif kind.startswith('double['):
                setattr(part, field, [next(values) for _ in value])
            elif kind.startswith('sequence<billiard_shot_msgs'):
                for each in value:
                    put(each)
            elif '/' in kind and not kind.startswith('sequence'):
                put(value)

    put(message)
    return message


def balls():
    return [BallState(id='cue'), BallState(id='8'), BallState(id='9', state=BallState.UNKNOWN)]


@given(NUMBERS)
@example([1e308])
@example([1e160])
@example([0.1, 0.0, 0.0, *[0.0] * 9, 0.5, 0.0, 0.0, *[0.0] * 9])
def test_a_table(numbers):
    table = fill(TableState(balls=balls()), numbers)
    for use in (
        lambda: conversions.table_scene(SCENE, table, 'table'),
        lambda: table_display.ball_centres(table, 0.03),
    ):
        with suppress(ValueError):
            use()
    with suppress(ValueError):
        seen = conversions.sightings_of(table.balls)
        assert all(abs(each) <= 10.0 for ball in seen.values() for each in ball.position)
        here = {name: Sighting((0.0, 0.0)) for name in seen}
        moved(here, seen, 0.001)
        largest_deviation(seen)


@given(NUMBERS, st.booleans())
@example([1e308], False)
@example([1e160], True)
def test_a_request_for_a_prediction(numbers, use_table_state):
    table = TableState(balls=balls()[:2])
    table.balls[1].position.x = 0.5
    request = fill(PredictShot.Request(use_table_state=use_table_state), numbers)
    with suppress(ValueError):
        _, ball = conversions.place_balls(request, SCENE, table, 'table')
        stroke = conversions.stroke_of(request.cue_pose, request.speed, ball)
        assert np.isfinite([*stroke.normal, *stroke.velocity]).all()


@given(NUMBERS)
@example([1e308])
def test_a_plan_and_a_strike(numbers):
    with suppress(RefusedError):
        conversions.shot_plan_of(fill(Plan(shot_id='a', balls=balls()), numbers), 'table')
    with suppress(ValueError):
        conversions.measured_stroke(fill(Strike(shot_id='a'), numbers), SCENE.cue_ball)


@given(NUMBERS, st.integers(0, 6), st.booleans())
@example([1e308], Target.HIT, True)
@example([1e160], Target.POT, True)
def test_a_goal_of_the_planner(numbers, kind, use):
    goal = fill(
        PlanShot.Goal(
            target=Target(kind=kind, balls=['8'], use_point=use, use_direction=use),
            balls=balls()[: 2 * use],
            limits=[StrokeLimits()] * use,
            noise=[StrokeNoise()],
        ),
        numbers,
    )
    with suppress(ValueError):
        request = plan_conversions.plan_request_of(goal, DEFAULT, None, 'table')
        noise = noise_of(request.scene, request.noise)
        target_of(request.scene, request.target)
        limits_of(request.scene, request.constraints, noise)


@pytest.mark.parametrize(
    'field', ['balls', 'first_contact', 'keep', 'target.balls', 'target.pockets']
)
def test_names_are_counted_before_they_are_compared(field):
    goal, many = PlanShot.Goal(), 2000
    *_, parent = (goal, goal.target) if '.' in field else (goal,)
    names = [BallState(id='cue')] * many if field == 'balls' else ['8'] * many
    setattr(parent, field.rpartition('.')[2], names)
    with pytest.raises(ValueError, match=f'^{field} must have at most 64 elements, got {many}$'):
        plan_conversions.plan_request_of(goal, DEFAULT, None, 'table')


@pytest.mark.parametrize('name', ['', '\x1b[2J', 'x' * 65])
def test_names_that_cannot_be_printed(name):
    with pytest.raises(ValueError, match=r'^balls: id must be 1 to 64 printable characters, got'):
        conversions.sightings_of([BallState(id=name)])
    with pytest.raises(RefusedError, match=r'^plan\.shot_id must be 1 to 64 printable characters'):
        conversions.shot_plan_of(Plan(shot_id=name, balls=balls()), 'table')
    with pytest.raises(ValueError, match=r'^shot_id must be 1 to 64 printable characters, got'):
        conversions.measured_stroke(Strike(shot_id=name), SCENE.cue_ball)

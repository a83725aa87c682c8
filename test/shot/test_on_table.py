"""Strokes on a table with other balls."""

import dataclasses
from dataclasses import replace
import math

import numpy as np
import pytest

from billiard_shot import (
    effects_of,
    predict,
    predict_batch,
    Scene,
    sensitivity_of,
    simulate,
    Status,
    Stroke,
    TableStates,
)
from billiard_shot.scene import Noise
from billiard_shot.shot.play import play_strokes, prepared_scene, task_of, USUAL_ACCURACY
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import BallState, EventKind
from billiard_shot.table.run.task import run_recorded

POOL = Scene.load('pool_table')
R = POOL.ball.radius
LIFT = math.radians(6)


def scene_of(**balls):
    return dataclasses.replace(POOL, balls=balls)


def stroke(azimuth=0.0, speed=2.0, a=0.0, b=0.0, elevation=LIFT):
    return Stroke.from_offsets(a=a, b=b, elevation=elevation, azimuth=azimuth, speed=speed)


def test_a_shot_is_a_strike_and_then_the_table():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    shot = predict(scene, stroke())
    assert shot.status == Status.OK
    run = simulate(
        scene,
        {
            'cue': BallState((-0.6, 0.1, R), shot.velocity, shot.spin),
            'one': BallState((0.2, 0.12, R)),
        },
    )
    assert shot.run.final_position['one'] == pytest.approx(run.final_position['one'], abs=0.05)
    assert shot.trajectory is shot.run.balls['cue']
    assert EventKind.BALL in {event.kind for event in shot.trajectory.events}
    assert shot.run.first_met == {'cue': 'one', 'one': 'cue'}
    effects = {effect.name: effect for effect in effects_of(shot)}
    assert effects['ball_ball'].simulated
    assert shot.message == f'first contact one; at rest after {shot.run.duration:.3g} s'


def test_a_straight_pot():
    place, pocket = np.array([0.6, 0.2]), np.array([1.27, 0.635])
    line = (pocket - place) / np.linalg.norm(pocket - place)
    cue = place - 0.4 * line
    scene = scene_of(cue=tuple(cue), one=tuple(place))
    shot = predict(scene, stroke(math.atan2(line[1], line[0]), 1.5))
    assert shot.run.pocketed['one'] == 'foot_left'
    assert shot.run.at(20.0)['one'].motion == Motion.POCKETED


def test_a_batch_gives_what_single_predictions_give():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12), two=(0.5, -0.3))
    strokes = [stroke(angle, speed) for angle in (-0.3, 0.0, 0.1) for speed in (0.4, 2.0)]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    for i, one in enumerate(strokes):
        shot = predict(scene, one)
        assert many.status[i] == shot.status
        assert many.final_position[i, 0] == pytest.approx(shot.trajectory.final_position, abs=1e-9)
        for k, name in enumerate(many.names):
            assert many.final_position[i, k] == pytest.approx(
                shot.run.final_position[name], abs=1e-9
            )


def test_off_the_table_is_an_outcome():
    scene = scene_of(cue=(0.9, 0.0))
    jump = Stroke.from_offsets(a=0, b=0, elevation=math.radians(30), azimuth=0, speed=8)
    shot = predict(scene, jump)
    assert shot.status == Status.OFF_TABLE
    assert shot.message.startswith('cue ball off the table; ')
    assert shot.run.off_table == ('cue',)


def test_a_refused_stroke_moves_nothing():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    shot = predict(scene, Stroke(normal=(1, 0, 0), velocity=(1, 0, 0)))
    assert shot.status == Status.MISS
    assert shot.run.duration == 0.0
    assert shot.events == ()
    assert shot.trajectory.final_position == pytest.approx([-0.6, 0.1, R])


def test_where_the_cue_ball_cannot_be():
    scene = scene_of(cue=(-0.6, 0.1), one=(0.2, 0.12))
    with pytest.raises(
        ValueError, match=r"position must be .* from ball 'one', which .*, got \(0\.21, 0\.12\)"
    ):
        predict(scene, stroke(), position=(0.21, 0.12))
    room = r'must be between the cushions, x from -1\.242 to 1\.242 and y from .*, got '
    for place, text in (((1.3, 0), r'\(1\.3, 0\)'), ((1.2695, 0.3), r'\(1\.2695, 0\.3\)')):
        with pytest.raises(ValueError, match=f'position {room}{text}'):
            predict(scene, stroke(), position=place)
    with pytest.raises(ValueError, match='must be beside the pockets, not over one, got'):
        predict(scene, stroke(), position=(1.27, 0.635))
    assert predict(scene, stroke(), position=(0.0, -0.638)).status == Status.OK, 'in a mouth'


def test_sensitivity_counts_the_cushions():
    scene = scene_of(cue=(0.0, 0.0))
    shot = predict(scene, stroke(0.4, 1.2))
    assert shot.run.events
    step = 1e-4
    ends = [
        predict(scene, stroke(0.4, 1.2 * (1 + s))).trajectory.final_position[:2]
        for s in (-step, step)
    ]
    slope = (ends[1] - ends[0]) / (2 * step * 1.2)
    assert sensitivity_of(shot)[:, 4] == pytest.approx(slope, rel=0.1, abs=0.02)


# --- the scene after a shot: always one in which the next stroke can be played -------------------


def test_shots_follow_each_other():
    """Every scene is accepted, and what fell is gone."""
    first = scene = Scene.load('eight_ball')
    draw = np.random.default_rng(3)
    for _ in range(40):
        azimuth, speed = draw.uniform(-3.1, 3.1), draw.uniform(1.0, 9.0)
        shot = predict(scene, Stroke.from_offsets(0.0, 0.1, 0.3, azimuth, speed), tolerance=1e-3)
        if shot.status.refused:  # the cue would go through a ball
            continue
        after = shot.after()
        gone = {*shot.run.pocketed, *shot.run.off_table} - {'cue'}
        assert set(after.balls) == set(scene.balls) - gone | {'cue'}
        for name in set(after.balls) - {'cue'}:
            assert np.allclose(after.balls[name], shot.run.final_position[name][:2])
        scene = after if len(after.balls) > 4 else first


def test_a_cue_ball_that_fell_is_in_hand():
    data = Scene.load('pool_table').to_dict()
    data['balls'] = {'cue': (1.0, 0.48), '1': (-0.635, 0.0)}
    scene = Scene.from_dict(data)
    shot = predict(scene, Stroke.from_offsets(0.0, 0.0, 0.1, np.arctan2(0.115, 0.23), 2.0))
    assert 'cue' in shot.run.pocketed
    x, y = shot.after().balls['cue']
    assert np.isclose(x, -0.25 * scene.table.length)
    assert 0.0 < abs(y) < 0.1  # beside the ball on the head spot


def test_perturbed_strokes_have_the_errors_of_the_player():
    noise, draw = Noise(), np.random.default_rng(1)
    stroke = Stroke.from_offsets(0.1, -0.1, 0.2, 1.0, 2.0)
    played = np.array([noise.perturb(stroke, draw, 0.03).offsets for _ in range(4000)])
    wanted = (noise.a / 0.03, noise.b / 0.03, np.radians(0.1), np.radians(0.125), 0.075)
    assert np.allclose(played.std(axis=0), wanted, rtol=0.05)
    assert np.allclose(played.mean(axis=0), stroke.offsets, atol=5e-3)


def test_samples_are_perturbed_strokes_as_arrays():
    noise = Noise(elevation_deg=1.0, speed=0.5)
    planned = [(0.1, -0.1, 0.2, 1.0, 2.0), (0.2, 0.1, 1.57, -3.1, 0.3)]
    for row in planned:
        stroke = Stroke.from_offsets(*row)
        alone = [noise.perturb(stroke, draw).offsets for draw in _draws()]
        many = [noise.sample(stroke, 1, draw)[0] for draw in _draws()]
        assert np.allclose(many, alone, atol=1e-9)
    both = noise.sample(planned, 50, np.random.default_rng(1))
    assert both.shape == (2, 50, 5)
    assert (both[..., 2] <= 0.5 * math.pi).all()
    assert (np.abs(both[..., 3]) <= math.pi).all()
    assert (both[..., 4] >= 1e-3).all()
    assert (both[0, :, 4] != both[1, :, 4] + 1.7).all()  # errors of their own
    with pytest.raises(ValueError, match=r'strokes must be of shape \(5,\) or \(m, 5\), got'):
        noise.sample([1.0, 2.0], 3, np.random.default_rng(1))
    with pytest.raises(ValueError, match=r'n must be .*, got 0'):
        noise.sample(planned, 0, np.random.default_rng(1))


def _draws():
    return [np.random.default_rng(seed) for seed in range(30)]


@pytest.mark.parametrize('radius', [0, -0.03, math.nan, None])
def test_perturbed_strokes_need_a_radius(radius):
    with pytest.raises(ValueError, match=r'ball_radius must be finite and above 0, got .* \(m\)'):
        Noise().perturb(Stroke.from_offsets(speed=1), np.random.default_rng(1), radius)


@pytest.mark.parametrize('speed', [0.35, 0.43, 0.437, 0.44])
def test_a_ball_may_rest_beside_the_hole_of_a_pocket(speed):
    shot = predict(
        'pool_table',
        Stroke.from_offsets(elevation_deg=10, azimuth_deg=20.136, speed=speed),
        position=(1.0, 0.55),
    )
    assert not shot.scratched
    scene = shot.after()
    back = Stroke.from_offsets(elevation_deg=40, azimuth_deg=200, speed=1.0)
    assert not predict(scene, back).status.refused


def test_errors_may_turn_a_steep_stroke_beyond_the_vertical():
    noise = Noise(elevation_deg=1.0, azimuth_deg=0.0, a=0.0, b=0.0, speed=0.0)
    stroke = Stroke.from_offsets(0.1, 0.2, elevation_deg=89.9, speed=1)
    draw = np.random.default_rng(1)
    turned = [noise.perturb(stroke, draw) for _ in range(50)]
    ways = np.array([each.velocity[0] for each in turned])
    assert (ways > 0.0).any()
    assert (ways < 0.0).any()
    for each in turned:
        assert np.linalg.norm(np.subtract(each.normal, stroke.normal)) < math.radians(5.0)
        assert np.linalg.norm(np.subtract(each.velocity, stroke.velocity)) < math.radians(5.0)


# --- strokes at many tables: each is what `predict` gives in the scene of its table --------------

TABLE = Scene.load('pool_table')
NAMES = 'cue', '1', '2'
COUNT = 24


def tables_and_strokes():
    """Balls anywhere, on every third table one of them near the cue ball, on some one missing."""
    draw = np.random.default_rng(3)
    position = np.full((COUNT, 3, 3), TABLE.ball.radius)
    position[..., 0] = draw.uniform(-1.0, 1.0, (COUNT, 3))
    position[..., 1] = (-0.3, 0.0, 0.3)
    position[::3, 1, :2] = position[::3, 0, :2] + (2.0 * TABLE.ball.radius + 0.003, 0.0)
    present = np.ones((COUNT, 3), np.bool_)
    present[1::4, 2] = False
    strokes = np.zeros((COUNT, 5))
    strokes[:, 2], strokes[:, 3] = 0.15, draw.uniform(-np.pi, np.pi, COUNT)
    strokes[::3, 3] = np.linspace(0.0, np.pi, COUNT // 3)
    strokes[:, 4] = 2.0
    return TableStates(NAMES, position, present=present), strokes


def test_strokes_at_many_tables_are_those_of_predict():
    tables, strokes = tables_and_strokes()
    batch = play_strokes(TABLE, *vectors_of(strokes), tables)
    for i, row in enumerate(strokes.tolist()):
        lie = zip(NAMES, tables.position[i, :, :2].tolist(), tables.present[i], strict=True)
        scene = replace(TABLE, balls={name: tuple(xy) for name, xy, there in lie if there})
        shot = predict(scene, Stroke.from_offsets(*row))
        assert batch.status[i] == shot.status
        assert batch.velocity[i] == pytest.approx(shot.velocity, abs=1e-9)
        assert batch.double_hit[i] == (shot.double_hit is not None)
        for k, name in enumerate(NAMES):
            if tables.present[i, k]:
                place = shot.final_position[name]
                assert batch.final_position[i, k] == pytest.approx(place, abs=1e-6)
    assert {Status.OK, Status.CUE_THROUGH_BALL} <= set(batch.status.tolist())
    assert batch.double_hit.any()
    assert not batch.double_hit.all()


def test_one_table_serves_all_strokes():
    tables, strokes = tables_and_strokes()
    one = play_strokes(TABLE, *vectors_of(strokes), tables.take(slice(0, 1)))
    many = play_strokes(TABLE, *vectors_of(strokes), tables.take(np.zeros(COUNT, int)))
    assert (one.final_position == many.final_position).all()
    assert (one.status == many.status).all()


def test_a_table_without_a_cue_ball_is_missed():
    tables, strokes = tables_and_strokes()
    tables.present[2, 0] = False
    batch = play_strokes(TABLE, *vectors_of(strokes), tables)
    assert batch.status[2] == Status.MISS
    assert (batch.final_position[2, 1] == tables.position[2, 1]).all()


def test_the_record_of_a_stroke_that_is_played_again_is_that_of_the_second_time():
    strokes = np.tile((0.0, 0.0, 0.15, 0.0, 3.0), (40, 1))
    strokes[:, 3] = np.random.default_rng(5).uniform(-np.pi, np.pi, len(strokes))
    task = task_of(prepared_scene(TABLE), *vectors_of(strokes), None, USUAL_ACCURACY)
    played = run_recorded(task)
    assert (played.tables['jaws_met'] > 0).sum() >= 5
    motions = np.split(played.segments, played.tables['segments'][:-1])
    for motion, cue, balls in zip(motions, played.cues, played.balls, strict=True):
        of_cue_ball = motion[motion['ball'] == 0]
        assert (of_cue_ball['velocity'][0] == cue['velocity']).all()
        assert (of_cue_ball['position'][-1] == balls['position'][0]).all()


def test_the_cue_ball_must_come_first():
    normals, velocities = vectors_of(np.zeros((1, 5)))
    tables = TableStates(('1', 'cue'), [[(0.5, 0.0, TABLE.ball.radius), (0.0, 0.0, 0.0)]])
    with pytest.raises(ValueError, match="tables must have 'cue' first, got 1, cue"):
        play_strokes(TABLE, normals, velocities, tables)

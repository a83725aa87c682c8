import dataclasses
from functools import cached_property
import math

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import (
    effects_of,
    EventKind,
    predict,
    predict_batch,
    Scene,
    sensitivity_of,
    Status,
    Stroke,
)
from billiard_shot.table.model.motion import Motion

PAPER, POOL = Scene.load('paper'), Scene.load('pool')
FLIP = np.array([1, -1, 1])


def changed(scene, **sections):
    data = scene.to_dict()
    for name, change in sections.items():
        data[name] = {**data[name], **change} if isinstance(change, dict) else change
    return Scene.from_dict(data)


# paper-notes: Table 1, reference values of the model as written
@pytest.mark.parametrize(
    ('normal', 'velocity', 'v', 'w', 'states', 'accuracy'),
    [
        (
            (-1, -2, 1),
            (0, 0, -2),
            (0.4291079283, 0.8582158565, 0.2830706838),
            (31.63351522, -15.81675761, 0),
            'S1 S2 S1 S3',
            1e-9,
        ),
        (
            (-1, -1, 0),
            (0.8, 0, 0),
            (0.6335672927, 0.4653476309, 0),
            (0, 0, 10.39766290),
            'S3',
            1e-9,
        ),
        (
            (-1, 0, 1),
            (1, 0, -1),
            (1.2475933472, 0, 0.0196340348),
            (0, -6.67687862, 0),
            'S1 S2 S1 S3 S1 S2',
            1e-9,
        ),
        (
            (-2, -1, 12),
            (4, 0, -16),
            (1.3024730695, 0.7322053160, 0.4970895636),
            (10.40182097, -35.75618541, -1.20248107),
            'S1 S2 S1 S3 S1 S2 S1 S3 S1 S2',
            1e-7,
        ),
    ],
)
def test_shots_of_the_paper(normal, velocity, v, w, states, accuracy):
    shot = predict(PAPER, Stroke(normal, velocity), tolerance=1e-10)
    assert shot.velocity == pytest.approx(v, abs=accuracy)
    assert shot.spin == pytest.approx(w, abs=1e2 * accuracy)
    names = {(0, 1): 'S1', (1,): 'S2', (0,): 'S3'}
    assert ' '.join(names[phase.active] for phase in shot.impact.phases) == states
    last = shot.impact.phases[-1].impulses
    assert (last[1] - last[0]) / PAPER.ball.mass == pytest.approx(shot.velocity, abs=1e-12)


def test_energy_is_accounted_for():
    stroke = Stroke((-2, -1, 12), (4, 0, -16))
    shot = predict(PAPER, stroke, tolerance=1e-10)
    ball = PAPER.ball
    left = (
        ball.mass * shot.velocity @ shot.velocity
        + ball.inertia * shot.spin @ shot.spin
        + PAPER.cue.mass * shot.cue_speed**2
    )
    lost = 0.5 * (PAPER.cue.mass * stroke.speed**2 - left)
    assert shot.impact.dissipated.shape == (2, 2)
    assert (shot.impact.dissipated >= 0).all()
    assert shot.impact.dissipated.sum() == pytest.approx(lost, rel=1e-9)


@pytest.mark.parametrize('a', [0.1, 0.2, 0.3, 0.4, 0.5])
def test_squirt_of_slow_strokes_is_alciatores(a):
    """In his formula the normal stays; the faster a stroke, the more it turns."""

    def angle(scene):
        shot = predict(scene, Stroke.from_offsets(a, 0, 0, 0, 0.05), tolerance=1e-7)
        return math.degrees(math.atan2(shot.velocity[1], shot.velocity[0]))

    def his(ratio):
        s = math.sqrt(1 - a * a)
        return math.degrees(math.atan(2.5 * a * s / (1 + ratio + 2.5 * s * s)))

    # his tip and ball part without rebound
    soft = changed(
        POOL,
        contacts={
            **POOL.to_dict()['contacts'],
            'cue_ball': {'restitution': 0, 'friction': 0.6, 'duration': 0.0013},
        },
        cue={'end_mass': 0.17 / 30},
        effects={'shaft': 'off'},
    )
    assert angle(soft) == pytest.approx(his(30), rel=1e-3)
    assert angle(POOL) == pytest.approx(his(30), rel=0.08)


@settings(deadline=None, max_examples=30)
@given(
    st.floats(-0.6, 0.6),
    st.floats(-0.3, 0.6),
    st.floats(0, 1.5),
    st.floats(-3, 3),
    st.sampled_from([PAPER, POOL]),
)
def test_mirrored_and_turned_strokes(a, b, elevation, azimuth, scene):
    one = predict(scene, Stroke.from_offsets(a, b, elevation, 0, 2), tolerance=1e-8)
    mirrored = predict(scene, Stroke.from_offsets(-a, b, elevation, 0, 2), tolerance=1e-8)
    turned = predict(scene, Stroke.from_offsets(a, b, elevation, azimuth, 2), tolerance=1e-8)
    assert one.status == mirrored.status == turned.status
    size = 1e-8 * (1 + np.abs(one.velocity).max())
    assert one.velocity * FLIP == pytest.approx(mirrored.velocity, abs=size)
    assert -one.spin * FLIP == pytest.approx(mirrored.spin, abs=1e3 * size)
    turn = np.array(
        [
            [math.cos(azimuth), -math.sin(azimuth), 0],
            [math.sin(azimuth), math.cos(azimuth), 0],
            [0, 0, 1],
        ]
    )
    assert turn @ one.velocity == pytest.approx(turned.velocity, abs=size)
    assert turn @ one.trajectory.final_position == pytest.approx(
        turned.trajectory.final_position, abs=1e-7
    )


@pytest.mark.parametrize('b', [1e-11, 1e-9])
def test_rounding_of_the_azimuth_does_not_turn_a_slip_that_hardly_is_one(b):
    """The tip's tangent once leaned into the normal where the two were nearly parallel."""
    heights = [
        predict(PAPER, Stroke.from_offsets(0, b, 0, azimuth, 2), 1e-8).velocity[2]
        for azimuth in (0, 1, 3)
    ]
    assert heights == pytest.approx([1.13419 * b] * 3, rel=1e-4)


@pytest.mark.parametrize('law', ['bistiffness', 'energetic', 'poisson'])
def test_a_batch_is_row_by_row_what_predict_gives(law):
    scene = dataclasses.replace(POOL, law=law)
    random = np.random.default_rng(5)
    normals = random.normal(size=(60, 3))
    velocities = random.normal(size=(60, 3)) * (1, 1, 0.5) - (0, 0, 0.5)
    batch = predict_batch(scene, normals, velocities, tolerance=1e-6)
    assert len(set(batch.status.tolist())) > 2
    for i in range(60):
        shot = predict(scene, Stroke(normals[i], velocities[i]), tolerance=1e-6)
        assert batch.status[i] == shot.status
        assert (batch.velocity[i] == shot.velocity).all()
        assert (batch.spin[i] == shot.spin).all()
        assert (batch.final_position[i, 0] == shot.trajectory.final_position).all()
        assert (batch.dissipated[i] == shot.impact.dissipated).all()
        assert batch.cue_speed[i] == shot.cue_speed
        assert batch.evaluations[i] == shot.evaluations


def test_a_batch_of_offsets_gives_what_single_strokes_give():
    draw = np.random.default_rng(8)
    offsets = np.column_stack(
        [
            draw.uniform(-0.6, 0.6, (60, 2)),
            draw.uniform(-0.1, 1.5, 60),
            draw.uniform(-math.pi, math.pi, 60),
            draw.uniform(0.2, 4.0, 60),
        ]
    )
    offsets[:4, :2] = (0.8, 0.7), (0.6, 0.8), (0.0, 0.0), (-1.5, 0.2)
    scene = Scene.load('pool_table')
    batch = predict_batch(scene, offsets=offsets)
    for i, row in enumerate(offsets.tolist()):
        shot = predict(scene, Stroke.from_offsets(*row))
        assert batch.status[i] == shot.status
        assert np.allclose(batch.velocity[i], shot.velocity, atol=1e-9)
        assert np.allclose(batch.spin[i], shot.spin, atol=1e-7)
    assert {Status.OK, Status.MISS} < set(batch.status.tolist())


def test_offsets_that_no_stroke_can_have_are_refused():
    good = (0.0, 0.1, 0.1, 0.0, 2.0)
    bad = [(*good[:i], value, *good[i + 1 :]) for i, value in ((2, 2.0), (3, 7.0), (4, 0.0))]
    bad += [(*good[:i], math.nan, *good[i + 1 :]) for i in range(5)]
    batch = predict_batch(POOL, offsets=[good, *bad])
    assert batch.status.tolist() == [Status.OK, *[Status.INVALID_STROKE] * len(bad)]
    with pytest.raises(ValueError, match=r'offsets must be .*, got \(5,\)'):
        predict_batch(POOL, offsets=good)
    for named in ({}, {'offsets': [good], 'normals': [(-1, 0, 0)]}, {'normals': [(-1, 0, 0)]}):
        with pytest.raises(ValueError, match='offsets must be given, or normals and velocities'):
            predict_batch(POOL, **named)


def test_bad_rows_of_a_batch():
    normals = [(-1, 0, 0), (math.nan, 0, 0), (0, 0, 0), *[(-1, 0, 0)] * 4, (1, 0, 0)]
    speeds = 1, 1, 1, 0, math.inf, 1e13, 1e-13, 1
    velocities = [(speed, 0, 0) for speed in speeds]
    batch = predict_batch(POOL, normals, velocities)
    assert batch.status.tolist() == [Status.OK, *[Status.INVALID_STROKE] * 6, Status.MISS]
    assert batch.velocity[0, 0] > 1
    columns = {
        name: getattr(batch, name)
        for kind in type(batch).mro()
        for name, each in vars(kind).items()
        if isinstance(each, cached_property) and name not in ('met_time', 'last_cushion')
    }
    assert {'velocity', 'spin', 'pocket', 'error_estimate', 'duration'} <= columns.keys()
    for name, values in columns.items():
        assert not isinstance(values, np.ndarray) or np.isfinite(values).all(), name
    empty = predict_batch(POOL, np.empty((0, 3)), np.empty((0, 3)))
    assert empty.final_position.shape == (0, 1, 3)
    with pytest.raises(ValueError, match=r'normals must be .*, got \(2,\)'):
        predict_batch(POOL, [1, 2], [(1, 0, 0)])
    with pytest.raises(ValueError, match='velocities must have as many rows as normals, 1, got 2'):
        predict_batch(POOL, [(1, 0, 0)], [(1, 0, 0)] * 2)


@pytest.mark.parametrize(
    ('stroke', 'status', 'field'),
    [
        (Stroke((1, 0, 0), (1, 0, 0)), Status.MISS, 'normal'),
        (Stroke((0, 1, 0), (1, 0, 0)), Status.MISS, 'normal'),
        (Stroke.from_offsets(0.8, 0.8, 0, 0, 1), Status.MISS, 'a, b'),
        (Stroke.from_offsets(1, 0, 0, 0, 1), Status.MISS, 'a, b'),
        (
            Stroke.from_pose((-1, 0.1, 0.03), (0, 0, 0, 1), 1, (0, 0, 0.03)),
            Status.MISS,
            'position, quaternion',
        ),
        (Stroke.from_pose((1, 0, 0.03), (0, 0, 0, 1), 1, (0, 0, 0.03)), Status.MISS, 'position'),
        (Stroke.from_offsets(0, 0, -0.01, 0, 1), Status.NEGATIVE_ELEVATION, 'elevation'),
        (Stroke.from_offsets(0, -0.9, 0, 0, 1), Status.CUE_THROUGH_CLOTH, 'normal'),
    ],
)
def test_refused_strokes_leave_the_ball_alone(stroke, status, field):
    shot = predict(POOL, stroke, position=(0.2, -0.1))
    assert shot.status == status
    assert shot.status.refused
    assert shot.message.startswith(f'{field} must ')
    assert 'must ' in shot.message
    assert not shot.velocity.any()
    assert not shot.spin.any()
    assert shot.impact.phases == ()
    assert shot.trajectory.final_position == pytest.approx((0.2, -0.1, POOL.ball.radius))
    assert shot.trajectory.duration == 0
    assert shot.trajectory.at(1.0).motion == Motion.REST
    assert not any(effect.simulated for effect in effects_of(shot))
    assert not sensitivity_of(shot).any()
    assert shot.error_estimate == 0


def test_a_level_stroke_may_point_up_by_rounding():
    assert predict(POOL, Stroke((-1, 0, 0), (1, 0, 1e-17))).status == Status.OK


def test_miscue():
    shot = predict(POOL, Stroke.from_offsets(0.8, 0, 0, 0, 2))
    assert shot.miscue
    assert shot.status == Status.OK
    assert shot.trajectory.duration > 0
    assert not predict(POOL, Stroke.from_offsets(0.3, 0.2, 0.1, 0, 2)).miscue
    assert not predict(POOL, Stroke.from_offsets(0.8, 0, -0.1, 0, 2)).miscue  # refused


@pytest.mark.parametrize('speed', [0.05, 0.5, 2, 10])
@pytest.mark.parametrize('tolerance', [1e-3, 1e-4, 1e-6, 1e-8])
def test_the_error_estimate_holds(speed, tolerance):
    for offsets in ((0.2, 0.1, 0.05, 0), (0.1, 0.4, 1.2, 1), (-0.3, -0.3, 0.3, 2)):
        stroke = Stroke.from_offsets(*offsets, speed)
        rough, exact = predict(POOL, stroke, tolerance), predict(POOL, stroke, 1e-12)
        assert rough.error_estimate <= tolerance
        events = rough.events + exact.events
        hits = [event.time for event in events if event.kind == EventKind.CUE]
        until = min([exact.trajectory.duration * 1.01, *hits])  # it holds until a later hit
        t = np.linspace(0, until, 1000, endpoint=False)
        gap = np.linalg.norm(
            rough.trajectory.at(t).position - exact.trajectory.at(t).position, axis=1
        ).max()
        assert gap <= rough.error_estimate + exact.error_estimate


def test_a_tolerance_out_of_reach():
    shot = predict(POOL, Stroke.from_offsets(0.2, 0.1, 0.3, 0, 5), tolerance=1e-15)
    assert shot.status == Status.TOLERANCE_NOT_REACHED
    assert 1e-15 < shot.error_estimate < 1e-9


@pytest.mark.parametrize('stroke', [None, 5, (0, 0, 0, 0, 1)])
def test_what_is_no_stroke(stroke):
    with pytest.raises(ValueError, match='stroke must be a Stroke, got'):
        predict(POOL, stroke)


@pytest.mark.parametrize('tolerance', [0, -1, math.nan, math.inf, 10**400, None, '1'])
def test_wrong_tolerance(tolerance):
    with pytest.raises(ValueError, match=r'tolerance must be finite and above 0'):
        predict(POOL, Stroke((-1, 0, 0), (1, 0, 0)), tolerance=tolerance)


@pytest.mark.parametrize(
    'position', [(1,), (0, 0, 1), (math.nan, 0), (0, 10**400), (0, 1e13), 'ab']
)
def test_wrong_position(position):
    with pytest.raises(ValueError, match=r'position must be finite .*, got'):
        predict(POOL, Stroke((-1, 0, 0), (1, 0, 0)), position=position)


def test_the_ball_starts_where_it_lies():
    stroke = Stroke.from_offsets(0.2, 0.1, 0.3, 0.5, 2)
    origin = predict(POOL, stroke).trajectory.final_position
    moved = predict(POOL, stroke, position=(1, 2, 0)).trajectory
    assert moved.at(0).position.tolist() == [1, 2, POOL.ball.radius]
    assert moved.final_position - origin == pytest.approx([1, 2, 0])
    placed = predict(changed(POOL, balls={'cue': [1, 2]}), stroke).trajectory
    assert (placed.final_position == moved.final_position).all()


def test_flight_can_be_turned_off():
    stroke = Stroke((-2, -1, 12), (4, 0, -16))
    off = predict(changed(PAPER, effects={'flight': 'off'}), stroke)
    on = predict(PAPER, stroke)
    assert (off.velocity == on.velocity).all()
    assert (off.trajectory.rows['position'][:, 2] == PAPER.ball.radius).all()
    flight = {effect.name: effect for effect in effects_of(off)}['flight']
    assert not flight.simulated
    assert 'the scene turns it off' in flight.reason


def test_frictionless_cloth_never_stops_the_ball():
    cloth = {'sliding_friction': 0, 'rolling_resistance': 0, 'spin_deceleration': 0}
    shot = predict(changed(POOL, cloth=cloth), Stroke.from_offsets(0.2, 0.1, 0.1, 0, 2))
    assert shot.status == Status.NEVER_RESTS
    assert 'endless' in shot.message
    assert 'rests at' not in str(shot)
    assert 'moves on from' in str(shot)
    with pytest.raises(ValueError, match=r"ball 'cue' still moves \(status NEVER_RESTS\)"):
        shot.after()
    assert np.isfinite(shot.trajectory.final_position).all()


def test_sensitivity_is_a_derivative():
    stroke = Stroke.from_offsets(0.2, 0.1, 0.3, 0.5, 2)
    shot = predict(POOL, stroke, tolerance=1e-9)
    step = 1e-5 * np.array([1, -2, 0.5, 1, -1])
    near = Stroke.from_offsets(*(np.array(stroke.offsets) + step))
    change = (
        predict(POOL, near, tolerance=1e-9).trajectory.final_position
        - shot.trajectory.final_position
    )
    assert sensitivity_of(shot) @ step == pytest.approx(change[:2], rel=1e-2)


def test_results_cannot_be_changed():
    shot = predict(POOL, Stroke((-1, 0, 0), (1, 0, 0)))
    with pytest.raises(ValueError, match='read-only'):
        shot.velocity[0] = 1
    with pytest.raises(ValueError, match='read-only'):
        shot.trajectory.final_position[0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        shot.tolerance = 1


def test_numbers_of_numpy_are_as_good_as_floats():
    stroke = Stroke.from_offsets(0, 0.1, elevation_deg=5, azimuth_deg=10, speed=2)
    rough, exact = (predict('pool_table', stroke, kind(1e-4)) for kind in (np.float32, float))
    assert rough.tolerance == float(np.float32(1e-4))
    assert type(rough.tolerance) is float
    np.testing.assert_allclose(rough.final_position['cue'], exact.final_position['cue'], atol=2e-4)


@pytest.mark.parametrize('tolerance', ['1e-4', None, [1e-4, 1], 10**400, float('nan'), 0.0])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(ValueError, match=r'tolerance must be finite and above 0'):
        predict('pool', Stroke.from_offsets(speed=1), tolerance)

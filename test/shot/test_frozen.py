"""Strikes on a ball that touches another one or a cushion, or nearly does."""

from dataclasses import replace
import math

import numpy as np
import pytest
from setups import SLOW_CLOTH

from billiard_shot import EventKind, machine_code, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.scene import Effects
from billiard_shot.table.contacts import cluster

POOL = Scene.load('pool_table')
R = POOL.ball.radius
REACH = math.sqrt(R**2 - (POOL.table.cushion.height * 2 * R - R) ** 2)
LEVEL = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0, speed=2)


def scene_of(**balls):
    return replace(POOL, balls=balls)


def energy(scene, shot):
    """Of cue and balls after the strike [J]."""
    first = shot.run.at(0.0)
    balls = sum(
        0.5 * scene.ball.mass * (s.velocity**2).sum()
        + 0.5 * scene.ball.inertia * (s.spin**2).sum()
        for s in first.values()
    )
    return balls + 0.5 * scene.cue.mass * shot.cue_speed**2


def test_two_frozen_balls_leave_together():
    scene = scene_of(cue=(0.0, 0.0), one=(2 * R, 0.0))
    shot = predict(scene, LEVEL)
    alone = predict(scene_of(cue=(0.0, 0.0)), LEVEL)
    soon = {name: ball.velocity[0] for name, ball in shot.run.at(1e-3).items()}
    assert soon['one'] > 1.0
    assert 0 < soon['cue'] < soon['one']  # they met for the last time after the tip had parted
    assert shot.velocity[0] < alone.velocity[0]
    assert shot.cue_speed < alone.cue_speed  # it moves two balls
    assert len(shot.impact.dissipated) == 3
    assert energy(scene, shot) < 0.5 * scene.cue.mass * 4
    # The cloth takes something at once from a ball that friction presses down.
    smooth = replace(POOL.contacts.ball_ball, friction_fast=0.0, friction_slow=0.0)
    scene = replace(
        scene,
        contacts=replace(POOL.contacts, ball_ball=smooth),
        effects=Effects(shaft='off'),  # which takes energy that is not listed
    )
    shot = predict(scene, LEVEL)
    assert shot.impact.dissipated.sum() == pytest.approx(
        0.5 * scene.cue.mass * 4 - energy(scene, shot), rel=0.05
    )


def test_a_steep_strike_squeezes_the_ball_from_one_ball_to_the_next():
    places = {'cue': (0.0, 0.0), 'one': (2.0 * R + 2e-4, 0.0), 'two': (0.0, 2.0 * R + 2e-3)}
    scene = Scene.from_dict({'like': 'pool_table', 'contacts': SLOW_CLOTH, 'balls': places})
    stroke = Stroke.from_offsets(
        a=-0.0953, b=-0.202, elevation=1.2724, azimuth=0.1988, speed=4.3633
    )
    shot = predict(scene, stroke)
    assert shot.status == Status.OK
    met = [event.balls for event in shot.events if event.kind == EventKind.BALL]
    assert met[:2] == [('cue', 'one'), ('cue', 'two')]


def test_a_ball_beside_does_not_matter():
    behind = scene_of(cue=(0.0, 0.0), one=(0.0, 1.9 * R * 2))
    free = scene_of(cue=(0.0, 0.0))
    assert predict(behind, LEVEL).velocity == pytest.approx(predict(free, LEVEL).velocity)


def velocities_behind_a_gap(gap, angle, stroke=LEVEL):
    """Velocities of both balls soon after a strike with a distance between them [m]."""
    away = 2 * R + gap
    scene = scene_of(cue=(0.0, 0.0), one=(away * math.cos(angle), away * math.sin(angle)))
    shot = predict(scene, stroke)
    return np.concatenate([ball.velocity for ball in shot.run.at(0.012).values()])


@pytest.mark.parametrize('angle', [0.0, 0.5, 1.0])
def test_a_gap_changes_a_strike_continuously(angle):
    """No step above 2 % of the cue's speed, from touch to a tenth of a millimetre."""
    assert largest_step([0.0, *np.geomspace(1e-9, 1e-4, 12)], angle, below=0.04) < 0.04


@pytest.mark.parametrize('angle', [0.0, 0.3])
def test_a_gap_of_millimetres_makes_small_steps(angle):
    """Where a hit of the tip or a bounce more begins, steps are below 12 % of the cue's speed."""
    assert largest_step(np.linspace(1e-4, 8e-3, 40), angle, below=0.04) < 0.24


def largest_step(gaps, angle, below):
    """Find the largest step [m/s] between gaps a nanometre apart; steps `below` are let be."""
    largest, found = 0.0, [velocities_behind_a_gap(gap, angle) for gap in gaps]
    for low, high, one, other in zip(gaps, gaps[1:], found, found[1:], strict=False):
        while np.abs(other - one).max() > below and high - low > 1e-9:
            middle = 0.5 * (low + high)
            between = velocities_behind_a_gap(middle, angle)
            if np.abs(between - one).max() > np.abs(other - between).max():
                high, other = middle, between
            else:
                low, one = middle, between
        largest = max(largest, np.abs(other - one).max())
    return largest


@pytest.mark.parametrize('gap', [0.0, 1e-6, 1e-3, 1.5e-3])
def test_balls_begin_where_the_strike_leaves_them(gap):
    shot = predict(scene_of(cue=(0.0, 0.0), one=(2 * R + gap, 0.0)), LEVEL)
    cue, one = (state.position for state in shot.run.at(0.0).values())
    assert (shot.position == [0.0, 0.0, R]).all()
    assert gap < cue[0] < gap + 3e-3, 'it has gone at least as far as to the other ball'
    assert one[0] > 2 * R + gap
    assert np.linalg.norm(one - cue) > 2 * R - 1e-9, 'they do not overlap'


def test_without_double_hits_the_tip_hits_once():
    scene = scene_of(cue=(1.27 - REACH - 1e-3, 0.1))
    assert predict(scene, LEVEL).double_hit == 0.0, 'the cushion throws the ball back at it'
    scene = replace(scene, effects=Effects(double_hit='off'))
    assert predict(scene, LEVEL)._cue['hits'] == 1


def test_a_ball_behind_a_millimetre_is_reached_during_the_strike():
    for gap, reached in ((1e-3, True), (5e-3, False)):
        shot = predict(scene_of(cue=(0.0, 0.0), one=(2 * R + gap, 0.0)), LEVEL)
        meeting = next(event for event in shot.events if event.kind == EventKind.BALL)
        assert meeting.balls == ('cue', 'one')
        assert (meeting.time == 0.0) == reached
        assert (len(shot.impact.dissipated) == 3) == reached
        assert shot.first_contact == 'one'


def test_the_normal_is_the_one_at_which_the_balls_meet():
    """The struck ball goes off at the angle at which it meets one that is 2 mm away."""
    scene = scene_of(cue=(0.0, 0.0), one=((2 * R + 2e-3) * 0.8, (2 * R + 2e-3) * 0.6))
    stroke = Stroke.from_offsets(a=0, b=0, elevation=math.radians(5), azimuth=0, speed=5)
    reached = predict(scene, stroke)
    assert reached.events[0].time == 0.0
    alone = predict(replace(scene, effects=Effects(cluster='off')), stroke)
    assert alone.events[0].time > 0.0
    one, other = (shot.run.at(0.004)['one'].velocity for shot in (reached, alone))
    assert math.atan2(one[1], one[0]) == pytest.approx(math.atan2(other[1], other[0]), abs=0.02)


def test_what_nothing_reaches_changes_nothing():
    for others in ({'one': (0.0, 2 * R + 1e-4)}, {'one': (-0.01, 2 * R + 4e-3)}):
        near, alone = predict(scene_of(cue=(0.0, 0.0), **others), LEVEL), predict(POOL, LEVEL)
        assert near.velocity == pytest.approx(alone.velocity, rel=1e-12, abs=1e-13)
        assert near.spin == pytest.approx(alone.spin, rel=1e-12, abs=1e-11)
        assert len(near.impact.dissipated) == 2


def test_along_a_cushion_and_away_from_it():
    y = 0.635 - REACH
    scene = scene_of(cue=(-0.3, y))
    along = predict(scene, LEVEL)
    assert along.status == Status.OK
    assert abs(along.trajectory.at(0.0).position[1] - y) < 1e-6
    assert along.velocity[1] <= 1e-6
    into = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0.5, speed=1)
    shot = predict(scene, into)
    assert shot.velocity[1] < 0  # the cushion throws it back
    assert len(shot.impact.dissipated) == 3
    assert energy(scene, shot) < 0.5 * scene.cue.mass


def test_a_batch_gives_what_single_predictions_give():
    scene = scene_of(cue=(0.0, 0.0), one=(2 * R * math.cos(0.4), 2 * R * math.sin(0.4)))
    strokes = [
        Stroke.from_offsets(a=a, b=0.1, elevation=0.1, azimuth=0.1, speed=1.5)
        for a in (-0.2, 0.0, 0.2)
    ]
    many = predict_batch(scene, [s.normal for s in strokes], [s.velocity for s in strokes])
    for i, stroke in enumerate(strokes):
        shot = predict(scene, stroke)
        assert (many.velocity[i] == shot.velocity).all()
        assert (many.final_position[i, 0] == shot.trajectory.final_position).all()
        assert many.first_met[i].tolist() == [1, 0]
        assert np.isfinite(many.final_position).all()


@pytest.mark.parametrize(
    ('angle', 'gap', 'speed'), [(70, 3.67e-3, 9), (70, 5.4e-3, 9), (80, 1e-3, 5), (85, 3e-4, 2)]
)
def test_a_ball_that_is_passed_is_not_met(angle, gap, speed):
    """Before, the cue ball pushed it: a contact that keeps its normal is a wall."""
    away = 2 * R + gap
    at = (away * math.cos(math.radians(angle)), away * math.sin(math.radians(angle)))
    stroke = Stroke.from_offsets(a=0, b=0, elevation=math.radians(5), azimuth=0, speed=speed)
    shot = predict(scene_of(cue=(0.0, 0.0), one=at), stroke)
    alone = predict(scene_of(cue=(0.0, 0.0)), stroke)
    assert shot.velocity.tolist() == alone.velocity.tolist()
    assert shot.run.at(2e-3)['one'].velocity.tolist() == [0, 0, 0]


@pytest.mark.parametrize('angle', [0.0, 0.5])
def test_a_gap_behind_a_frozen_ball_makes_no_large_step(angle):
    """Before, a step of 27 to 42 % at 1.25 mm; closings of balls that are put back leave 6 %."""
    stroke = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0, speed=5)

    def velocities(gap):
        x, y = (2 * R + gap) * math.cos(angle), (2 * R + gap) * math.sin(angle)
        scene = scene_of(cue=(0.0, 0.0), one=(2 * R, 0.0), two=(2 * R + x, y))
        return np.concatenate(
            [ball.position for ball in predict(scene, stroke).run.at(0.02).values()]
        )

    found = np.array([velocities(gap) for gap in np.linspace(1e-3, 1.5e-3, 26)])
    assert np.abs(np.diff(found, axis=0)).max() < 0.06 * 6.5 * 0.02


def test_the_cue_does_not_go_through_a_ball_that_presses_a_cushion():
    near = (0.5 * POOL.table.length - REACH - 2e-3, 0.2)
    stroke = Stroke.from_offsets(a=0, b=0.1, elevation=math.radians(5), azimuth=0, speed=1)
    shot = predict(scene_of(cue=near), stroke)
    assert shot.cue_speed > 0.5  # the cue follows
    assert [event.kind for event in shot.events[:2]] == [EventKind.CUSHION, EventKind.CUE]
    assert shot.double_hit < shot.events[0].time + POOL.table.cushion.duration


def test_a_ball_that_friction_presses_down_bounces():
    rough = replace(POOL.contacts.ball_ball, friction_fast=0.1, friction_slow=0.0)
    scene = replace(
        scene_of(cue=(0.0, 0.0), one=(2 * R + 1e-4, 0.0)),
        contacts=replace(POOL.contacts, ball_ball=rough),
    )
    stroke = Stroke.from_offsets(a=0, b=0.5, elevation=math.radians(5), azimuth=0, speed=3)
    shot = predict(scene, stroke)
    first = shot.run.balls['one'].at(0.0)
    assert first.velocity[2] > 0


@pytest.mark.parametrize('gap', [0.0, 1e-4])
@pytest.mark.parametrize('azimuth', [-70.0, -75.0])
def test_a_ball_between_a_cushion_and_another_ball_is_set_apart_from_both(azimuth, gap):
    """Separated from the cushion last, it was pressed into the other ball again."""
    x, side = 1.2424, (2 * R + gap) * math.sqrt(0.5)
    scene = scene_of(cue=(x, 0.1), one=(x - side, 0.1 - side))
    for speed in (1.0, 2.0, 4.0):
        stroke = Stroke.from_offsets(0, 0, elevation_deg=10, azimuth_deg=azimuth, speed=speed)
        shot = predict(scene, stroke)
        batch = predict_batch(scene, [stroke.normal], [stroke.velocity])
        assert shot.status is Status.OK
        assert batch.status[0] == Status.OK
        np.testing.assert_array_equal(batch.final_position[0, 0], shot.trajectory.final_position)


def test_balls_that_cannot_be_set_apart_begin_where_they_were(monkeypatch):
    monkeypatch.setattr(
        machine_code, 'is_loaded', lambda: False
    )  # compiled code keeps the constant
    monkeypatch.setattr(cluster, 'MAX_SWEEPS', 1)
    x, side = 1.2424, 2 * R * math.sqrt(0.5)
    scene = scene_of(cue=(x, 0.1), one=(x - side, 0.1 - side))
    scene = replace(scene, effects=Effects(shaft='off'))  # which changes where they end
    stroke = Stroke.from_offsets(0, 0, elevation_deg=10, azimuth_deg=-70, speed=2)
    shot = predict(scene, stroke)
    assert shot.status is Status.BUDGET_EXCEEDED
    first = shot.run.at(0.0)
    assert {name: tuple(state.position[:2]) for name, state in first.items()} == scene.balls


@pytest.mark.parametrize(
    'given',
    [
        {'a': 0.0, 'b': 0.0, 'elevation_deg': 12, 'azimuth_deg': 10, 'speed': 5},
        {'a': 0.0, 'b': 0.0, 'elevation_deg': 36, 'azimuth_deg': 20, 'speed': 3},
        {'a': -0.0974, 'b': 0.0203, 'elevation_deg': 20.84, 'azimuth_deg': -6.228, 'speed': 3.12},
    ],
)
def test_a_strike_into_a_cushion_ends(given):
    """The cushion moved the ball into the tip, which then was pressed and left it, without end."""
    scene = scene_of(cue=(1.2424862662941305, 0.1))
    assert predict(scene, Stroke.from_offsets(**given)).status is Status.OK


@pytest.mark.parametrize('seed', [226, *range(30)])
def test_only_the_cue_gives_balls_energy(seed):
    """A cushion pulled a ball back that left it just when a hit of the cue had ended (226)."""
    rng = np.random.default_rng(seed)
    x = 0.5 * POOL.table.length - REACH - 10 ** rng.uniform(-6, -1.5)
    a, b = rng.uniform(-0.55, 0.55, 2)
    elevation, azimuth = rng.uniform(0, 50), rng.uniform(-180, 180)
    stroke = Stroke.from_offsets(
        a, b, elevation_deg=elevation, azimuth_deg=azimuth, speed=10 ** rng.uniform(-1, 0.8)
    )
    shot = predict(scene_of(cue=(x, 0.1)), stroke)
    for event in shot.run.events:
        gain = event.energy_after - event.energy_before
        assert event.kind is EventKind.CUE or gain <= 1e-9 * event.energy_before

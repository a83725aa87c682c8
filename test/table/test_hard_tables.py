"""Hard cases with other balls: what is nearly in touch, only just met, or met all at once."""

import dataclasses
import math

import numpy as np
import pytest
from tables import after, ENDLESS, play, POOL, R, rolling, scene_with, SMOOTH, state, state_after

from billiard_shot import machine_code, predict, predict_batch, Scene, Stroke
from billiard_shot.records import OBJECTS
from billiard_shot.scene import Effects
from billiard_shot.status import Status
from billiard_shot.table.contacts.balls import find_next_meeting, note_collision
from billiard_shot.table.model.motion import (
    Motion,
    NOTHING,
    room_for_simulation,
    Simulation,
    start_ball,
    TableOutcome,
)
from billiard_shot.table.run import event_loop
from billiard_shot.table.run.event_loop import next_event
from billiard_shot.table.run.results import EventKind
from billiard_shot.table.run.simulate import simulate_batch

IDEAL = scene_with(ENDLESS, ball_ball=SMOOTH)
MEETINGS = EventKind.BALL, EventKind.CLUSTER


def check(run):
    """Nothing odd: a status, finite numbers, no energy gained, no overlap at any event."""
    assert run.status in (Status.OK, Status.OFF_TABLE)
    for event in run.events:
        assert event.energy_after <= event.energy_before * (1 + 1e-12) + 1e-18
        states = [ball.at(event.time) for ball in run.balls.values()]
        on_table = [each.position for each in states if each.motion < Motion.POCKETED]
        places = np.array(on_table).reshape(-1, 3)
        apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
        assert np.isfinite(places).all()
        assert (apart > 2 * R - 1e-9).all()


def cradle(scene, count, gap):
    """Balls in a row, the first one hit full by a rolling ball; velocities once they have met."""
    row = {str(i): state((2 * R + gap) * i, 0) for i in range(count - 1)}
    run = play(scene, cue=rolling(-2 * R - 0.05, 0, 1.0, 0), **row)
    check(run)
    soon = run.events[0].time + 1e-6 + 10 * count * gap  # before the cloth makes them meet anew
    last = [event for event in run.events if event.kind in MEETINGS and event.time < soon][-1]
    return np.array([state_after(run, name, last).velocity[0] for name in run.balls])


# Longer rows that rebound less are pushed together too often: see docs/table.md.
@pytest.mark.parametrize(
    ('count', 'restitution'),
    [
        (2, 0.0),
        (3, 0.0),
        (3, 0.5),
        (2, 0.95),
        (3, 0.95),
        (5, 0.95),
        (10, 0.95),
        (5, 1.0),
        (10, 1.0),
        (20, 1.0),
    ],
)
def test_cradles_with_gaps_of_a_nanometre_are_cradles_in_touch(count, restitution):
    scene = scene_with(ENDLESS, ball_ball=SMOOTH | {'restitution': restitution})
    touching, near = cradle(scene, count, 0.0), cradle(scene, count, 1e-9)
    assert near == pytest.approx(touching, abs=1e-6)
    assert (np.diff(touching) > -1e-5).all()  # but for the cloth, since they met


@pytest.mark.parametrize('count', [3, 5])
def test_cradles_with_wide_gaps_hand_the_motion_on(count):
    speeds = cradle(IDEAL, count, 2e-4)  # a contact at 1 m/s reaches 0.13 mm
    assert speeds[:-1] == pytest.approx(0, abs=1e-2)
    assert speeds[-1] == pytest.approx(speeds.sum(), rel=1e-2)


@pytest.mark.parametrize('gap', [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize('speed', [1e-3, 1.0, 8.0])
def test_two_balls_nearly_in_touch(gap, speed):
    """Into the other one, away from it, along it: once met, never twice at the same place."""
    other = state(2 * R + gap, 0)
    into = play(ENDLESS, cue=rolling(0, 0, speed, 0), one=other)
    check(into)
    assert into.final_position['one'][0] > into.final_position['cue'][0] + 2 * R - 1e-9
    away = play(ENDLESS, cue=rolling(0, 0, -speed, 0), one=other)
    check(away)
    assert not [event for event in away.events if event.kind in MEETINGS]
    along = play(ENDLESS, cue=rolling(0, 0, 0, speed), one=other)
    check(along)
    assert not [event for event in along.events if event.kind in MEETINGS]


@pytest.mark.parametrize('miss', [-1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6])
def test_a_ball_that_only_just_passes(miss):
    """The quartic of the meeting has a double root, or two that are hardly apart, or none."""
    run = play(ENDLESS, cue=rolling(-0.5, 2 * R + miss, 2, 0), one=state(0, 0))
    check(run)
    speed = run.balls['cue'].at(run.duration / 2).velocity[0]
    free = play(ENDLESS, cue=rolling(-0.5, 2 * R + miss, 2, 0))
    assert speed == pytest.approx(free.balls['cue'].at(run.duration / 2).velocity[0], abs=0.05)
    if miss >= 1e-9:
        assert not [event for event in run.events if event.kind in MEETINGS]


def test_balls_that_move_alike_never_meet():
    """All coefficients of the quartic are zero but the last: the distance never changes."""
    for gap in (1e-9, 1e-6, 0.01):
        run = play(ENDLESS, cue=rolling(0, 0, 1, 0.3), one=rolling(0, 2 * R + gap, 1, 0.3))
        check(run)
        assert not [event for event in run.events if event.kind in MEETINGS]
        run = play(ENDLESS, cue=rolling(0, 0, 1, 0), one=rolling(2 * R + gap, 0, 1, 0))
        check(run)
        assert run.final_position['one'][0] - run.final_position['cue'][0] == pytest.approx(
            2 * R + gap, abs=1e-9
        )


def test_balls_that_only_just_catch_up():
    """Two that roll alike, the second a trifle faster, meet as they come to rest; or do not."""
    ahead = 0.05
    reach = play(ENDLESS, cue=rolling(0, 0, 1, 0)).final_position['cue'][0]
    for surplus in (-1e-6, -1e-9, 0.0, 1e-9, 1e-6):
        speed = np.sqrt((reach + ahead + surplus) / reach)
        run = play(ENDLESS, cue=rolling(-ahead - 2 * R, 0, speed, 0), one=rolling(0, 0, 1, 0))
        check(run)
        gap = run.final_position['one'][0] - run.final_position['cue'][0] - 2 * R
        assert gap == pytest.approx(max(-surplus, 0.0), abs=2e-6)


def test_balls_from_all_sides_meet_at_once():
    """Four rolling balls, one at rest in the middle: by symmetry it stays, and they go back."""
    around = {
        name: rolling(0.3 * x, 0.3 * y, -x, -y)
        for name, x, y in (('e', 1, 0), ('n', 0, 1), ('w', -1, 0), ('s', 0, -1))
    }
    run = play(IDEAL, cue=state(0, 0), **around)
    check(run)
    assert run.final_position['cue'] == pytest.approx([0, 0, R], abs=1e-6)
    assert run.final_position['e'][0] == pytest.approx(-run.final_position['w'][0], abs=1e-6)
    assert run.final_position['n'][1] == pytest.approx(-run.final_position['s'][1], abs=1e-6)


def test_into_a_corner_between_cushion_and_ball():
    """Wedged: a ball that lies on the cushion, hit towards it at any angle."""
    reach = np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)
    for angle in np.radians([0, 30, 60, 80, 89.9]):
        x, y = -np.cos(angle), np.sin(angle)
        place = np.array([1.27 - reach, 0.2])
        start = place + (2 * R + 0.05) * np.array([x, y])
        run = play(POOL, cue=rolling(*start, -2 * x, -2 * y), one=state(*place))
        check(run)
        assert run.final_position['one'][0] <= 1.27 - reach + 1e-9 or 'one' in run.pocketed


def test_a_hopping_ball_between_a_nose_and_a_ball_leaves_them():
    """The ball ends its contact with the nose; the cue ball is in the nose, and rises along it."""
    balls = {
        'cue': (1.2419946, 0.1579614),
        '1': (1.1959333, 0.1241159),
        '2': (1.1906764, 0.1847209),
    }
    scene = Scene.from_dict({'like': 'robot_table', 'balls': balls})
    run = predict(scene, Stroke.from_offsets(0.31, -0.87, 0.18, azimuth=-1.51, speed=0.52)).run
    assert run.status == Status.OK
    assert len(run.events) < 50


def test_a_ball_that_others_hold_in_a_nose_does_not_pass_through_it():
    """Two balls end its contacts with the nose, and then its spin drives it on."""
    run = play(
        POOL,
        cue=state(1.2407, 0.1919, (2.373, -1.289, 0), (96, 95, 49)),
        one=state(1.2028, 0.1466, (1.269, 2.682, 0), (13.6, 49.1, 72.9)),
        two=state(1.2164, 0.2438, (0.0527, -0.0466, 0), (-3.7, -2.6, 1.9)),
    )
    check(run)
    places = run.balls['cue'].at(np.linspace(0, 1, 1000)).position
    assert places[:, 0].max() < 1.245


@pytest.mark.parametrize('exponent', [1.0, 1.5])
def test_a_frozen_rack_breaks_whatever_its_springs(exponent):
    rack = {
        f'{row}.{i}': state(np.sqrt(3) * R * row, R * (2 * i - row))
        for row in range(4)
        for i in range(row + 1)
    }
    scene = dataclasses.replace(ENDLESS, exponent=exponent)
    run = play(scene, cue=rolling(-0.2, 0.002, 5, 0), **rack)
    check(run)
    first = next(event for event in run.events if event.kind in MEETINGS)
    assert first.kind == EventKind.CLUSTER
    assert len(first.balls) == 11


@pytest.mark.parametrize('status', [Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED])
def test_a_table_ends_where_a_cluster_is_not_solved(monkeypatch, status):
    """With the status of the collision, in its row only. Interpreted code can be changed."""
    solve = event_loop.solve

    def unsolved(table, impact, room):
        solve(table, impact, room)
        room.results.outcomes[0].status = status

    monkeypatch.setattr(machine_code, 'is_loaded', lambda: False)
    frozen = {'cue': rolling(-0.3, 0, 2, 0), '1': state(0, 0), '2': state(2 * R, 0)}
    free = {**frozen, '2': state(0.5, 0)}
    expected = play(ENDLESS, **free)
    monkeypatch.setattr(event_loop, 'solve', unsolved)
    run = play(ENDLESS, **frozen)
    assert run.status == status
    assert run.events[-1].kind == EventKind.CLUSTER
    many = simulate_batch(ENDLESS, [free, frozen, free])
    assert list(many.status) == [Status.OK, status, Status.OK]
    assert many.final_position[2, 0] == pytest.approx(expected.final_position['cue'], abs=1e-12)


def test_frozen_racks_are_broken_from_anywhere():
    """Thirty-one contacts with friction, hit off the middle, under Hertz's law."""
    draw = np.random.default_rng(3)
    scene = Scene.from_dict(
        {'like': 'eight_ball', 'exponent': 1.5, 'rack': {'game': 'eight_ball', 'gap': 0.0}}
    )
    low, high = (-0.2, -0.2, 0.06, -0.08, 2), (0.2, 0.3, 0.2, 0.08, 9)
    strokes = [Stroke.from_offsets(*draw.uniform(low, high)) for _ in range(20)]
    batch = predict_batch(
        scene, [each.normal for each in strokes], [each.velocity for each in strokes]
    )
    assert set(batch.status.tolist()) <= {Status.OK, Status.OFF_TABLE}


# --- what one ball does to another: published angles, throw, spin transfer, energies -------------


def cut(angle, speed=1.0, distance=0.3):
    """Place of an object ball that a cue ball from the origin along x cuts by an angle."""
    x = distance + 2 * R * np.cos(angle)
    return x, 2 * R * np.sin(angle)


def angle_of(v):
    return np.arctan2(v[1], v[0])


@pytest.mark.parametrize('angle', np.radians([5, 30, 60, 85]))
def test_stun_leaves_at_right_angles(angle):
    # so near that the ball has not begun to roll: its spin is still zero in the slide's plane
    scene = scene_with(ENDLESS, ball_ball=SMOOTH)
    x, y = cut(angle, distance=1e-4)
    run = play(scene, cue=state(0, 0, (1, 0, 0)), one=state(x, y))
    cue, one = after(run, 'cue', EventKind.BALL), after(run, 'one', EventKind.BALL)
    assert abs(cue.velocity @ one.velocity) < 1e-12
    assert angle_of(one.velocity) == pytest.approx(angle, abs=1e-9)


def deflection(fraction):
    """Final angle of a rolling cue ball that hits a ball with this fraction of its width."""
    scene = scene_with(ENDLESS, ball_ball=SMOOTH)
    x, y = cut(np.arcsin(1 - fraction))
    run = play(scene, cue=rolling(0, 0, 2, 0), one=state(x, y))
    roll = after(run, 'cue', EventKind.ROLL)
    return -np.degrees(angle_of(roll.velocity))


def test_rolling_cue_ball_deflects_by_33_67_degrees_at_half_ball():
    # Alciatore, technical proof TP 3.3: 33.67 degrees at half ball, 33.75 at most
    assert deflection(0.5) == pytest.approx(33.67, abs=0.005)
    most = max(deflection(f) for f in np.linspace(0.4, 0.6, 41))
    assert most == pytest.approx(33.75, abs=0.01)


def throw(angle, speed, spin=(0, 0, 0)):
    """Throw of the object ball in degrees, from the line of centres."""
    x, y = cut(angle, distance=1e-9)
    run = play(ENDLESS, cue=state(0, 0, (speed, 0, 0), spin), one=state(x, y))
    one = after(run, 'one', EventKind.BALL)
    return np.degrees(angle_of(one.velocity) - angle)


@pytest.mark.parametrize(('angle', 'speed'), [(30, 0.5), (30, 2.0), (45, 1.0), (60, 1.0)])
def test_stun_shots_throw_by_alciatores_formula(angle, speed):
    # TP A.14: tan(throw) = min(mu v cos / v_n, 1/7) v sin / v ... for a stun shot: slip v sin
    slip, closing = speed * np.sin(np.radians(angle)), speed * np.cos(np.radians(angle))
    mu = 0.00995 + 0.108 * np.exp(-1.088 * slip)
    # both balls share (1 + e) / 2 of the closing speed, and friction 1/7 of the slip at most
    expected = np.degrees(np.arctan(min(mu, slip / 7 / (0.975 * closing))))
    assert -throw(np.radians(angle), speed) == pytest.approx(expected, rel=1e-6)


def test_gearing_spin_gives_no_throw():
    angle = np.radians(30)
    spin = -np.sin(angle) / R
    # outside English that lets the two surfaces roll on each other
    amounts = [throw(angle, 1.0, (0, 0, s)) for s in (-spin, spin)]
    assert min(abs(a) for a in amounts) < 1e-7
    assert max(abs(a) for a in amounts) > 1.0


def test_side_spin_throws_a_full_ball_and_turns_it_the_other_way():
    run = play(ENDLESS, cue=state(0, 0, (1, 0, 0), (0, 0, 30)), one=state(2 * R + 1e-9, 0))
    one = after(run, 'one', EventKind.BALL)
    assert one.velocity[1] > 0
    assert one.spin[2] < 0
    cue = after(run, 'cue', EventKind.BALL)
    assert one.spin[2] == pytest.approx(cue.spin[2] - 30, rel=1e-6)  # equal balls, equal turns


def test_momentum_is_kept():
    scene = scene_with(ENDLESS, effects=Effects(flight='off'))
    run = play(scene, cue=state(0, 0, (3, 0, 0), (10, -40, 50)), one=state(0.2, 0.03))
    event = next(e for e in run.events if e.kind == EventKind.BALL)
    before = run.balls['cue'].at(event.time - 1e-9).velocity
    total = after(run, 'cue', EventKind.BALL).velocity + after(run, 'one', EventKind.BALL).velocity
    assert total[:2] == pytest.approx(before[:2], abs=1e-7)


def test_newtons_cradle():
    # near, but not in touch: one impact after the other
    scene = scene_with(ENDLESS, ball_ball=SMOOTH | {'gap': 0.0, 'duration': 0.0})
    gap = 2 * R + 1e-5
    row = {str(i): state(0.1 + i * gap, 0) for i in range(5)}
    run = play(scene, cue=state(0, 0, (1, 0, 0)), **row)
    hits = [e for e in run.events if e.kind == EventKind.BALL]
    assert [e.balls for e in hits[:5]] == [('cue', '0'), *((str(i), str(i + 1)) for i in range(4))]
    last = run.balls['4'].at(hits[4].time)
    before = run.balls['cue'].at(hits[0].time - 1e-12)
    assert last.velocity[0] == pytest.approx(before.velocity[0], rel=1e-3)
    assert abs(run.balls['3'].at(hits[4].time).velocity[0]) < 1e-12


@pytest.mark.parametrize('apart', [1e-9, 1e-5])
@pytest.mark.parametrize('restitution', [0.0, 0.5, 0.95, 1.0])
def test_a_row_that_jostles_comes_to_rest_where_nothing_counts_as_in_touch(restitution, apart):
    """Three that met within rounding were in touch, but not in contact: they met for ever."""
    scene = scene_with(ENDLESS, ball_ball=SMOOTH | {'gap': 0.0, 'restitution': restitution})
    row = {str(i): state(0.1 + i * (2 * R + apart), 0) for i in range(5)}
    run = play(scene, cue=state(0, 0, (1, 0, 0)), **row)
    assert run.status is Status.OK


def test_a_flying_ball_clears_another():
    hop = play(ENDLESS, cue=state(0, 0, (2, 0, 1.5)), one=state(0.3, 0))
    assert not any(e.kind == EventKind.BALL for e in hop.events)
    low = play(ENDLESS, cue=state(0, 0, (2, 0, 0.3)), one=state(0.1, 0))
    hit = next(e for e in low.events if e.kind == EventKind.BALL)
    assert hit.position[2] > R
    assert after(low, 'cue', EventKind.BALL).velocity[2] > 0.3 - 9.9 * hit.time  # pushed up


def test_equal_times_are_played_in_the_order_of_the_balls():
    both = {'left': state(-0.2, 0, (1, 0, 0)), 'right': state(0.2, 0, (-1, 0, 0))}
    run = play(ENDLESS, **both)
    rolls = [e.balls[0] for e in run.events if e.kind == EventKind.ROLL]
    assert rolls[:2] == ['left', 'right']


# --- the next meeting that is kept for each ball is the one that a search of all pairs finds -----

BALLS = 6
TIMES = (0.1, 0.2, 0.3, math.inf)  # few, so that many are equal


def simulation():
    """Balls that meet nothing yet."""
    room = room_for_simulation(OBJECTS, BALLS)
    s = Simulation(
        room.balls,
        [[math.inf] * BALLS for _ in range(BALLS)],
        TableOutcome(),
        room.rebound[0],
        [],
        [],
        rules=[],
        cue=room.cue[0],
    )
    s.cue.meeting_time = math.inf
    for ball in s.balls:
        start_ball(ball, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        ball.end = math.inf
    return s


@pytest.mark.parametrize('seed', range(3))
def test_the_first_of_all_pairs_is_next(seed):
    """Of equal times the pair with the lowest indices; whatever the order of changes."""
    draw, s = np.random.default_rng(seed), simulation()
    for _ in range(300):
        index = int(draw.integers(BALLS))
        for i, time in enumerate(draw.choice(TIMES, BALLS).tolist()):
            if i > index:
                s.collisions[index][i] = time
            elif i < index:
                note_collision(s, i, index, time)
        find_next_meeting(s, index)
        pairs = [(s.collisions[i][j], i, j) for j in range(BALLS) for i in range(j)]
        first = min(pair for pair in [*pairs, (math.inf, NOTHING, NOTHING)])
        assert next_event(s) == (first if first[0] < math.inf else (math.inf, NOTHING, NOTHING))

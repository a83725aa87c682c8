"""What one ball does to another: published angles, throw, spin transfer, energies."""

import numpy as np
import pytest
from tables import after, ENDLESS, play, R, rolling, scene_with, state

from billiard_shot.scene import Effects
from billiard_shot.status import Status
from billiard_shot.table.run.results import EventKind

IDEAL = {'restitution': 1.0, 'friction_fast': 0.0, 'friction_slow': 0.0}


def cut(angle, speed=1.0, distance=0.3):
    """Place of an object ball that a cue ball from the origin along x cuts by an angle."""
    x = distance + 2 * R * np.cos(angle)
    return x, 2 * R * np.sin(angle)


def angle_of(v):
    return np.arctan2(v[1], v[0])


@pytest.mark.parametrize('angle', np.radians([5, 30, 60, 85]))
def test_stun_leaves_at_right_angles(angle):
    # so near that the ball has not begun to roll: its spin is still zero in the slide's plane
    scene = scene_with(ENDLESS, ball_ball=IDEAL)
    x, y = cut(angle, distance=1e-4)
    run = play(scene, cue=state(0, 0, (1, 0, 0)), one=state(x, y))
    cue, one = after(run, 'cue', EventKind.BALL), after(run, 'one', EventKind.BALL)
    assert abs(cue.velocity @ one.velocity) < 1e-12
    assert angle_of(one.velocity) == pytest.approx(angle, abs=1e-9)


def deflection(fraction):
    """Final angle of a rolling cue ball that hits a ball with this fraction of its width."""
    scene = scene_with(ENDLESS, ball_ball=IDEAL)
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
    scene = scene_with(ENDLESS, ball_ball=IDEAL | {'gap': 0.0, 'duration': 0.0})
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
    scene = scene_with(ENDLESS, ball_ball=IDEAL | {'gap': 0.0, 'restitution': restitution})
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

"""What cushions and pockets do to a ball."""

import math

import numpy as np
import pytest
from tables import after, play, POOL, R, rolling, scene_with, state
from test_rebound import random_contacts, rebounds, Steps, TURN

from billiard_shot import (
    BallState,
    EventKind,
    predict,
    Scene,
    simulate,
    simulate_batch,
    Status,
    Stroke,
)
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.effects import EffectContext, params_on_table, TABLE_GATES
from billiard_shot.table.run.layout import layout_of

HAN = scene_with(cushion={'model': 'han'})
STRONGE = scene_with(cushion={'model': 'stronge'})


def test_a_ball_touches_the_nose_where_its_height_says():
    run = play(POOL, cue=state(1.0, 0.3, (1, 0, 0)))
    hit = next(e for e in run.events if e.kind == EventKind.CUSHION)
    nose = POOL.table.cushion.height * 2 * R
    assert hit.place == 'foot'
    assert hit.position[0] == pytest.approx(1.27 - np.sqrt(R**2 - (nose - R) ** 2), abs=1e-12)


def test_han_by_hand():
    # stun at 1 m/s, straight: Han 2005, equations 14 to 22
    run = play(HAN, cue=state(1.242, 0.3, (1, 0, 0)))
    before = run.balls['cue'].at(
        next(e for e in run.events if e.kind == EventKind.CUSHION).time - 1e-12
    )
    sine = 2 * 0.635 - 1
    cosine = np.sqrt(1 - sine**2)
    v, w = before.velocity[0], before.spin[1]
    push = (1 + 0.85) * v * cosine
    slip = v * sine + R * w  # of the ball's surface at the nose, along it
    drag = min(0.2 * push, 2 / 7 * abs(slip)) * np.sign(slip)
    rebound = after(run, 'cue', EventKind.CUSHION)
    assert rebound.velocity[0] == pytest.approx(v - push * cosine - drag * sine, rel=1e-6)
    assert rebound.velocity[1:] == pytest.approx([0, 0], abs=1e-12)


def test_han_is_for_balls_on_the_cloth():
    """A ball in the air meets the default model with the numbers of the scene, and is told so."""
    same = scene_with(cushion={'restitution': 0.85, 'friction': 0.2, 'fading': 0.0})
    ball = state(1.0, 0.3, (2, 0, 0.4))
    one, other = play(HAN, cue=ball), play(same, cue=ball)
    hit = next(e for e in one.events if e.kind == EventKind.CUSHION)
    assert hit.position[2] > R
    found, expected = (after(run, 'cue', EventKind.CUSHION).velocity for run in (one, other))
    assert found == pytest.approx(expected)
    context = EffectContext(HAN, ball.velocity, one, False)
    cushion = next(gate for gate in TABLE_GATES if gate.name == 'cushion')
    assert '1 in the air, where `han` does not hold' in cushion.evaluate(context)[1]


# Of pooltool 0.6.0, `stronge_compliant`, with a normal of the same slope: velocity [m/s] and spin
# [rad/s] before and after.
@pytest.mark.parametrize(
    ('velocity', 'spin', 'left', 'turns'),
    [
        ((1.2, 0.7), (-10, 20, 30), (-0.914468, 0.326803), (-1.184321, 1.755075, -1.438029)),
        ((2.0, 0.2), (0, 60, 0), (-1.621897, 0.137039), (1.487271, -2.093563, -5.303830)),
        ((0.5, 0.9), (10, -30, -40), (-0.312677, 0.963927), (8.489907, -15.453828, -34.614783)),
    ],
)
def test_rebounds_with_stronge_are_those_of_pooltool(velocity, spin, left, turns):
    scene = scene_with(cushion={'model': 'stronge', 'frequency_ratio': 1.8})
    nose = 0.5 * scene.table.length - np.sqrt(1.0 - 0.27**2) * R
    run = play(scene, cue=state(nose - 1e-9, 0.3, (*velocity, 0), spin))
    rebound = after(run, 'cue', EventKind.CUSHION)
    assert rebound.velocity == pytest.approx([*left, 0], abs=2e-5)
    assert rebound.spin == pytest.approx(turns, abs=1e-3)


@pytest.mark.parametrize('model', ['mathavan', 'han', 'stronge'])
@pytest.mark.parametrize('speed', [0.2, 1.0, 5.0])
def test_restitution_fades_with_speed_early_and_late(model, speed):
    numbers = {'restitution': 0.93, 'friction': 0.0, 'early_fading': 0.06, 'fading': 0.1}
    scene = scene_with(cushion={'model': model, 'height': 0.5, **numbers})
    run = play(scene, cue=state(1.23, 0.3, (speed, 0, 0)))
    hit = next(e for e in run.events if e.kind == EventKind.CUSHION)
    met = run.balls['cue'].at(np.nextafter(hit.time, 0.0)).velocity[0]
    left = -after(run, 'cue', EventKind.CUSHION).velocity[0] / met
    assert left == pytest.approx(0.93 / (1.0 + 0.06 * met + (0.1 * met) ** 2), rel=1e-3)


@pytest.mark.parametrize('scene', [POOL, HAN, STRONGE], ids=['mathavan', 'han', 'stronge'])
def test_a_mirrored_shot_is_mirrored(scene):
    states = {'cue': ((2, 1.1, 0), (20, 30, 40))}
    ((velocity, spin),) = states.values()
    run = play(scene, cue=state(0.2, 0.1, velocity, spin))
    x, y, _ = velocity
    flipped = play(scene, cue=state(0.2, -0.1, (x, -y, 0), (-spin[0], spin[1], -spin[2])))
    assert flipped.final_position['cue'] == pytest.approx(
        run.final_position['cue'] * (1, -1, 1), abs=1e-9
    )
    turned = play(scene, cue=state(-0.2, -0.1, (-x, -y, 0), (-spin[0], -spin[1], spin[2])))
    assert turned.final_position['cue'] == pytest.approx(
        run.final_position['cue'] * (-1, -1, 1), abs=1e-9
    )


@pytest.mark.parametrize('scene', [POOL, HAN, STRONGE], ids=['mathavan', 'han', 'stronge'])
def test_running_english_widens_and_reverse_narrows_the_rebound(scene):
    angles = []
    for spin in (-40, 0, 40):
        run = play(scene, cue=state(1.0, 0, (1, 0.7, 0), (-0.7 / R, 1 / R, spin)))
        v = after(run, 'cue', EventKind.CUSHION).velocity
        angles.append(np.arctan2(v[1], -v[0]))
    assert angles[0] < angles[1] < angles[2] or angles[0] > angles[1] > angles[2]


def test_no_cushion_gains_energy():
    random = np.random.default_rng(4)
    for scene in (
        POOL,
        HAN,
        STRONGE,
        scene_with(cushion={'restitution': 1.0}),
        scene_with(cushion={'restitution': 0.05}),
    ):
        for _ in range(100):
            v = random.normal(size=2) * 3
            run = play(scene, cue=state(0.1, 0.1, (*v, 0), random.normal(size=3) * 80))
            for event in run.events:
                assert event.dissipated >= -1e-12 * event.energy_before


@pytest.mark.parametrize(
    ('place', 'velocity', 'pocket'),
    [
        ((0, 0), (2.54, 1.27), 'foot_left'),
        ((0, 0), (-2.54, 1.27), 'head_left'),
        ((0, 0), (-2.54, -1.27), 'head_right'),
        ((0, 0), (2.54, -1.27), 'foot_right'),
        ((0.05, 0), (-0.03, 2), 'side_left'),
        ((0.05, 0), (-0.03, -2), 'side_right'),
    ],
)
def test_pockets_take_what_is_shot_at_them(place, velocity, pocket):
    run = play(POOL, cue=state(*place, (*velocity, 0)))
    assert run.pocketed == {'cue': pocket}
    assert run.balls['cue'].at(run.duration).motion == Motion.POCKETED
    last = run.events[-1]
    assert (last.kind, last.place, last.energy_after) == (EventKind.POCKET, pocket, 0.0)


@pytest.mark.parametrize('behind', [0.07, 0.2])
def test_a_ball_follows_another_into_the_same_pocket(behind):
    """The one that had fallen was still in the way at the mouth."""
    corner, way = np.array([POOL.table.length, POOL.table.width]) / 2, np.sqrt([0.5, 0.5])
    places = [corner - (0.3 + d) * way for d in (0.0, behind)]
    run = play(
        POOL, first=rolling(*places[0], *(1.5 * way)), second=rolling(*places[1], *(1.5 * way))
    )
    assert [e.kind for e in run.events] == [EventKind.POCKET, EventKind.POCKET]


def test_jaws_reject_what_comes_along_the_rail():
    # hard along the cushion, a ball's radius away from it: it rattles
    for inset in (0.0005, 0.004):
        run = play(POOL, cue=rolling(0.2, 0.635 - R - inset, 4, 0))
        assert any('jaw of foot_left' in e.place for e in run.events)


def test_a_ball_driven_into_the_rail_beside_a_side_pocket_stays_on_the_table():
    for x in np.linspace(0.02, 0.12, 41):
        run = play(POOL, cue=state(x, 0.4, (0, 1.5, 0)))
        end = run.balls['cue'].at(run.duration)
        if end.motion == Motion.POCKETED:
            assert set(run.pocketed.values()) <= {'side_left', 'side_right'}
        else:
            assert abs(run.final_position['cue'][1]) < 0.635


def test_a_carom_table_keeps_its_balls():
    table = {'pockets': False}
    scene = POOL.from_dict(POOL.to_dict() | {'table': table})
    random = np.random.default_rng(2)
    for _ in range(100):
        run = play(scene, cue=state(0, 0, (*random.normal(size=2) * 4, 0)))
        assert run.status == Status.OK
        assert not run.pocketed


def test_off_the_table():
    run = play(POOL, cue=state(1.0, 0, (3, 0, 2)))
    assert run.status == Status.OFF_TABLE
    assert run.off_table == ('cue',)
    assert run.balls['cue'].at(9.0).motion == Motion.OFF_TABLE
    assert run.final_position['cue'][0] > 1.27


def test_a_low_flier_meets_the_nose():
    run = play(POOL, cue=state(1.0, 0.3, (2, 0, 0.4)))
    hit = next(e for e in run.events if e.kind == EventKind.CUSHION)
    assert hit.position[2] > R
    nose = np.array([1.27, hit.position[1], POOL.table.cushion.height * 2 * R])
    assert np.linalg.norm(hit.position - nose) == pytest.approx(R, abs=1e-9)
    assert run.status == Status.OK


def test_two_fliers_side_by_side_meet_the_nose_each_for_itself():
    """They were to collide with the cushion at once, which only takes part for balls that lie."""
    run = play(
        POOL,
        left=state(1.2, 0.3, (3, 0, 0), height=2e-3),
        right=state(1.2, 0.3 - 2 * R, (3, 0, 0), height=2e-3),
    )
    assert run.status == Status.OK
    first = [e.kind for e in run.events[:2]]
    assert first == [EventKind.CUSHION, EventKind.CUSHION]


def test_a_flier_drops_into_a_pocket():
    run = play(POOL, cue=state(0.9, 0.3, (1.2, 1.0, 0.8)))
    target = np.array([1.27, 0.635]) - (0.9, 0.3)
    run = play(POOL, cue=state(0.9, 0.3, (*(target * 3), 0.5)))
    assert run.pocketed == {'cue': 'foot_left'}


def test_spin_against_a_frozen_cushion_ends():
    reach = np.sqrt(R**2 - (0.635 * 2 * R - R) ** 2)
    run = play(POOL, cue=state(1.27 - reach, 0.2, (0, 0, 0), (0, 100, 0)))
    assert run.status == Status.OK
    assert run.final_position['cue'][0] < 1.27 - reach + 1e-9
    assert len(run.events) < 2000


# --- A nose with a spring along its surface: Stronge's solutions, a scheme of small steps, limits

NEVER_LANDS = 1e9


def stiffness(ratio):
    """Tangential stiffness at a ratio of frequencies, relative to the normal stiffness."""
    return ratio**2 / (1 + TURN)


def slip_after(slip, approach, ratio, friction, restitution):
    """Slip after a contact of a ball without spin, with a nose at the height of its centre."""
    velocity, spin, _, _ = rebounds(
        (slip, approach, 0.0),
        (0.0, 0.0, 0.0),
        NEVER_LANDS,
        0.0,
        friction,
        restitution=restitution,
        tangential_stiffness=stiffness(ratio),
    )
    assert velocity[1] == pytest.approx(-restitution * approach, abs=1e-7)
    return velocity[0] - spin[2]


@pytest.mark.parametrize('share', [0.1, 0.5, 0.99])
def test_a_spring_as_fast_as_the_normal_one_reverses_the_slip(share):
    """Its force is then a constant share of the limit of friction, so it never slips."""
    slip = share * 0.4 / stiffness(1.0)
    assert slip_after(slip, 1.0, 1.0, 0.4, 1.0) == pytest.approx(-slip, abs=1e-6)


@pytest.mark.parametrize(('ratio', 'restitution'), [(1.8, 0.6), (1.8, 0.98), (1.2, 0.9)])
def test_a_ball_that_slips_all_the_time_has_coulomb_friction(ratio, restitution):
    """If the restitution is above 1 / ratio, the slip is closest to sticking at the end."""
    friction = 0.14
    most = friction * ((1 + TURN) * (1 + restitution) - 1 / (stiffness(ratio) * restitution))
    rigid = most * 1.01 - friction * (1 + TURN) * (1 + restitution)
    assert slip_after(most * 1.01, 1.0, ratio, friction, restitution) == pytest.approx(
        rigid, abs=1e-6
    )
    # a slower one sticks before the end, and is pushed back
    slower = most * 0.9 - friction * (1 + TURN) * (1 + restitution)
    assert slip_after(most * 0.9, 1.0, ratio, friction, restitution) > slower + 1e-4


# Of pooltool 0.6.0, `stronge_compliant`. Slips and approach in m/s.
@pytest.mark.parametrize(
    ('slip', 'approach', 'friction', 'restitution', 'after'),
    [
        (0.102046, 0.841020, 0.14, 0.98, 0.049574),
        (0.757221, 0.364620, 0.14, 0.98, 0.403467),
        (0.800241, 0.743907, 0.50, 0.85, -0.328406),
        (0.959645, 0.863909, 1.00, 0.85, 0.069377),
        (0.046532, 0.827135, 0.20, 0.50, -0.023389),
    ],
)
def test_slips_after_contacts_are_those_of_pooltool(slip, approach, friction, restitution, after):
    assert slip_after(slip, approach, 1.8, friction, restitution) == pytest.approx(after, abs=2e-6)


@pytest.mark.parametrize('height', [0.0, 0.3, NEVER_LANDS])
@pytest.mark.parametrize('ratio', [1.0, 1.8, 3.0])
def test_contacts_agree_with_small_steps(height, ratio):
    velocity, spin = np.array([0.4, 1.0, 0.0]), np.array([-1.0, 0.4, 0.5])
    steps = Steps(velocity, spin, height, 0.25, 5e-4, stiffness(ratio)).run()
    found = rebounds(velocity, spin, height, 0.25, tangential_stiffness=stiffness(ratio))
    for one, other in zip(found[:2], steps[:2], strict=True):
        assert one == pytest.approx(other, abs=1e-3)


@pytest.mark.parametrize('height', [0.0, NEVER_LANDS])
@pytest.mark.parametrize('friction', [0.14, 0.5])
def test_a_stiff_spring_is_a_rigid_nose(height, friction):
    given = (0.2, 1.0, 0.0), (0.3, 0.1, -0.1), height, 0.2, friction, 1e-7
    rigid = np.hstack(rebounds(*given)[:2])
    errors = [
        np.abs(np.hstack(rebounds(*given, tangential_stiffness=k)[:2]) - rigid).max()
        for k in (1.0, 3e3)
    ]
    assert errors[1] < min(2e-3, 0.1 * errors[0])


def test_energy_is_never_gained_and_the_tolerance_holds():
    random = np.random.default_rng(4)
    for velocity, spin, height, sine, friction in random_contacts(30):
        spring = {'tangential_stiffness': stiffness(random.choice([0.5, 1.0, 1.8, 3.0]))}
        coarse = rebounds(velocity, spin, height, sine, friction, 1e-5, **spring)
        fine = rebounds(velocity, spin, height, sine, friction, 1e-8, **spring)
        scale = max(*np.abs(velocity), *np.abs(spin))
        for one, other in zip(coarse[:2], fine[:2], strict=True):
            assert one == pytest.approx(other, abs=300 * 1e-5 * scale)
        before = velocity @ velocity + spin @ spin / TURN
        assert fine[0] @ fine[0] + fine[1] @ fine[1] / TURN <= before * (1 + 1e-7)


def test_a_landing_between_two_steps_is_found():
    """The spring lifts the ball soon after it met the cloth, within one step."""
    given = (
        (0.891167, 0.320848, -0.245469),
        (1.463305, -1.002880, 1.758321),
        0.362222,
        0.438269,
        2.0,
    )
    spring = {'restitution': 0.5, 'tangential_stiffness': stiffness(1.8), 'cloth_friction': 0.2}
    fine = np.hstack(rebounds(*given, 1e-10, **spring)[:2])
    for tolerance in (1e-5, 1e-6, 1e-7):
        found = np.hstack(rebounds(*given, tolerance, **spring)[:2])
        assert found == pytest.approx(fine, abs=100 * tolerance)


# -- on the table


def leaves(start, **cushion):
    """Velocity with which a ball leaves the first cushion that it meets."""
    run = simulate(scene_with(cushion=cushion), {'cue': start})
    hit = next(event for event in run.events if event.kind == EventKind.CUSHION)
    segments = run.balls['cue'].segments
    return run.balls['cue'].at(max(s.end for s in segments if s.start == hit.time)).velocity


def test_the_option_changes_the_rebound_of_a_scene():
    start = rolling(0.3, 0.5, 0.7, 1.9)
    rigid, compliant = (leaves(start, friction=0.2, frequency_ratio=x) for x in (0.0, 1.8))
    # more of the slip is given back: the ball leaves faster, and nearer to the normal
    assert np.linalg.norm(compliant) > 1.02 * np.linalg.norm(rigid)
    assert compliant[0] / -compliant[1] < 0.95 * rigid[0] / -rigid[1]
    lying = [leaves(start, model='han', frequency_ratio=x) for x in (0.0, 1.8)]
    assert lying[0] == pytest.approx(lying[1], abs=0.0)


# --- balls at edges: in mouths of pockets, above and beside noses, and on jaws -------------------

SCENE = Scene.load('pool_table')
LAYOUT = layout_of(*params_on_table(SCENE))
NUMBERS = LAYOUT.numbers
HALF = NUMBERS.centre_half_width


def run_of(*state):
    return simulate(SCENE, {'1': BallState(*state)})


@pytest.mark.parametrize('up', [0.0, 0.01, 0.05, 0.2])
def test_a_ball_that_hops_in_the_mouth_of_a_pocket_lands_on_its_shelf(up):
    """It counted as off the table: 4 % of shots at a ball that hangs in a side pocket."""
    assert run_of((0.03, 0.6372, R), (0.1, 0.0, up)).status is Status.OK
    stroke = Stroke.from_offsets(0, 0.5, elevation=0.15, azimuth=math.pi / 2, speed=0.3)
    shot = predict(SCENE, stroke, position=(0.03, NUMBERS.nose_half_width + 0.002))
    assert shot.run.pocketed == {'cue': 'side_left'}


def test_a_ball_that_comes_down_behind_a_cushion_is_off_the_table():
    for place, velocity in (((0.3, 0.3), (0.0, 0.907, 2.0)), ((0.9, 0.2), (0.98, 0.0, 2.0))):
        run = run_of((*place, R), velocity)
        assert run.status is Status.OFF_TABLE
        assert run.events[-1].time == pytest.approx(0.408, abs=0.01)


@pytest.mark.parametrize('seed', range(40))
def test_a_ball_that_flies_along_a_nose_does_not_go_through_it(seed):
    """23 % of balls in the air that reached a nose at less than 1.5 degrees went into it."""
    rng = np.random.default_rng(seed)
    angle, speed = math.radians(rng.uniform(0.0, 1.5)), rng.uniform(1.0, 7.0)
    run = run_of(
        (-1.0, HALF - 10 ** rng.uniform(-5, -2.3), R + 1e-4),
        (speed * math.cos(angle), speed * math.sin(angle), rng.uniform(0.2, 1.2)),
    )
    for time in np.linspace(0.0, 0.3, 300):
        x, y, z = run.at(time)['1'].position
        if abs(x) < 1.1:
            distance = math.hypot(NUMBERS.nose_half_width - y, z - NUMBERS.nose_height)
            # a nose that is pressed gives way by some millimetres
            assert distance > 0.75 * R, (time, x, y, z)


def test_a_ball_on_the_top_of_a_nose_rolls_off_it():
    x = NUMBERS.nose_half_length - R * math.sqrt(0.19) - 1e-7
    run = run_of((x, 0.2, NUMBERS.nose_height + 0.9 * R))
    assert run.status is Status.OK
    assert run.final_position['1'][0] < NUMBERS.centre_half_length


def test_a_ball_keeps_its_vertical_speed_at_a_nose_that_it_touches():
    touching, near = (run_of((0.3, HALF - gap, R), (0.5, 0.0, 1.0)) for gap in (0.0, 1e-9))
    assert touching.at(0.0)['1'].velocity[2] == 1.0
    assert touching.final_position['1'] == pytest.approx(near.final_position['1'], abs=1e-6)


def test_a_ball_that_begins_on_the_cloth_with_a_downward_speed_bounces():
    on, above = (run_of((0, 0, R + height), (0.5, 0.0, -1.0)) for height in (0.0, 1e-9))
    assert on.final_position['1'] == pytest.approx(above.final_position['1'], abs=1e-6)


def test_a_ball_that_its_spin_presses_to_a_jaw_is_set_apart_from_it():
    jaw, along = LAYOUT.jaws[8], 0.15
    x = jaw.start_x + along * (jaw.end_x - jaw.start_x) + jaw.normal_x * NUMBERS.nose_standoff
    y = jaw.start_y + along * (jaw.end_y - jaw.start_y) + jaw.normal_y * NUMBERS.nose_standoff
    spin = 60.0 * jaw.normal_y, -60.0 * jaw.normal_x, 0.0
    run = run_of((x, y, R), (0.0, 0.0, 0.0), spin)
    assert run.status is Status.OK
    assert len(run.events) < 1000


def test_a_ball_whose_contact_with_a_nose_another_ball_ends_does_not_stay_in_it():
    run = simulate(
        SCENE,
        {
            '0': BallState(
                (0.0727985, HALF, R), (-0.00146594, 0.00078228, 0), (-0.027, -0.051, 0)
            ),
            '1': BallState((-0.10192263, 0.58654454, R), (-0.000155996, -0.00117873, 0)),
            '2': BallState(
                (0.05108954, 0.55449369, R),
                (0.01607078, 0.02092501, 0),
                (-0.652601, -0.155221, -0.273355),
            ),
        },
    )
    assert abs(run.final_position['0'][1]) <= HALF + 1e-9


def test_a_row_of_a_batch_is_refused_where_a_ball_is_in_a_cushion():
    places = (1.26, 0.2, R), (1.27, 0.635, R), (1.3, 0.2, R), (1.2, 0.2, R)
    batch = simulate_batch(SCENE, [{'1': BallState(place)} for place in places])
    assert batch.status.tolist() == [*[Status.INVALID_REQUEST] * 3, Status.OK]


def test_without_rolling_resistance_a_short_contact_is_not_missed():
    scene = Scene.from_dict({'like': 'pool', 'effects': {'roll': 'off'}})
    states = {
        'cue': BallState((0, 0, R), (8, 0, 0), (0, 8 / R, 0)),
        '1': BallState((0.5, 0.95 * 2 * R, R)),
    }
    assert simulate(scene, states).events[0].kind is EventKind.BALL

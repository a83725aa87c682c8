"""What cushions and pockets do to a ball."""

import numpy as np
import pytest
from tables import after, play, POOL, R, rolling, scene_with, state

from billiard_shot.status import Status
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.effects import EffectContext, TABLE_GATES
from billiard_shot.table.run.results import EventKind

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

"""Effects are simulated where they are called for, and leaving out the others changes nothing."""

import dataclasses
from itertools import combinations

import numpy as np
import pytest

from billiard_shot import effects_of, predict, Scene, sensitivity_of, Status, Stroke
from billiard_shot.scene import Effects, Noise
from billiard_shot.scene.files import scene_names
from billiard_shot.shot.effects import GATES, STRIKE_GATES, strike_model, StrikeModel
from billiard_shot.study import steps
from billiard_shot.table.model.geometry import BallClothParams, TableParams
from billiard_shot.table.run.effects import apply_overrides, TABLE_GATES
from billiard_shot.table.run.layout import table_params
from billiard_shot.table.run.results import EventKind

NAMES = [gate.name for gate in GATES]
OF_ONE_BALL = NAMES[: NAMES.index('cushion')]  # the others: test/table/test_table_effects.py
PAPER = Scene.load('paper')
POOL = Scene.from_dict({'like': 'pool', 'cue': {'tip_curvature_radius': 0.0106}})
PLAIN = Stroke.from_offsets(0.3, 0.1, 0.3, 0.0, 2.0)
# a little of everything: jumps, bounces, slides, rolls, and has spin about the vertical
BUSY = Stroke(PLAIN.normal, PLAIN.velocity, axis=True)
MEETINGS = EventKind.BALL, EventKind.CLUSTER, EventKind.CUE
LEVEL = Stroke.from_offsets(0, 0, 0, 0, 1)


def wishing(scene, **settings):
    return dataclasses.replace(scene, effects=Effects(**settings))


def effect(shot, name):
    return next(effect for effect in effects_of(shot) if effect.name == name)


def random_scene(draw):
    """Ball, cue, contacts, law; half with a table and balls; some without friction or rebound."""
    ball = {'mass': draw.uniform(0.1, 0.25), 'radius': draw.uniform(0.02, 0.035)}

    def contact(friction):
        return {
            'restitution': draw.choice([0, draw.uniform(0, 0.9)], p=[0.1, 0.9]),
            'friction': draw.choice([0, friction], p=[0.1, 0.9]),
            'stiffness': 10 ** draw.uniform(-1, 1),
        }

    places = {
        str(number): [x, y]
        for number, (x, y) in enumerate(draw.uniform(-1, 1, (3, 2)) * (1, 0.5))
        if np.hypot(x, y) > 0.1
    }
    around = {'table': {}, 'balls': places if _apart(places) else {}}
    return Scene.from_dict(
        {
            **(around if draw.random() < 0.5 else {}),
            'ball': ball,
            'cue': {'mass': draw.uniform(0.3, 0.7), 'guided': bool(draw.random() < 0.3)},
            'contacts': {
                'cue_ball': contact(draw.uniform(0.2, 0.8)),
                'ball_table': contact(draw.uniform(0.1, 0.4)),
            },
            'cloth': {
                'sliding_friction': draw.uniform(0.1, 0.4),
                'spin_deceleration': draw.uniform(5, 40),
            },
            'law': str(draw.choice(['bistiffness', 'energetic'])),
        }
    )


def _apart(places):
    return all(np.hypot(x - u, y - v) > 0.1 for (x, y), (u, v) in combinations(places.values(), 2))


def random_stroke(draw):
    offset, around = 0.6 * np.sqrt(draw.random()), draw.uniform(0, 2 * np.pi)
    return Stroke.from_offsets(
        offset * np.cos(around),
        0.2 + offset * np.sin(around),
        draw.choice([0, draw.uniform(0, 1.4)]),
        draw.uniform(-3, 3),
        10 ** draw.uniform(-1.3, 0.9),
    )


def hits_again(shot):
    return shot.double_hit is not None or shot.chatter


def test_gated_is_everything_on_within_the_tolerance_and_cheaper():
    """
    500 random scenes: the same trajectory at equal times, from fewer steps.

    Up to the first impact with another ball or again with the cue, after which what is small
    grows. Hops that are left out can hide a cue that grazes the ball again within milliseconds: in
    no more than one shot of 300 that moves the ball by more than the tolerance, and by 2 mm at
    most. The shaft is off: its steps would be on both sides, and hide what is saved.
    """
    draw = np.random.default_rng(4)
    tolerance = 1e-4
    work, apart = np.zeros((500, 2), dtype=int), np.zeros(500)
    hidden = np.zeros(500, dtype=bool)  # only one of the two hits again
    on_table = np.zeros(500, dtype=bool)
    for number, row in enumerate(work):
        scene, stroke = wishing(random_scene(draw), shaft='off'), random_stroke(draw)
        others = [name for name in NAMES if name != 'shaft']
        forced = [name for name in others if name != 'end_mass' or not scene.cue.guided]
        gated = predict(scene, stroke, tolerance)
        on = dict.fromkeys(forced, 'on')
        everything = predict(wishing(scene, shaft='off', **on), stroke, tolerance)
        if gated.status.refused:
            assert everything.status == gated.status
            continue
        met = [event.time for event in gated.trajectory.events if event.kind in MEETINGS]
        if not met:
            assert everything.status == gated.status
        times = np.linspace(0, min([everything.trajectory.duration, *met]), 50)[:-1]
        one, other = gated.trajectory.at(times), everything.trajectory.at(times)
        apart[number] = np.abs(one.position - other.position).max()
        hidden[number] = hits_again(gated) != hits_again(everything)
        row[:] = steps(gated), steps(everything)
        on_table[number] = scene.table is not None
        if number % 20 == 0:
            ours = [effect for effect in effects_of(gated) if effect.name != 'shaft']
            assert all(effect.simulated == effect.called_for for effect in ours)
            theirs = [effect for effect in effects_of(everything) if effect.name != 'shaft']
            assert all(effect.simulated or not effect.called_for for effect in theirs)
    assert (apart[hidden] > tolerance).sum() <= 500 / 300
    assert apart[hidden].max(initial=0.0) < 2e-3
    assert apart[~hidden].max() < tolerance
    assert (work[:, 0] <= work[:, 1]).mean() > 0.95  # balls that go other ways may go shorter ones
    assert (work[:, 0] < work[:, 1]).mean() > 0.5
    for some, saved in ((on_table, 2.1), (~on_table, 1.4)):
        assert work[some, 1].sum() > saved * work[some, 0].sum()


@pytest.mark.parametrize('name', NAMES)
def test_gates_want_the_same_whether_forced_or_not(name):
    """What a gate says of a shot does not depend on what the scene settings of its effect."""
    draw = np.random.default_rng(NAMES.index(name))
    for _ in range(20):
        scene, stroke = random_scene(draw), random_stroke(draw)
        free = effect(predict(wishing(scene, **{name: 'auto'}), stroke), name)
        off = predict(wishing(scene, **{name: 'off'}), stroke)
        assert effect(off, name).called_for == free.called_for == free.simulated
        assert not effect(off, name).simulated


@pytest.mark.parametrize('name', OF_ONE_BALL)
def test_what_is_forced_off_is_reported(name):
    shot = predict(wishing(POOL, **{name: 'off'}), BUSY)
    report = effect(shot, name)
    assert (report.simulated, report.called_for) == (False, True)
    assert report.reason.startswith('the scene turns it off; it would be simulated: ')
    assert effect(predict(wishing(POOL, **{name: 'auto'}), BUSY), name).simulated


@pytest.mark.parametrize('name', OF_ONE_BALL)
def test_what_is_forced_off_changes_the_shot(name):
    free, off = (predict(wishing(POOL, **{name: how}), BUSY) for how in ('auto', 'off'))
    strike = NAMES.index(name) < NAMES.index('flight')
    assert np.allclose(free.velocity, off.velocity, atol=1e-12) != strike
    assert (off.status == Status.NEVER_RESTS) == (name in ('roll', 'spin_decay'))
    if name == 'spin_decay':
        assert off.trajectory.final_position == pytest.approx(
            free.trajectory.final_position, abs=1e-12
        )
    else:
        assert np.abs(off.trajectory.final_position - free.trajectory.final_position).max() > 1e-6


def test_reasons_of_what_is_not_called_for():
    shot = predict(PAPER, LEVEL)
    reasons = {effect.name: effect.reason for effect in effects_of(shot) if not effect.simulated}
    assert reasons['end_mass'] == 'the cue is guided: its tip cannot move sideways'
    assert reasons['flight'] == 'the ball does not leave the cloth'
    assert reasons['bounce'] == 'there is no flight'
    assert reasons['spin_decay'] == 'no ball that would spin about the vertical'
    assert reasons['cushion'] == 'the scene has no table: the cloth is endless'
    assert reasons['ball_ball'] == 'there is no other ball'
    assert reasons['tip_friction'] == 'there is no slip to resist at the tip'
    assert effect(shot, 'slide').simulated
    off = predict(wishing(PAPER, flight='off'), LEVEL)
    assert effect(off, 'flight').reason == (
        'the scene turns it off; nothing calls for it either: the ball does not leave the cloth'
    )


def test_without_slide_the_ball_rolls_as_it_would_in_the_end():
    """5/7 of the speed are left of a stun stroke's: the angular momentum about the cloth stays."""
    free = predict(POOL, LEVEL, 1e-9)
    off = predict(wishing(POOL, slide='off'), LEVEL, 1e-9)
    start = off.trajectory.at(0.0)
    assert start.velocity[0] == pytest.approx(5 / 7 * free.velocity[0], rel=1e-9)
    assert start.spin[1] == pytest.approx(start.velocity[0] / POOL.ball.radius, rel=1e-12)


def test_without_table_contact_the_ball_is_struck_in_the_air():
    """A smooth tip, straight down at 45 degrees: the ball leaves along the normal."""
    scene = wishing(POOL, table_contact='off', tip_friction='off')
    shot = predict(scene, Stroke((-1, 0, 1), (1, 0, -1)), 1e-10)
    assert shot.velocity[2] == pytest.approx(-shot.velocity[0], rel=1e-12)
    assert shot.impact.dissipated[1] == pytest.approx([0, 0], abs=1e-15)
    assert [phase.active for phase in shot.impact.phases] == [(0,)]
    assert shot.trajectory.at(0.0).velocity[2] == 0.0


def test_without_end_mass_a_cue_throws_the_ball_like_a_guided_one():
    off = predict(wishing(POOL, end_mass='off'), BUSY)
    guided = dataclasses.replace(POOL, cue=dataclasses.replace(POOL.cue, guided=True))
    assert off.velocity.tolist() == predict(guided, BUSY).velocity.tolist()


def test_a_rounded_tip_touches_nearer_to_the_middle():
    """
    A tip as round as the ball, of a cue whose axis is 0.4 radii off: it touches at 0.2.

    In a stroke so slow that the normal hardly turns, which depends on the curvature.
    """
    data = {'like': 'pool', 'cue': {'tip_curvature_radius': POOL.ball.radius}}
    scene, point = Scene.from_dict(data), Scene.load('pool')
    axis = Stroke.from_pose(
        (-1, -0.4 * POOL.ball.radius, POOL.ball.radius),
        (0, 0, 0, 1),
        0.02,
        (0, 0, POOL.ball.radius),
    )
    shot = predict(scene, axis)
    expected = predict(point, Stroke.from_offsets(0.2, 0, 0, 0, 0.02))
    assert shot.velocity == pytest.approx(expected.velocity, rel=1e-3, abs=1e-5)
    assert shot.spin == pytest.approx(expected.spin, rel=1e-3, abs=1e-3)
    assert effect(shot, 'tip_curvature').reason.startswith('the tip touches the ball 5.7')
    stated = predict(scene, Stroke.from_offsets(0.2, 0, 0, 0, 0.02))
    assert stated.velocity == pytest.approx(shot.velocity, rel=1e-9, abs=1e-12)
    sensitive = sensitivity_of(stated)
    assert sensitivity_of(shot) == pytest.approx(sensitive, rel=1e-3, abs=1e-6)
    assert not effect(stated, 'tip_curvature').called_for
    off = predict(wishing(scene, tip_curvature='off'), axis)
    assert off.velocity == pytest.approx(
        predict(point, Stroke.from_offsets(0.4, 0, 0, 0, 0.02)).velocity, rel=1e-9, abs=1e-12
    )


def test_a_stroke_that_states_the_axis_keeps_it():
    """Without errors, a player plays what is planned."""
    planned = Stroke.from_offsets(0.4, 0.1, 0.2, 0.3, 2.0, axis=True)
    exact = Noise(0.0, 0.0, 0.0, 0.0, 0.0).perturb(planned, np.random.default_rng(1))
    for stroke in (exact, Stroke.from_offsets(*planned.offsets, axis=planned.axis)):
        touching = stroke.touching(0.5)
        assert touching.offsets[:2] == pytest.approx((0.4 / 1.5, 0.1 / 1.5))
        assert not touching.axis


def test_a_guided_cue_has_no_end_mass_to_turn_on():
    with pytest.raises(
        ValueError, match=r"effects\.end_mass must be auto or off for a guided cue, got 'on'"
    ):
        wishing(PAPER, end_mass='on')


def test_every_effect_can_be_wished_for_and_has_a_gate():
    assert [field.name for field in dataclasses.fields(Effects)] == NAMES


def test_what_is_forced_off_changes_the_numbers_of_one_thing():
    """Of the strike; or of ball and cloth, or what there is on the table, but not of both."""
    strike = [strike_model(POOL)]
    table = [strike[0].surface, table_params(Scene.load('pool_table'))]
    for gates, numbers in ((STRIKE_GATES, strike), (TABLE_GATES, table)):
        for gate in gates:
            off, auto = (Effects(**{gate.name: setting}) for setting in ('off', 'auto'))
            changed = [repr(apply_overrides(each, [gate], off)) != repr(each) for each in numbers]
            assert sum(changed) == 1
            assert [apply_overrides(each, [gate], auto) for each in numbers] == numbers


def test_effects_change_only_numbers_that_there_are():
    """A misspelt name would change nothing, without a word."""
    for gates, kinds in (
        (STRIKE_GATES, [StrikeModel]),
        (TABLE_GATES, [BallClothParams, TableParams]),
    ):
        names = {name for kind in kinds for name in kind._fields}
        for gate in gates:
            assert {*gate.off, *(gate.on or {})} <= names


def test_nothing_was_simulated_in_a_refused_stroke():
    effects = effects_of(predict(POOL, Stroke.from_offsets(0.9, 0.9, 0, 0, 1)))
    assert [effect.name for effect in effects] == NAMES
    assert {effect.reason for effect in effects} == {'the stroke was not played'}
    assert not any(effect.simulated or effect.called_for for effect in effects)


@pytest.mark.parametrize('name', scene_names())
def test_bundled_scenes_leave_it_to_the_gates(name):
    assert Scene.load(name).effects == Effects()


def test_a_ball_that_is_struck_together_with_another_one():
    scene = Scene.from_dict({'like': 'pool', 'balls': {'cue': [0, 0], '1': [0.05715, 0]}})
    found = {each.name: each for each in effects_of(predict(scene, LEVEL))}
    for name in ('cluster', 'ball_ball', 'throw'):
        assert found[name].simulated
        assert found[name].reason.startswith('the ball reaches what is near during the strike')
    off = {each.name: each for each in effects_of(predict(wishing(scene, cluster='off'), LEVEL))}
    assert (off['cluster'].simulated, off['cluster'].called_for) == (False, True)
    assert off['ball_ball'].reason.startswith('balls meet another ball 1 time')


def test_a_cushion_that_the_ball_meets_within_the_strike():
    """The ball is frozen to a cushion; then it meets jaws, but no cushion."""
    scene = Scene.load('pool_table')
    place = -0.3, 0.5 * scene.table.width - scene.ball.radius
    stroke = Stroke.from_offsets(elevation_deg=10, azimuth_deg=80, speed=2)
    found = effect(predict(scene, stroke, position=place), 'cushion')
    assert found.simulated
    assert found.reason == 'the ball reaches what is near during the strike'

"""Shots of simulators, whose strokes are commanded: what they tell of the table and of the cue."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.calibration.calibrate import calibrate
from billiard_shot.calibration.launch import (
    CalibrationModel,
    LEAST_ERRORS,
    LEAST_PLACE_SIGMA,
    PLACES,
    prior_of,
    states_of,
)
from billiard_shot.calibration.recording import Frame, samples_of
from billiard_shot.calibration.simulator import (
    FASTEST,
    recording_of,
    rest_errors,
    SLOWEST,
    without_obstacles,
)
from billiard_shot.scene import Bias, Cushion, Noise
from billiard_shot.scene.player import SPEED

EXACT = Noise(0.0, 0.0, 0.0, 0.0, 0.0)
BIAS = Bias(a=1e-3, azimuth_deg=0.5)
CAROM = replace(Scene.load('carom'), noise=Noise(a=1e-4, b=1e-4, speed=0.03))
NUMBERS = {
    'cloth.sliding_friction': 0.23,
    'table.cushion.friction': 0.2,
    'contacts.cue_ball.restitution': 0.82,
}
PERIOD = 0.05  # s


def simulator(scene, stroke, errors):
    """Play on a table and with a cue whose numbers the player does not know."""
    theirs = scene.with_parameters(list(NUMBERS), list(NUMBERS.values()))
    run = predict(theirs, theirs.noise.perturb(stroke, errors, theirs.ball.radius)).run
    times = np.arange(0.0, run.duration + PERIOD, PERIOD)
    return {
        name: np.column_stack([times, state.position[:, :2]])
        for name, state in run.at(times).items()
    }


@pytest.fixture(scope='module')
def recording():
    return recording_of(simulator, CAROM, shots=10)


def test_shots_of_a_simulator_tell_numbers_of_table_and_cue(recording):
    found = calibrate(recording, CAROM, names=list(NUMBERS), horizon=2.0, held_out=0.2)
    assert found.converged
    for each in found.estimates[: len(NUMBERS)]:
        low, high = each.interval
        assert low < NUMBERS[each.name] < high
        assert not low < each.before < high
    after, before = ([each.rmse() for each in by] for by in (found.checks, found.checks_before))
    assert np.median(after) < 0.2 * np.median(before)


def others(scene, stroke, errors):
    """Play on a table of others: Han's cushions, contacts that take no time, and a plain cue."""
    cushion = Cushion('han', 0.8, height=scene.table.cushion.height, duration=0.0)
    instant = replace(scene.contacts.ball_ball, duration=0.0)
    theirs = replace(
        scene,
        table=replace(scene.table, cushion=cushion),
        effects=replace(scene.effects, shaft='off', flight='off'),
        contacts=replace(scene.contacts, ball_ball=instant),
    )
    return simulator(theirs, stroke, errors)


def test_a_fit_finds_the_models_of_a_simulator():
    """From shots without errors, although those of the player are stated."""
    sought = [*NUMBERS, 'table.cushion.restitution']
    found = calibrate(others, CAROM, names=sought, horizon=2.7, shots=16)
    assert found.converged
    assert found.scene.table.cushion.model == 'han'
    assert found.scene.effects.shaft == found.scene.effects.flight == 'off'
    values = {each.name: each.value for each in found.estimates}
    assert values['cloth.sliding_friction'] == pytest.approx(0.23, rel=0.02)
    assert values['table.cushion.restitution'] == pytest.approx(0.8, rel=0.02)
    after, before = rest_errors(found.checks), rest_errors(found.checks_before)
    assert np.median(after) < 0.2 * np.median(before)
    assert f'median {100.0 * np.median(after):.1f} cm' in ' '.join(found.notes)
    assert found.scene.noise == CAROM.noise
    error = found.scene.model_error
    assert 0.0 < error.speed < 0.03
    assert 0.0 < error.azimuth_deg < 0.1


def blocked(scene, stroke, errors):
    raise ValueError('a ball is in the way of the cue')


@pytest.mark.parametrize(('player', 'length'), [(simulator, 0.0), (blocked, CAROM.cue.length)])
def test_whether_the_cue_of_a_simulator_passes_through_balls_is_tried(player, length):
    scene = without_obstacles(player, CAROM)
    assert (scene.cue.length, scene.balls) == (length, CAROM.balls)


def test_strokes_are_slow_and_fast_and_hit_balls(recording):
    speeds = [shot.stroke.speed for shot in recording.shots]
    assert min(speeds) == pytest.approx(SLOWEST)
    assert max(speeds) == pytest.approx(FASTEST)
    moves = [np.ptp(shot.tracks['1'].place, axis=0).max() > 0.0 for shot in recording.shots]
    assert 3 <= sum(moves) <= 8
    again = recording_of(simulator, CAROM, shots=10)
    assert [shot.stroke for shot in again.shots] == [shot.stroke for shot in recording.shots]


@pytest.mark.parametrize('axis', [False, True])
def test_the_launch_of_a_command_is_that_of_the_stroke_with_its_errors(axis):
    """In a frame that is turned and larger, and with a rounded tip."""
    scene = CAROM.with_parameters(['cue.tip_curvature_radius'], [0.01])
    frame = Frame(0.1, 0.0, 0.4, 1.2)
    stroke = Stroke.from_offsets(0.2, 0.1, 0.1, 0.3, 2.0, axis=axis)
    shot = recording_of(simulator, CAROM, shots=1).shots[0]
    seen = samples_of(replace(shot, stroke=stroke, noise=replace(CAROM.noise, bias=BIAS)))
    launches = np.repeat(prior_of(seen)[0][np.newaxis], 6, axis=0)
    launches[range(1, 6), range(5)] += 1.0
    states = states_of(CalibrationModel(scene, (frame,)), seen, launches)
    sigmas = np.hypot(CAROM.noise.sigmas(CAROM.ball.radius), LEAST_ERRORS)
    biased = np.add(stroke.offsets, [1e-3 / CAROM.ball.radius, 0.0, 0.0, np.radians(0.5), 0.0])
    for row, error in enumerate(np.concatenate([np.zeros((1, 5)), np.diag(sigmas)])):
        offsets = (biased + error).tolist()
        shot = predict(scene, Stroke.from_offsets(*offsets, axis=axis))
        assert states.velocity[row, 0] == pytest.approx(shot.velocity, abs=1e-6)
        assert states.spin[row, 0] == pytest.approx(shot.spin, abs=1e-4)


def test_an_exact_command_leaves_the_launch_what_strikes_of_scenes_err(recording):
    shot = replace(recording.shots[0], noise=EXACT)
    launches = np.zeros((2, PLACES + 4))
    launches[1, SPEED] = 1.0
    states = states_of(CalibrationModel(CAROM, (Frame(),)), samples_of(shot), launches)
    speeds = np.linalg.norm(states.velocity[:, 0], axis=-1)
    assert speeds[1] / speeds[0] == pytest.approx(
        1.0 + LEAST_ERRORS[SPEED] / shot.stroke.speed,
        rel=1e-4,  # normals that move let a strike scale with its speed nearly
    )
    assert samples_of(replace(shot, noise=None)).command is None


def test_the_struck_ball_does_not_lie_elsewhere_if_the_time_of_the_strike_is_known(recording):
    known = samples_of(recording.shots[0])
    estimated = samples_of(replace(recording.shots[0], start=None))
    ahead = known.velocity / np.linalg.norm(known.velocity)
    struck = slice(PLACES, PLACES + 2)
    sigmas = [
        (ahead @ prior_of(seen)[1][struck, struck] @ ahead) ** -0.5 for seen in (known, estimated)
    ]
    assert sigmas[0] == pytest.approx(LEAST_PLACE_SIGMA)
    assert sigmas[1] > 5.0 * LEAST_PLACE_SIGMA
    assert samples_of(replace(recording.shots[0], start=-0.5), rate=2.0).start == -0.25


@pytest.mark.parametrize(
    ('returned', 'said'),
    [
        (None, 'the result of the simulator must be a Mapping, got None'),
        ({'cue': [(0.1, 0, 0)]}, r"simulator must return all balls, got \['cue'\] without 1"),
        (
            {'cue': [(0.1, 0)], '1': []},
            r"'cue' must be \(n, 3\) finite times, x and y, got \(1, 2",
        ),
        ({'cue': [(0.2, 0, 0), (0.1, 0, 0)]}, "times of ball 'cue' must ascend"),
    ],
)
def test_a_simulator_that_returns_something_else_is_refused(returned, said):
    with pytest.raises(ValueError, match=said):
        calibrate(lambda *_: returned, CAROM)


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        ({'scene': None}, 'scene must be given for a simulator, got None'),
        ({'scene': replace(CAROM, table=None, balls={})}, 'scene must have a table'),
        ({'seed': -1}, 'seed must be a whole number'),
    ],
)
def test_requests_that_make_no_sense_are_refused(change, said):
    with pytest.raises(ValueError, match=said):
        calibrate(simulator, **{'scene': CAROM, **change})

"""Maps of the strike agree with exact strikes, and are used only where they do."""

from layouts import cloth_with, problem, table_with
import numpy as np
import pytest

from billiard_shot import predict_batch, predict_within_noise, Scene, Status
from billiard_shot.planning.runner import evaluate_strokes, penalties_of, simulate_strokes
from billiard_shot.planning.within_noise import (
    bounds_of,
    CLOUD_STRIKES,
    DEVIATION_SHARE,
    FEWEST,
    fit_box,
    Maps,
    STRICT_SHARE,
    strike_alone,
    TRIALS,
)
from billiard_shot.scene import Noise
from billiard_shot.scene.player import NOISES
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.play import alone, play_strokes, solve_strikes, task_of
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.run.task import run_tables
from billiard_shot.table.strike.placement import FARTHEST, SOLVED

SCENE = Scene.load('blocked')
NOISE = NOISES['tournament']
POT = problem(SCENE, {'pot': '8'})


def mapped(scene, strokes, sigmas, *, strict=False, each=1, **options):
    maps = Maps(model_of(scene), bounds_of(sigmas), **options)

    def fit(boxes):
        return [fit_box(maps.model, box) for box in boxes]

    return maps.mapped(strokes, fit, strict=strict, each=each)


def cloud(centre, count, seed=1):
    draws = np.random.default_rng(seed).standard_normal((count, 5))
    return np.array(centre) + draws * POT.sigmas


@pytest.mark.parametrize('share', [DEVIATION_SHARE, STRICT_SHARE])
@pytest.mark.parametrize(
    'centre',
    [
        (0.1, -0.1, 0.07, 1.0, 2.0),
        (-0.2, 0.15, 0.1, -2.0, 0.7),
        (0.0, 0.0, 0.3, 3.0, 6.0),
        (0.0, 0.35, 0.03, 0.5, 2.0),  # the cloth begins or ceases to take part here
    ],
)
def test_maps_agree_with_exact_strikes(centre, share):
    """At any azimuth and speed, for both signs of a, to a small part of the player's errors."""
    strokes = cloud(centre, 400)
    found = mapped(SCENE, strokes, POT.sigmas, strict=share == STRICT_SHARE)
    model = model_of(SCENE)
    radius = model.surface.radius
    there = found.number != SOLVED
    assert there.mean() > 0.9
    exact = solve_strikes(model, *vectors_of(strokes), 1e-4)
    task = task_of(alone(model), *vectors_of(strokes), None, TRIALS, mapped=found)
    cues = run_tables(task._replace(until=0.0)).cues
    assert (cues['status'] == exact['status']).all()
    assert ((cues['steps'] == 0) == there).all()
    limits = share / DEVIATION_SHARE * bounds_of(POT.sigmas)
    for name, scale, limit in (('velocity', 1.0, limits[:3]), ('spin', radius, limits[3:6])):
        error = scale * (cues[name] - exact[name])[there] / strokes[there, 4:]
        sin, cos = np.sin(strokes[there, 3]), np.cos(strokes[there, 3])
        x, y, z = error.T
        error = np.stack([cos * x + sin * y, cos * y - sin * x, z])
        assert (np.sqrt((error**2).mean(axis=1)) < 1.5 * limit).all()  # held out: `limit`
    assert cues['axis'][there] == pytest.approx(exact['axis'][there], abs=1e-12)
    assert cues['tip'][there] == pytest.approx(exact['tip'][there], abs=2e-3)  # where it touched
    error = (cues['speed'] - exact['speed'])[there] / strokes[there, 4]
    assert np.sqrt((error**2).mean()) < 1.5 * limits[6]
    assert cues['end'][there] == pytest.approx(exact['end'][there], rel=1e-2)


def test_miscues_are_never_mapped():
    strokes = cloud((0.56, 0.0, 0.1, 0.0, 2.0), 400)
    assert (mapped(SCENE, strokes, POT.sigmas).number == SOLVED).all()


def test_few_strokes_fast_ones_and_players_without_errors_are_not_mapped():
    strokes = np.tile((0.05, 0.05, 0.1, 0.0, 2.0), (4 * FEWEST, 1))
    sigmas = POT.sigmas
    assert (mapped(SCENE, strokes, sigmas).number != SOLVED).all()
    assert (mapped(SCENE, strokes[: FEWEST - 1], sigmas).number == SOLVED).all()
    assert (mapped(SCENE, strokes, sigmas, slower_than=1.9).number == SOLVED).all()
    assert (mapped(SCENE, np.full((4 * FEWEST, 5), np.nan), sigmas).number == SOLVED).all()
    assert (mapped(SCENE, strokes, sigmas).number != SOLVED).all()
    strokes[:, 4] = 1e9
    assert (mapped(SCENE, strokes, sigmas).number == SOLVED).all()
    assert not Maps(model_of(SCENE), bounds_of(np.zeros(5))).applies


def test_success_of_mapped_strokes_is_that_of_exact_ones():
    asked = problem(SCENE, {'pot': '8'}, Noise())
    strokes = cloud((0.0, 0.0, 0.1, 0.2, 2.0), 2000)
    strokes[:, 3] += np.linspace(-0.3, 0.3, len(strokes))
    found = mapped(SCENE, strokes, asked.sigmas)
    assert (found.number != SOLVED).any()
    exact = evaluate_strokes(asked, strokes)
    fast = evaluate_strokes(asked, strokes, found)
    assert (exact.success != fast.success).mean() < 0.01


MASSE, JUMP = (0.29, -0.29, 1.31, 0.0, 2.8), (-0.28, -0.33, 0.66, 0.0, 4.4)


@pytest.mark.parametrize('centre', [MASSE, JUMP])
def test_the_cloud_of_a_steep_stroke_has_a_map_of_its_own(centre):
    """Without errors of the azimuth, the path scatters as that of exact strikes, to 4 %."""
    strokes, sigmas = cloud(centre, 400), POT.sigmas
    strokes[:, 3] = 0.0
    found = mapped(SCENE, strokes, sigmas, each=400)
    assert (found.number != SOLVED).all()
    model = alone(model_of(SCENE))
    task = task_of(model, *vectors_of(strokes), None, TRIALS)
    exact = run_tables(task).balls['position'][:, 0, :2]
    task = task_of(model, *vectors_of(strokes), None, TRIALS, found)
    fast = run_tables(task).balls['position'][:, 0, :2]
    held_out = slice(CLOUD_STRIKES, None)
    error = (fast - exact)[held_out]
    assert (error.var(axis=0) < DEVIATION_SHARE**2 * exact.var(axis=0)).all()
    assert (mapped(SCENE, strokes, sigmas, strict=True, each=400).number == SOLVED).any()


def test_in_a_cloud_with_failures_their_neighbours_are_solved():
    strokes = cloud((0.42, 0.2, 1.2, 0.0, 2.0), 400)  # few fail
    fails = strike_alone(model_of(SCENE), strokes).fails
    solved = mapped(SCENE, strokes, POT.sigmas, each=400).number == SOLVED
    own = slice(CLOUD_STRIKES)
    assert fails[own].any()
    assert solved[own][fails[own]].all()
    assert solved.mean() < 0.4
    assert fails[~solved].mean() < 0.02 < 0.1 < fails[solved].mean()


def test_a_cloud_in_which_most_strikes_fail_is_solved():
    strokes = cloud((0.2, -0.45, 1.2, 0.0, 2.0), 400)
    assert (mapped(SCENE, strokes, POT.sigmas, each=400).number == SOLVED).all()


def test_strokes_among_near_balls_are_mapped_if_they_reach_none():
    gap = 0.01
    balls = {'cue': (0.0, 0.0), '8': (2.0 * SCENE.ball.radius + gap, 0.0)}
    scene = Scene.from_dict({'like': 'pool_table', 'balls': balls})
    near = problem(scene, {'hit': '8'})
    limit = near.prepared.reaching
    assert limit == pytest.approx(gap / (FARTHEST * SCENE.contacts.cue_ball.duration))
    strokes = cloud((0.0, 0.0, 0.1, 0.0, limit), 400)
    found = mapped(scene, strokes, near.sigmas, slower_than=limit)
    fast = strokes[:, 4] >= limit
    assert (found.number[fast] == SOLVED).all()
    assert (found.number[~fast] != SOLVED).mean() > 0.9  # but for those in cells with few strokes
    careless = mapped(scene, strokes, near.sigmas)
    assert (careless.number[fast] != SOLVED).mean() > 0.5
    exact = play_strokes(scene, *vectors_of(strokes), accuracy=TRIALS)
    for each in (found, careless):  # who reaches others is solved in any case
        fast = play_strokes(scene, *vectors_of(strokes), accuracy=TRIALS, mapped=each)
        assert (fast.mapped == (strokes[:, 4] < limit)).all()
        assert (fast.status == exact.status).all()
        assert np.abs(fast.velocity - exact.velocity).max() < bounds_of(near.sigmas)[0]


def test_an_early_end_never_makes_a_success():
    """Runs that end when a ball has missed lose flukes, and nothing else."""
    asked = POT
    strokes = cloud((0.0, 0.0, 0.1, 0.2, 4.0), 1000)
    strokes[:, 3] += np.linspace(-0.5, 0.5, len(strokes))
    full = evaluate_strokes(asked, strokes)
    early = evaluate_strokes(asked, strokes, to_the_end=False)
    assert not (early.success & ~full.success).any()
    assert (full.success & ~early.success).mean() < 0.03


def test_a_trial_that_failed_in_the_strike_ends_there():
    """Success is that of complete runs; a stroke that failed takes no time."""
    asked = problem(SCENE, {'pot': '8'}, Noise())
    draw = np.random.default_rng(2)
    strokes = draw.uniform((-0.6, -0.6, 0.1, -0.2, 1.0), (0.6, 0.6, 1.3, 0.6, 4.0), (600, 5))
    full, usable = simulate_strokes(asked, strokes)
    ended, _ = simulate_strokes(asked, strokes, rules=asked.rules)
    failed = usable & (full.cues['miscue'] | full.tables['double_hit'])
    success = usable & (penalties_of(asked, full) == 0.0)
    assert (success == (usable & (penalties_of(asked, ended) == 0.0))).all()
    assert not (success & failed).any()
    in_strike = usable & (full.cues['double_hit'] == 0.0)
    assert in_strike.sum() > 20
    assert (ended.tables['duration'][in_strike | full.cues['miscue']] == 0.0).all()
    assert (ended.tables['duration'] <= full.tables['duration']).all()


# --- strokes at the accuracy of the noise: the same shares as exact strokes, the same refusals


def sampled(scene, planned, count, seed):
    """Strokes as a player executes them."""
    draw = np.random.default_rng(seed)
    return scene.noise.sample(planned, count, draw, scene.ball.radius).reshape(-1, 5)


@pytest.mark.parametrize(
    'others', [{}, {'b1': (0.75, 0.33), 'b2': (0.4, -0.3), 'b3': (-0.7, 0.4)}]
)
def test_shares_of_many_strokes_are_those_of_exact_strokes(others):
    scene = table_with(cue=(0.1, 0.1), b8=(0.8, 0.27), **others)
    planned = [(0.0, b, 0.06, azimuth, 1.8) for b in (-0.3, 0.0, 0.3) for azimuth in (0.2, 0.24)]
    offsets = sampled(scene, planned, 120, 1)
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    assert fast.mapped.mean() > 0.9
    assert (exact.status == Status.OK).mean() > 0.95
    one, other = fast, exact
    assert one.names == other.names
    share = np.abs(
        (one.pocket >= 0).reshape(6, 120, -1).mean(axis=1)
        - (other.pocket >= 0).reshape(6, 120, -1).mean(axis=1)
    )
    assert share.max() < 0.08
    met = one.first_met[:, 0] == other.first_met[:, 0]
    assert met.mean() > 0.95
    apart = np.linalg.norm(fast.velocity - exact.velocity, axis=1)
    assert np.quantile(apart, 0.95) < 0.01 * 2.4  # m/s; the noise of the speed is 0.09
    rest = np.linalg.norm(one.final_position[:, 0] - other.final_position[:, 0], axis=1)
    assert np.median(rest) < 0.03


def test_refusals_are_those_of_exact_strokes():
    scene = table_with(cue=(-1.15, 0.1), b8=(0.8, 0.27), b1=(-1.1, 0.4))
    draw = np.random.default_rng(2)
    offsets = np.column_stack(
        [
            draw.uniform(-0.75, 0.75, (300, 2)),
            draw.uniform(-0.1, 0.4, 300),
            draw.uniform(-3.1, 3.1, 300),
            draw.uniform(0.5, 3.0, 300),
        ]
    )
    offsets[:2] = np.nan
    offsets[2:400:9, 4] = -1.0
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    refused = exact.refused
    assert refused.any()
    assert not refused.all()
    assert (fast.status[refused] == exact.status[refused]).all()
    assert not fast.refused[~refused].any()
    assert exact.miscue.any()
    assert (fast.miscue == exact.miscue).all()
    assert not exact.miscue[refused].any()
    assert len(np.unique(exact.status)) >= 4


def test_without_errors_every_strike_is_solved():
    scene = table_with(cue=(0.1, 0.1), b8=(0.8, 0.27))
    offsets = sampled(scene, (0.0, 0.1, 0.06, 0.2, 1.8), 200, 3)
    none = predict_within_noise(scene, offsets, noise=Noise(0.0, 0.0, 0.0, 0.0, 0.0))
    assert not none.mapped.any()
    exact = predict_batch(scene, offsets=offsets, tolerance=1e-3)
    assert np.allclose(none.velocity, exact.velocity, atol=1e-3)
    assert predict_within_noise(scene, np.zeros((0, 5))).status.shape == (0,)
    with pytest.raises(ValueError, match=r'offsets must be of shape \(n, 5\), got \(5,\)'):
        predict_within_noise(scene, offsets[0])


def test_a_cloth_without_a_table_will_do():
    scene = cloth_with(cue=(0.0, 0.0), b1=(0.5, 0.01))
    offsets = sampled(scene, (0.0, 0.1, 0.06, 0.0, 1.0), 200, 4)
    fast, exact = predict_within_noise(scene, offsets), predict_batch(scene, offsets=offsets)
    assert (fast.first_met[:, 0] == exact.first_met[:, 0]).mean() > 0.98
    assert Scene.load('pool').noise == scene.noise

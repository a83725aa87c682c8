"""plan(): it reaches its targets, says how surely, and is the same again."""

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
import math
import pickle
import re

from layouts import problem, table_with
import numpy as np
import pytest

from billiard_shot import plan, predict, predict_batch, Scene, Status, Stroke
from billiard_shot.planning import search
from billiard_shot.planning.problem import limits_of, raise_for_clearance
from billiard_shot.planning.runner import CHUNK, evaluate_strokes, LARGEST_CHUNK, Runner
from billiard_shot.planning.search import LEAST_TRIALS
from billiard_shot.planning.stages import GOOD, KINDS, next_stage
from billiard_shot.planning.statistics import (
    chance_in_words,
    interval_in_words,
    quasi_random,
    wilson_interval,
)
from billiard_shot.planning.targets import target_of
from billiard_shot.scene.player import AZIMUTH, B, Bias, ELEVATION, NOISES, SPEED
from billiard_shot.shot.lowest_elevation import refusals_in
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.run.results import POCKET_NAMES

SCENE = table_with(cue=(-0.4, 0), b8=(0.5, 0.2), b1=(0.2, -0.3))
BUDGET = 4000


def reached(scene, target, shot):
    """Whether a target is reached, found from the prediction alone."""
    run, path = shot.run, shot.trajectory
    if 'cue' in run.pocketed or run.off_table:
        return False
    if 'pot' in target:
        into = run.pocketed.get(target['pot'])
        allowed = target.get('pocket', 'any')
        good = into is not None and allowed in ('any', into)
        if 'leave' in target:
            good &= np.hypot(*(path.final_position[:2] - target['leave'])) <= target['radius']
        return good
    if 'rest' in target:
        return np.hypot(*(path.final_position[:2] - target['rest'])) <= target['radius']
    places = path.at(np.linspace(0, path.duration, 20000)).position
    if 'pass' in target:
        return np.hypot(*(places[:, :2] - target['pass']).T).min() <= target['radius'] + 1e-3
    if 'gate' in target:  # these here are upright
        (x, low), (_, high) = target['gate']
        cross = np.flatnonzero(np.diff(places[:, 0] > x))
        return ((places[cross, 1] > low) & (places[cross, 1] < high)).any()
    if run.first_met.get('cue') != target['hit']:
        return False
    time = next(e.time for e in run.events if 'cue' in e.balls and len(e.balls) > 1)
    ball = scene.balls[target['hit']]
    if 'direction' in target:
        away = run.balls[target['hit']].at(time).velocity[:2]
        angle = np.arctan2(*away[::-1]) - np.arctan2(*target['direction'][::-1])
        return abs((angle + np.pi) % (2 * np.pi) - np.pi) < np.radians(5.0)
    if 'at' in target:
        there = path.at(time).position[:2] - ball
        touched = ball + scene.ball.radius * there / np.hypot(*there)
        wanted = np.array(target['at']) - ball
        wanted = ball + scene.ball.radius * wanted / np.hypot(*wanted)
        return np.hypot(*(touched - wanted)) <= 0.0051
    return True


TARGETS = [
    {'pot': '8', 'pocket': 'any'},
    {'pot': '8', 'pocket': 'foot_left'},
    {'pot': '8', 'leave': (0.6, 0.0), 'radius': 0.4},
    {'rest': (0.3, 0.3), 'radius': 0.15},
    {'pass': (0.3, 0.3), 'radius': 0.03},
    {'gate': ((0.3, 0.3), (0.3, 0.4))},
    {'hit': '8'},
    {'hit': '8', 'direction': (1.0, 0.3)},
    {'hit': '8', 'at': (0.46, 0.2)},
]


@pytest.mark.parametrize('target', TARGETS, ids=lambda target: ' '.join(target))
def test_every_target_is_reached(target):
    result = plan(SCENE, target, noise='tournament', budget=BUDGET, seed=1)
    assert result.status == Status.OK
    best = result.best
    assert best is result.ranking[0]
    low, high = best.interval
    assert 0.0 < low <= best.success <= high <= 1.0
    assert result.simulations <= BUDGET
    assert not any(each.shot.status.refused for each in result.ranking)
    # played with fresh errors, it does as well as it says
    draw, trials = np.random.default_rng(99), 150
    hits = sum(
        reached(
            SCENE,
            target,
            predict(SCENE, result.noise.perturb(best.stroke, draw, SCENE.ball.radius)),
        )
        for _ in range(trials)
    )
    least, most = wilson_interval(hits, trials, 3.5)
    assert least <= high
    assert most >= low


def test_the_same_seed_gives_the_same_plan_whatever_plays_it():
    target = {'pot': '8', 'pocket': 'any'}
    one = plan(SCENE, target, budget=3000, seed=5)
    with ThreadPoolExecutor(1) as alone:
        two = plan(SCENE, target, budget=3000, seed=5, executor=alone)
    assert [r.stroke for r in one.ranking] == [r.stroke for r in two.ranking]
    assert [r.success for r in one.ranking] == [r.success for r in two.ranking]
    assert one.simulations == two.simulations
    other = plan(SCENE, target, budget=3000, seed=6)
    assert other.best.stroke != one.best.stroke


@pytest.mark.parametrize('budget', [1, 3, 10, 50, 200, 1000])
def test_never_more_than_the_budget(budget):
    result = plan(SCENE, {'pot': '8'}, budget=budget)
    assert result.simulations <= budget
    assert result.status in (Status.OK, Status.NO_PLAN)
    assert (result.best is None) == (result.status == Status.NO_PLAN)


def test_cancel_gives_the_best_so_far():
    asked = []

    def cancel():
        asked.append(1)
        return len(asked) > 5

    result = plan(SCENE, {'hit': '8'}, cancel=cancel)
    assert result.status == Status.CANCELLED
    assert len(asked) == 6
    assert result.simulations < 6 * LARGEST_CHUNK
    late = []

    def cancel_late():
        late.append(1)
        return len(late) > 400

    known = plan(SCENE, {'pot': '8', 'pocket': 'foot_left'}, cancel=cancel_late)
    assert known.status in (Status.CANCELLED, Status.OK)  # it may have been done by then
    assert 1 <= len(known.ranking) <= 4
    at_once = plan(SCENE, {'hit': '8'}, cancel=lambda: True)
    assert (at_once.status, at_once.best, at_once.simulations) == (Status.CANCELLED, None, 0)


def test_progress_goes_up_to_the_end():
    seen = []
    result = plan(SCENE, {'hit': '8'}, budget=2000, progress=seen.append)
    counts = [each.simulations for each in seen]
    assert counts == sorted(counts)
    assert counts[-1] == result.simulations
    assert max(np.diff(counts)) <= LARGEST_CHUNK
    assert seen[-1].budget == 2000
    assert 0.0 <= seen[-1].success <= 1.0


@pytest.mark.parametrize(
    ('changes', 'named'),
    [
        ({'target': {'pot': '9'}}, "pot must be one of 8, 1, got '9'"),
        ({'target': {'pot': 'cue'}}, "pot must .*, got 'cue'"),
        ({'target': {'rest': (3, 0)}}, 'rest must be on the table'),
        ({'target': {'rest': (0.5, 0.2)}}, "rest must be .* from ball '8', got"),
        ({'target': {'pot': '8', 'leave': (0.2, -0.3)}}, "leave must be .* from ball '1', got"),
        (
            {'target': {'pot': '8', 'pocket': 'middle'}},
            "pocket must be .*foot_left.*, got 'middle'",
        ),
        ({'target': {'sink': '8'}}, 'must be a mapping with one of the keys'),
        ({'target': {'pot': '8', 'rest': (0, 0)}}, 'one of the keys'),
        (
            {'target': {'hit': '8', 'directon': (1, 0)}},
            'directon is unknown; the nearest key is direction',
        ),
        ({'target': {'hit': '8', 'direction': (0, 0)}}, 'direction must not be zero'),
        ({'target': {'gate': (1, 2)}}, r'gate must be two points, .*, got \(1, 2\) \(m\)'),
        ({'target': 'win'}, 'mapping'),
        ({'budget': 0}, r'budget must .*, got 0'),
        ({'budget': 2.5}, 'budget'),
        ({'seed': -1}, r'seed must .*, got -1'),
        ({'noise': 'loud'}, "noise must be .*tournament.*, got 'loud'"),
        ({'noise': {'a': -1}}, 'noise: a'),
        (
            {'constraints': {'speed_min': 3, 'speed_max': 2}},
            'speed_max must be at least speed_min, 3, got 2',
        ),
        ({'constraints': {'speed': 2}}, 'speed is unknown'),
        ({'constraints': 5}, 'constraints must be a Mapping, got 5'),
        ({'target': {'pot': '8', 'pocket': 5}}, 'pocket must be .*, got 5'),
        ({'target': {'pot': '8', 'pocket': [['any']]}}, 'pocket must be .*, got .*'),
        ({'constraints': {'first_contact': '7'}}, "first_contact must be one of .*, got '7'"),
    ],
)
def test_a_bad_goal_is_refused_with_what_to_change(changes, named):
    goal = {'target': {'pot': '8'}, 'noise': 'tournament', 'budget': 100, **changes}
    with pytest.raises(ValueError, match=named):
        plan(SCENE, **goal)


def test_any_in_a_list_is_any():
    assert target_of(SCENE, {'pot': '8', 'pocket': ['any']}) == target_of(SCENE, {'pot': '8'})


def test_numbers_of_numpy_are_numbers():
    numbers = {'budget': np.int64(100), 'seed': np.int32(1), 'seconds': np.float32(60)}
    expected = plan(SCENE, {'hit': '8'}, budget=100, seed=1)
    assert plan(SCENE, {'hit': '8'}, **numbers).best.stroke == expected.best.stroke


def test_limits_that_leave_no_stroke():
    with pytest.raises(ValueError, match=r'elevation_max_deg must be at least .*, got 1 '):
        plan(
            table_with(cue=(-1.2, 0), b8=(0, 0)),
            {'pot': '8'},
            constraints={'elevation_max_deg': 1, 'azimuth_half_range_deg': 30},
        )


def test_constraints_hold_for_the_plan():
    limits = {
        'speed_max': 1.2,
        'offset_max': 0.2,
        'elevation_min_deg': 8.0,
        'azimuth_deg': 10.0,
        'azimuth_half_range_deg': 15.0,
    }
    result = plan(SCENE, {'pot': '8'}, budget=BUDGET, constraints=limits)
    assert result.status == Status.OK
    for each in result.ranking:
        a, b, elevation, azimuth, speed = each.stroke.offsets
        assert np.hypot(a, b) <= 0.2 + 1e-9
        assert np.degrees(elevation) >= 8.0 - 1e-9
        assert abs(np.degrees(azimuth) - 10.0) <= 15.0 + 1e-9
        assert speed <= 1.2 + 1e-9


def test_first_contact_is_legal():
    """The 8 could be potted at once; if the 1 has to be met first, another way is found."""
    scene = table_with(cue=(0, -0.3), b8=(0.5, 0.2), b1=(0.1, 0.03))
    free = plan(scene, {'pot': '8'}, budget=BUDGET)
    bound = plan(scene, {'pot': '8'}, budget=BUDGET, constraints={'first_contact': '1'})
    assert free.best.shot.run.first_met['cue'] == '8'
    for each in bound.ranking:
        assert each.shot.run.first_met['cue'] == '1'


def test_a_ball_that_is_met_during_the_strike_is_met_first():
    """The 1 lies in front of the cue ball, in touch or a tenth of a millimetre away."""
    stroke, noise = Stroke.from_offsets(0.0, 0.1, np.radians(8), 0.0, 2.0), NOISES['none']
    for gap in (0.0, 1e-4):
        scene = table_with(cue=(0, 0), b1=(2.0 * SCENE.ball.radius + gap, 0), b8=(0.5, 0.01))
        assert predict(scene, stroke).first_contact == '1'
        for ball, success in (('1', True), ('8', False)):
            hits = problem(scene, {'hit': ball}, noise)
            outcomes = evaluate_strokes(hits, np.array([stroke.offsets]))
            assert outcomes.success.tolist() == [success]


def test_a_goal_that_cannot_be_reached_is_no_plan():
    """A ball in the ring of six others cannot be hit first by a cue that stays low."""
    ring = {
        f'b{i}': (0.5 + 0.0572 * np.cos(i * np.pi / 3), 0.0572 * np.sin(i * np.pi / 3))
        for i in range(1, 7)
    }
    result = plan(
        table_with(cue=(-0.5, 0), b9=(0.5, 0), **ring),
        {'hit': '9'},
        budget=1500,
        constraints={'elevation_max_deg': 5},
    )
    assert result.status == Status.NO_PLAN
    assert result.best is None
    assert 'no stroke' in result.message


def test_raised_cues_have_room_for_their_errors():
    scene = table_with(cue=(-1.1, 0.3), b8=(-0.9, 0.3), b1=(-1.1, -0.2))
    limits = limits_of(scene, None, NOISES['tournament'])
    draw = np.random.default_rng(1)
    strokes = np.zeros((200, 5))
    strokes[:, :2] = draw.uniform(-0.35, 0.35, (200, 2))
    strokes[:, AZIMUTH], strokes[:, SPEED] = draw.uniform(-np.pi, np.pi, 200), 1.0
    found = raise_for_clearance(scene, limits, strokes)
    assert np.isfinite(found).all()
    for change, status in ((0.0, True), (-0.3, True), (-1.2, False)):
        lower = found.copy()
        lower[:, ELEVATION] += np.radians(change)
        normals, velocities = vectors_of(lower)
        room = refusals_in(scene, normals, velocities) < Status.MISS
        room &= lower[:, ELEVATION] >= 0.0
        assert room.all() if status else room.mean() < 0.3
    assert (found[:, B] == strokes[:, B]).all()


@pytest.mark.parametrize('gap', [0.001, 0.03])
def test_strokes_with_errors_have_room_beside_a_cushion(gap):
    """A low tip lowers the cue over the cushion as much as a low cue does."""
    half = 0.5 * SCENE.table.length - SCENE.ball.radius
    scene, noise = table_with(cue=(gap - half, 0.2), b8=(0.5, 0.2)), NOISES['tournament']
    draw = np.random.default_rng(3)
    strokes = np.zeros((200, 5))
    strokes[:, :2] = draw.uniform(-0.3, 0.3, (200, 2))
    strokes[:, AZIMUTH], strokes[:, SPEED] = draw.uniform(-1.2, 1.2, 200), 1.0
    raised = raise_for_clearance(scene, limits_of(scene, None, noise), strokes)
    assert np.isfinite(raised).all()
    played = noise.sample(raised, 25, draw).reshape(-1, 5)
    assert (refusals_in(scene, *vectors_of(played)) != Status.OK).mean() < 0.003


def test_a_problem_can_be_sent_to_another_process():
    pots = problem(SCENE, {'pot': '8'})
    again = pickle.loads(pickle.dumps(pots))
    assert again.names == pots.names == ('cue', '8', '1')
    assert again.target == pots.target
    assert [POCKET_NAMES[i] for i in again.pockets] == list(POCKET_NAMES)


def test_without_a_table():
    """An endless cloth: still a place to come to rest, or a ball to hit."""
    data = Scene.load('pool').to_dict()
    data['balls'] = {'cue': (0, 0), '3': (0.6, 0.1)}
    scene = Scene.from_dict(data)
    assert plan(scene, {'rest': (1.0, 0.5)}, budget=BUDGET).status == Status.OK
    assert plan(scene, {'hit': '3', 'direction': (1, 0)}, budget=BUDGET).best.success > 0.9
    with pytest.raises(ValueError, match='needs a table with pockets'):
        plan(scene, {'pot': '3'})


def test_chances_are_told_from_certainty():
    """100 % is never said, and an interval never shrinks to one number."""
    assert chance_in_words(1.0, 200) == 'in 200 of 200 trials'
    assert chance_in_words(14 / 15, 15) == 'in 14 of 15 trials'
    assert chance_in_words(0.999, 2000) == '99.9 %'
    assert chance_in_words(0.0, 200) == '0 %'
    assert interval_in_words(wilson_interval(200, 200)) == '95 % CI 98 to 100 %'
    assert interval_in_words(wilson_interval(20000, 20000)) == '95 % CI 99.98 to 100 %'
    assert interval_in_words(wilson_interval(170, 200)) == '95 % CI 79 to 89 %'
    assert interval_in_words(wilson_interval(0, 200)).startswith('95 % CI 0 to 2 ')


@pytest.mark.parametrize('dimensions', [1, 3, 5])
def test_quasi_random_points_fill_the_cube_evenly(dimensions):
    points = quasi_random(1000, dimensions)
    assert points.shape == (1000, dimensions)
    for column in points.T:
        assert np.ptp(np.histogram(column, 20, (0, 1))[0]) <= 12  # of random ones: some 25
    halves = (points > 0.5) @ 2 ** np.arange(dimensions)
    shares = np.bincount(halves, minlength=2**dimensions) / 1000
    assert shares == pytest.approx(np.full(2**dimensions, 0.5**dimensions), abs=0.012)
    assert quasi_random(10, dimensions, skip=990) == pytest.approx(points[990:], abs=1e-9)


def test_plans_say_what_they_are():
    result = plan(SCENE, {'pot': '8'}, budget=BUDGET)
    assert repr(result).startswith(f'PlanResult(OK: {result.message}; strokes: ')
    assert repr(result.best).startswith(f'RankedStroke({result.best.kind}: success ')
    assert len(repr(result)) < 200


def test_plans_say_what_to_command_to_a_player_with_a_bias():
    scene = Scene.load(SCENE)
    biased = replace(scene.noise, bias=Bias(azimuth_deg=0.5, speed=0.1))
    unbiased, corrected = (
        plan(SCENE, {'pot': '8'}, noise, budget=BUDGET).best for noise in (None, biased)
    )
    assert unbiased.command == unbiased.stroke == corrected.stroke
    away = np.array(corrected.stroke.offsets) - corrected.command.offsets
    assert away == pytest.approx([0.0, 0.0, 0.0, math.radians(0.5), 0.1])


def test_plans_for_pandas():
    pytest.importorskip('pandas', reason='needs pandas, an extra')
    result = plan(SCENE, {'pot': '8'}, budget=BUDGET)
    frame = result.to_frame()
    assert frame['success'].tolist() == [each.success for each in result.ranking]
    assert frame.loc[0, 'speed'] == result.best.stroke.speed
    assert frame.loc[0, 'azimuth_deg'] == math.degrees(result.best.stroke.offsets[3])


def test_several_balls_share_one_search():
    """More balls never make the result worse than that of the best of them alone."""
    alone = [plan(SCENE, {'pot': ball}, seed=2).best for ball in ('8', '1')]
    both = plan(SCENE, {'pot': ['8', '1']}, seed=2).best
    every = plan(SCENE, {'pot': 'any'}, seed=2).best
    for best in (both, every):
        assert best.interval[1] >= max(each.interval[0] for each in alone)


def test_balls_to_keep_stay():
    """The 1 stands before a pocket on the way of the 8: without it, both fall at times."""
    kept = plan(SCENE, {'pot': 'any'}, constraints={'keep': '8'}, budget=BUDGET)
    assert kept.status == Status.OK
    for each in kept.ranking:
        assert '8' not in each.shot.run.pocketed
    with pytest.raises(ValueError, match='keep'):
        plan(SCENE, {'pot': '8'}, constraints={'keep': ['8']}, budget=500)


def test_one_of_several_balls_is_met_first():
    bound = plan(SCENE, {'pot': '8'}, budget=BUDGET, constraints={'first_contact': ['1', '8']})
    free = plan(SCENE, {'pot': '8'}, budget=BUDGET)
    assert bound.best.interval[1] >= free.best.interval[0]
    assert bound.best.shot.run.first_met['cue'] in ('1', '8')


def test_the_time_ends_the_search():
    target = {'pot': '8', 'leave': (0.6, 0.0), 'radius': 0.05}
    short = plan(SCENE, target, seconds=0.02)
    assert short.simulations < plan(SCENE, target, budget=8000).simulations
    assert short.status in (Status.OK, Status.NO_PLAN)
    if short.status == Status.NO_PLAN:
        assert 'until the time was up' in short.message or not short.simulations
    for wrong in (0, -1.0, 'soon', float('nan'), float('inf')):
        with pytest.raises(ValueError, match='seconds'):
            plan(SCENE, target, seconds=wrong)


def test_a_time_longer_than_any_search_is_none():
    target = {'rest': (0.3, 0.2), 'radius': 0.1}
    assert plan(SCENE, target, budget=100, seconds=1e308).status is Status.OK


def test_a_search_that_ends_early_says_what_it_did_not_try():
    asked = {'pot': '8', 'leave': (-1.0, 0.5), 'radius': 0.01}
    ended = plan(SCENE, asked, budget=60)
    assert re.search('not tried: .*two cushions', ended.message)
    polls = iter(range(10**6))
    cancelled = plan(SCENE, asked, cancel=lambda: next(polls) > 3)
    assert cancelled.status is Status.CANCELLED
    assert 'not tried: ' in cancelled.message
    assert 'not tried' not in plan(SCENE, {'hit': '8'}, budget=3000).message


def test_a_few_samples_do_not_move_a_stroke_that_has_succeeded():
    """All four samples of 27 strokes that reached the target missed it, and all were moved."""
    scene = table_with(cue=(-0.31035625, -0.1010708333333333), b8=(0.5, 0.2))
    for seed in (2, 29):
        best = plan(scene, {'pot': '8'}, budget=500, seed=seed).best
        assert best is not None
        assert best.interval[0] > 0.5


def test_a_wide_interval_is_not_converged():
    for budget in (200, 4000):
        result = plan('blocked', {'pot': '8'}, budget=budget)
        low, high = result.ranking[0].interval
        assert high - low <= 0.1 or not result.converged


def test_a_time_before_the_first_stroke_says_so():
    none = plan(SCENE, {'pot': '8'}, seconds=1e-9)
    assert (none.status, none.simulations) == (Status.NO_PLAN, 0)
    assert none.message.startswith('seconds: the time was up before a stroke was tried')


def test_a_miscue_reaches_no_target():
    scene, noise = table_with(cue=(0.0, 0.0)), NOISES['none']
    rests = problem(scene, {'rest': (0.0, 0.0), 'radius': 2.0}, noise)
    strokes = np.array([(0.2, 0.0, 0.1, 0.0, 1.0), (0.8, 0.0, 0.1, 0.0, 1.0)])
    outcomes = evaluate_strokes(rests, strokes)
    assert outcomes.success.tolist() == [True, False]


def test_finalists_have_as_many_trials_as_their_intervals_need():
    for target in ({'hit': '8'}, {'pot': '8', 'pocket': 'foot_left'}):
        best, *others = plan(SCENE, target).ranking
        assert others, 'this layout cannot show the order'
        assert best.interval[1] - best.interval[0] < 0.07
        assert all(each.interval[1] - each.interval[0] < 0.14 for each in others)
        lows = [each.interval[0] for each in others]
        assert lows == sorted(lows, reverse=True)


def test_the_trials_that_state_the_success_do_not_choose_the_stroke(monkeypatch):
    """A stroke that was chosen because these trials went well succeeds less often than stated."""
    target, play = {'hit': '8'}, search._trials
    usual = plan(SCENE, target, budget=4000)
    assert len(usual.ranking) > 1
    bad = np.array(usual.best.stroke.offsets)

    def unlucky(problem, runner, draws, strokes, count, *, exact):
        outcomes = play(problem, runner, draws, strokes, count, exact=exact)
        if exact and np.allclose(strokes[0], bad):
            outcomes.success[5:] = outcomes.value[5:] = 0
        return outcomes

    monkeypatch.setattr(search, '_trials', unlucky)
    result = plan(SCENE, target, budget=4000)
    assert result.best.stroke == usual.best.stroke
    assert result.best.success < 0.1


def test_few_trials_are_stated_as_they_are():
    result = plan(SCENE, {'hit': '8'}, budget=15)
    count = f'in {result.best.successes} of {result.best.trials} trials'
    assert 0 < result.best.trials < 100
    assert count in result.message
    assert count in repr(result.best)


def test_sets_of_balls_and_pockets():
    pockets = {'foot_left', 'foot_right'}
    limits = {'first_contact': frozenset({'1', '8'})}
    some = plan(SCENE, {'pot': {'8', '1'}, 'pocket': pockets}, budget=500, constraints=limits)
    limits = {'first_contact': ['1', '8']}
    target = {'pot': ['1', '8'], 'pocket': sorted(pockets)}
    assert some.message == plan(SCENE, target, budget=500, constraints=limits).message
    with pytest.raises(ValueError, match=r"keep must be one of .*, got '7'"):
        plan(SCENE, {'pot': '8'}, constraints={'keep': {'7'}})


def test_a_task_that_ends_late_is_not_a_timeout():
    """The wait times out, and the task is done when one looks: its result counts."""

    class Late(Future):
        waits = 0

        def result(self, timeout=None):
            if timeout is not None:
                self.waits += 1
                self.set_result('done')
                raise TimeoutError
            return super().result()

    runner = Runner(problem(SCENE, {'pot': '8'}, SCENE.noise), 10, ThreadPoolExecutor(1))
    late = Late()
    assert runner._result(late) == 'done'
    assert late.waits == 1


def test_strokes_that_take_long_do_not_outlast_the_time(monkeypatch):
    """Before, slow strokes used up the time, and no time was left to judge the best ones."""
    clock = [0.0]

    class Slow(ThreadPoolExecutor):
        """Executor whose tasks take 0.2 s of the clock each."""

        def submit(self, work, *arguments):
            def task():
                clock[0] += 0.2
                return work(*arguments)

            return super().submit(task)

    strokes = np.tile([0.0, 0.1, 0.1, 0.3, 2.0], (100 * CHUNK, 1))
    pots = problem(SCENE, {'pot': '8'}, SCENE.noise)
    monkeypatch.setattr('billiard_shot.planning.runner.perf_counter', lambda: clock[0])
    runner = Runner(pots, 10**6, Slow(1), seconds=1.0)
    runner.simulations = 10**6 // 2  # in no time
    done = len(runner.evaluate(strokes, exact=True).success)
    assert 0 < done < len(strokes)
    assert runner.left == 0
    runner.granted = LEAST_TRIALS  # of a best stroke, although the time is up
    assert LEAST_TRIALS <= len(runner.evaluate(strokes, exact=True).success) < 2 * CHUNK


def test_a_stroke_that_does_wrong_without_errors_says_so():
    scene = table_with(cue=(0.45, -0.185), b8=(0.9, 0.265))
    best = plan(scene, {'pot': '8', 'pocket': 'foot_left'}, budget=BUDGET).best
    assert best.warning == ''
    into_a_pocket = Stroke.from_offsets(0.0, 0.0, 0.1, np.arctan2(-0.45, 0.82), 2.0)
    assert "'cue' falls" in replace(best, stroke=into_a_pocket).warning
    wide = Stroke.from_offsets(0.8, 0.0, 0.1, 3.0, 1.0)
    assert replace(best, stroke=wide).warning == 'without errors the tip slides on the cue ball'
    aside = Stroke.from_offsets(0.0, 0.0, 0.1, 3.0, 1.0)
    assert replace(best, stroke=aside).warning == 'without errors the target is missed'
    alone = plan('pool', {'rest': (1.0, 0.5)}, budget=1000).best  # a ball on an endless cloth
    assert alone.warning == ''
    assert replace(alone, stroke=aside).warning == 'without errors the target is missed'


@pytest.mark.parametrize('seed', range(6))
def test_intervals_hold_where_a_raised_cue_may_hit_twice(seed):
    """Blockers raise the cue, which then hits twice in the strike; fresh errors judge."""
    draw = np.random.default_rng(seed)
    places = draw.uniform((-1.0, -0.5), (1.0, 0.5), (3, 2))
    turn = draw.uniform(0.0, 2.0 * np.pi)
    behind = places[0] + 0.12 * np.array([np.cos(turn), np.sin(turn)])
    scene = table_with(
        cue=tuple(places[0]), b1=tuple(places[1]), b2=tuple(behind), b3=tuple(places[2])
    )
    low = float(draw.uniform(20.0, 60.0))
    limits = {'elevation_min_deg': low, 'elevation_max_deg': low + 15.0}
    best = plan(scene, {'hit': '1'}, budget=1200, seed=seed, constraints=limits).best
    offsets = scene.noise.sample(best.stroke.offsets, 1000, draw, scene.ball.radius)
    batch = predict_batch(scene, offsets=offsets)
    fouls = batch.refused | batch.miscue | batch.double_hit | batch.off_table.any(axis=1)
    reached = ~fouls & (batch.first_met[:, 0] == 1) & (batch.pocket[:, 0] < 0)
    sure = 2.0 * np.sqrt(max(reached.mean() * (1.0 - reached.mean()), 1e-3) / len(reached))
    low, high = best.interval
    assert low - sure <= reached.mean() <= high + sure


def test_success_of_curves_is_that_in_fresh_errors():
    """The search maps the strikes of massés; the success that is stated comes from exact ones."""
    balls = {'cue': (0.0, 0.0), '8': (0.9, 0.0), '1': (0.5, 0.01)}
    scene = Scene.from_dict({'like': 'pool', 'balls': balls})
    best = plan(scene, {'hit': '8'}, budget=4000, seed=1).best
    assert best.stroke.offsets[ELEVATION] > 0.3
    draw = np.random.default_rng(99)
    batch = predict_batch(
        scene, offsets=scene.noise.sample(best.stroke.offsets, 500, draw, scene.ball.radius)
    )
    reached = (batch.first_met[:, 0] == 1) & ~(batch.refused | batch.miscue | batch.double_hit)
    both = 0.5 * (reached.mean() + best.success)
    error = np.sqrt(max(both * (1.0 - both), 1e-3) * (1.0 / len(reached) + 1.0 / best.trials))
    assert abs(reached.mean() - best.success) < 3.0 * error


def test_a_second_hit_of_the_cue_is_a_foul():
    """The cue ball stops dead beside the 8, which falls, and the cue runs into it again."""
    near = (2.0 * SCENE.ball.radius + 0.005) * np.sqrt(0.5)
    scene = table_with(cue=(1.0, 0.42), b8=(1.0 + near, 0.42 + near))
    stun = Stroke.from_offsets(0.0, 0.0, np.radians(8), np.radians(45), 2.0)
    assert predict(scene, stun).pocketed == {'8': 'foot_left'}
    pots = problem(scene, {'pot': '8'}, NOISES['none'])
    assert not evaluate_strokes(pots, np.array([stun.offsets])).success.any()
    best = plan(scene, {'pot': '8'}, noise='none', budget=BUDGET).best
    assert best.success == 1.0
    assert best.warning == ''
    assert 'hits the cue ball again' in replace(best, stroke=stun).warning


@pytest.mark.parametrize(
    ('target', 'options', 'words'),
    [
        ({'rest': (1e6, 0)}, {}, r'simulations(; not tried|$)'),  # not "misses by 990 mm"
        ({'hit': '8'}, {'constraints': {'first_contact': '3'}}, r'simulations(; not tried|$)'),
        ({'hit': '8', 'direction': (-1, 0)}, {}, r'the nearest stroke misses by \d+ degrees'),
        ({'rest': (0.0, 0.0), 'radius': 1e-9}, {'budget': 1}, r'misses by \d+ mm|; not tried'),
    ],
)
def test_a_search_without_a_plan_says_how_far_it_came(target, options, words):
    scene = Scene.from_dict(
        {'like': 'pool', 'balls': {'cue': (-0.5, 0), '8': (0.5, 0.1), '3': (0.5, -0.3)}}
    )
    result = plan(scene, target, **{'budget': 300, **options})
    assert result.status == Status.NO_PLAN
    assert re.search(words, result.message), result.message


def test_balls_that_never_rest_are_refused():
    scene = Scene.from_dict({'like': 'pool_table', 'effects': {'roll': 'off'}})
    with pytest.raises(ValueError, match='balls that never rest cannot be planned'):
        plan(scene, {'rest': (0.5, 0.0)})


def test_a_kind_of_candidates_is_tried_only_without_a_good_stroke():
    pots = problem(SCENE, {'pot': '8'}, NOISES['none'])
    with ThreadPoolExecutor(1) as threads:
        runner = Runner(pots, 4000, threads)
        stages = []
        assert next_stage(pots, runner, stages, best=0.0, share=0.05).kind is KINDS[0]
        assert next_stage(pots, runner, stages, best=GOOD, share=0.05) is None
        names = []
        while stage := next_stage(pots, runner, stages, best=0.0, share=0.05):
            names.append(stage.kind.name)
            assert len(stage.outcomes.penalty) == len(stage.candidates.strokes) <= 200
        assert names[-2:] == ['random strokes'] * 2
        assert runner.left == 0
        assert tuple(stage.kind for stage in stages[: len(KINDS)]) == KINDS
    below = [kind.below for kind in KINDS]
    assert below == sorted(below, reverse=True)

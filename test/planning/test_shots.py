"""Direct shots of many tables: where they aim, what blocks them, and how often they succeed."""

from dataclasses import replace
import math

from layouts import KINDS, table_with
import numpy as np
import pytest

from billiard_shot import (
    BallState,
    plan,
    predict,
    predict_batch,
    Scene,
    shots,
    Stroke,
    TableStates,
)
from billiard_shot.planning.pockets import ANGLES, HOLE_SPEEDS, openings_of
from billiard_shot.planning.result import kind_of
from billiard_shot.planning.targets import Gate, Hit, Pass, Pot, Rest
from billiard_shot.planning.within_noise import play_within_noise
from billiard_shot.scene import Noise
from billiard_shot.scene.player import ModelError
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.results import POCKET_NAMES

SCENE = Scene.load('pool_table')
R = SCENE.ball.radius
CORNER = POCKET_NAMES.index('foot_left')


def states_of(scene):
    """The balls of a scene at rest."""
    return {
        name: BallState((x, y, R), (0, 0, 0), (0, 0, 0)) for name, (x, y) in scene.balls.items()
    }


def to_corner(found, ball='8'):
    """The shot at the corner at the foot, left."""
    wanted = (found.pocket == CORNER) & (found.ball == found.names.index(ball))
    assert wanted.sum() == 1
    return int(np.flatnonzero(wanted)[0])


def test_a_straight_shot_aims_at_the_middle_of_the_pocket():
    # on the line at 45 degrees into the corner, 1.27 and 0.635 m from the middle
    scene = table_with(cue=(0.6, -0.035), b8=(1.0, 0.365))
    found = shots(scene, states_of(scene))
    i = to_corner(found)
    assert found.cut[i] == pytest.approx(0.0, abs=2e-3)
    a, b, elevation, azimuth, speed = found.offsets[i]
    assert (a, b) == (0.0, 0.0)
    assert azimuth == pytest.approx(math.radians(45.0), abs=2e-4)
    assert found.distance[i] == pytest.approx(0.4 * math.sqrt(2.0) - 2.0 * R, abs=1e-5)
    assert 0.0 < elevation < math.radians(2.0)
    assert 0.3 < speed < 3.0
    assert found.best.tolist() == [found.chance.max()]


def test_a_cut_to_the_left_and_its_mirror_image_are_alike():
    scene, mirrored = (table_with(cue=(0.3, s * 0.1), b8=(0.8, s * 0.3)) for s in (1.0, -1.0))
    one, other = shots(scene, states_of(scene)), shots(mirrored, states_of(mirrored))
    i = to_corner(one)
    j = int(np.flatnonzero(other.pocket == POCKET_NAMES.index('foot_right'))[0])
    assert one.cut[i] > 0.1
    assert other.cut[j] == pytest.approx(-one.cut[i])
    assert other.chance[j] == pytest.approx(one.chance[i], abs=1e-3)
    assert other.offsets[j, 3] == pytest.approx(-one.offsets[i, 3])


def test_balls_in_the_way_block_a_shot_or_make_it_harder():
    scene = table_with(cue=(0.6, -0.035), b8=(1.0, 0.365))
    errors = Noise().times(5)
    free = shots(scene, states_of(scene), noise=errors)
    chances = []
    for aside in (0.0, 0.058, 0.0595, 0.09):  # beside the middle of the path of the cue ball
        x, y = 0.8 + aside * math.sqrt(0.5), 0.165 - aside * math.sqrt(0.5)
        blocked = table_with(cue=(0.6, -0.035), b8=(1.0, 0.365), b3=(x, y))
        found = shots(blocked, states_of(blocked), legal=['8'], noise=errors)
        at_corner = found.chance[found.pocket == CORNER]
        chances.append(float(at_corner[0]) if len(at_corner) else 0.0)
    assert chances[0] == 0.0
    assert 0.0 < chances[1] < chances[2]
    assert chances[3] == free.chance[to_corner(free)]


def test_a_ball_behind_the_cue_ball_lifts_the_cue():
    scene = table_with(cue=(0.6, -0.035), b8=(1.0, 0.365), b3=(0.54, -0.095))
    found = shots(scene, states_of(scene), legal=['8'])
    elevation = found.offsets[to_corner(found), 2]
    assert math.radians(20.0) < elevation < math.radians(60.0)
    batch = predict_batch(scene, offsets=found.offsets)
    assert (batch.status == 0).all()


def test_tables_with_different_balls_and_legal_balls():
    names = 'cue', '1', '2'
    places = np.zeros((4, 3, 3))
    places[:] = [(0.0, 0.0, R), (0.8, 0.3, R), (0.8, -0.3, R)]
    present = np.ones((4, 3), bool)
    present[1, 1] = present[2, 0] = False
    states = TableStates(names, places, present=present)
    legal = present.copy()
    legal[3, 2] = False
    found = shots(SCENE, states, legal)
    potted = [set(found.ball[found.table == t].tolist()) for t in range(4)]
    assert potted == [{1, 2}, {2}, set(), {1}]
    assert found.best[2] == 0.0
    assert set(shots(SCENE, states, ['2']).ball.tolist()) == {2}


def test_chances_follow_the_errors_of_the_player():
    scene = table_with(cue=(0.0, 0.1), b8=(0.7, 0.3))
    chances = [
        shots(scene, states_of(scene), noise=Noise().times(factor)).best[0]
        for factor in (0.0, 0.5, 1.0, 2.0, 4.0)
    ]
    assert chances[0] == 1.0
    assert (np.diff(chances) < 0.0).all()
    # the azimuth alone: the chance is that of a normal error within a fixed interval
    wide, narrow = (
        shots(scene, states_of(scene), noise={'a': 0, 'b': 0, 'speed': 0, 'azimuth_deg': s})
        for s in (0.8, 0.4)
    )
    ends = [
        math.sqrt(2.0) * 0.8 * factor * _inverse_erf(found.best[0])
        for found, factor in ((wide, 1.0), (narrow, 0.5))
    ]
    assert ends[0] == pytest.approx(ends[1], rel=0.1)


def _inverse_erf(value):
    low, high = 0.0, 6.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if math.erf(middle) < value else (low, middle)
    return low


def test_openings_are_symmetric_and_a_slow_ball_finds_more():
    for scene in (SCENE, Scene.load('nine_ball')):
        openings = openings_of(*params_on_table(scene))
        assert openings.shape == (2, ANGLES, len(HOLE_SPEEDS), 2)
        assert np.abs(openings[:, ::-1, :, ::-1] + openings).max() < 1e-6
        straight = openings[:, ANGLES // 2, :, 1]
        mouth = 0.5 * np.array([scene.table.corner.mouth, scene.table.side.mouth])
        # the middle of the ball passes between the jaws, and a little beyond after touching one
        assert (straight > mouth[:, np.newaxis] - R).all()
        assert (straight < mouth[:, np.newaxis]).all()
        assert (straight[:, 0] >= straight[:, -1]).all()


def test_stated_chances_are_those_of_exact_strokes():
    draw = np.random.default_rng(4)
    stated, measured = [], []
    while len(stated) < 30:
        balls = {name: draw.uniform((-1.2, -0.58), (1.2, 0.58)).tolist() for name in 'acdefg'}
        try:
            scene = table_with(cue=balls.pop('a'), **balls)
        except ValueError:
            continue
        found = shots(scene, states_of(scene))
        likely = np.flatnonzero(found.chance > 0.03)
        for i in draw.permutation(likely)[:4]:
            played = scene.noise.sample(found.offsets[i], 120, draw, R)
            batch = predict_batch(scene, offsets=played, tolerance=1e-3)
            ball = batch.names.index(found.names[found.ball[i]])
            stated.append(found.chance[i])
            measured.append((batch.pocket[:, ball] == found.pocket[i]).mean())
    error = np.array(stated) - measured
    assert abs(error.mean()) < 0.03
    assert np.abs(error).mean() < 0.06


def test_stated_chances_hold_where_the_cue_ball_nearly_touches_the_ball():
    """The throw then decides where the ball goes; the cue may push while the balls meet."""
    draw = np.random.default_rng(6)
    stated, measured = [], []
    while len(stated) < 30:
        gap, x, y = draw.uniform((2e-4, -0.9, -0.4), (1e-3, 0.9, 0.4))
        apart = 2.0 * R + gap
        corner = draw.choice([-1.27, 1.27]), draw.choice([-0.635, 0.635])
        back = math.atan2(y - corner[1], x - corner[0])
        back += draw.uniform(-1.0, 1.0) * math.acos(2.0 * R / apart)
        scene = table_with(cue=(x + apart * math.cos(back), y + apart * math.sin(back)), b8=(x, y))
        found = shots(scene, states_of(scene))
        for i in np.flatnonzero(found.chance > 0.03)[:1]:
            played = scene.noise.sample(found.offsets[i], 30, draw, R)
            batch = predict_batch(scene, offsets=played, tolerance=1e-3)
            falls = batch.pocket[:, batch.names.index('8')] == found.pocket[i]
            stated.append(found.chance[i])
            measured.append(falls.mean())
    assert abs(np.mean(stated) - np.mean(measured)) < 0.13
    assert sum(np.greater(stated, 0.9) & np.less(measured, 0.1)) <= 1


def test_chances_know_the_errors_of_places():
    """Those of a camera, and those that a fit left in `model_error`."""
    scene, sigma, count = table_with(cue=(-0.3, 0.1), b8=(0.7, 0.3)), 0.003, 400
    exact = replace(scene, noise=Noise(0.0, 0.0, 0.0, 0.0, 0.0))
    found = shots(exact, states_of(scene), noise=replace(exact.noise, balls=sigma))
    fitted = replace(exact, model_error=ModelError(balls=sigma))
    assert shots(fitted, states_of(scene)).chance.tolist() == found.chance.tolist()
    draw, i = np.random.default_rng(8), int(found.chance.argmax())
    places = np.full((count, 2, 3), R)
    places[..., :2] = [scene.balls['cue'], scene.balls['8']] + sigma * draw.normal(
        size=(count, 2, 2)
    )
    strokes, tables = found.offsets[[i] * count], TableStates(('cue', '8'), places)
    played = play_within_noise(exact, strokes, Noise().sigmas(R), tables)
    kept = (played.pocket[:, 1] == found.pocket[i]).mean()
    assert 0.3 < found.chance[i] < 0.9
    assert kept == pytest.approx(found.chance[i], abs=0.08)


def test_requests_that_make_no_sense_are_refused():
    scene = table_with(cue=(0, 0), b8=(0.5, 0.1))
    states = states_of(scene)
    with pytest.raises(ValueError, match='scene must have a table with pockets'):
        shots('pool', states)
    with pytest.raises(ValueError, match="states must have the ball 'cue', got 8"):
        shots(scene, {'8': states['8']})
    with pytest.raises(ValueError, match="legal must be of cue, 8, got '9'"):
        shots(scene, states, ['9'])
    with pytest.raises(ValueError, match=r'legal must be of shape \(1, 2\), got \(2,\)'):
        shots(scene, states, [True, False])


# --- every kind of shot is found where nothing else leads to the target --------------------------

ONLY = ('kick', 'position', 'curve', 'massé', 'jump')  # without this way there is none at all


def check_path(shot, hit, *, flies):
    """Check that the cue ball flies over the balls in its way to another, or goes around them."""
    radius = shot.scene.ball.radius
    met = next(e.time for e in shot.events if len(e.balls) > 1)
    path = shot.trajectory.at(np.linspace(0.0, met - 1e-6, 500)).position
    height = path[:, 2].max() - radius
    others = [place for name, place in shot.scene.balls.items() if name not in ('cue', hit)]
    apart = min(np.hypot(*(path[:, :2] - place).T).min() for place in others)
    if flies:
        assert height > 2.0 * radius * 0.9
        assert apart < 2.0 * radius
    else:
        assert height < 2.0 * radius
        assert apart > 2.0 * radius


@pytest.mark.parametrize('kind', KINDS)
def test_the_only_way_is_found(kind):
    scene, target, limits, _ = KINDS[kind]
    result = plan(scene, target, constraints=limits, budget=20_000)
    assert result.best is not None, result.message
    assert result.best.success > 0.15
    for each in result.ranking:
        assert kind in each.kind.split(', ')
    if kind in ('jump', 'massé', 'curve'):
        check_path(result.best.shot, target['hit'], flies=kind == 'jump')


@pytest.mark.parametrize('kind', ONLY)
def test_without_it_there_is_no_way(kind):
    scene, target, limits, change = KINDS[kind]
    result = plan(scene, target, constraints={**limits, **change}, budget=3000)
    assert result.best is None


@pytest.mark.parametrize(
    ('numbers', 'target', 'kind'),
    [
        ((0, 0, 0.05, 0, 2), Hit('8'), 'direct'),
        ((0, 0, 0.05, 0.045, 2), Hit('8'), 'cut'),
        ((0, 0, 0.05, 2.3, 4), Hit('8'), 'kick'),
        ((0, 0, 0.05, 0.01, 2), Pot('1'), 'combination'),
    ],
)
def test_names(numbers, target, kind):
    scene = table_with(cue=(0, 0), b8=(0.6, 0), b1=(0.9, 0))
    assert kind in kind_of(predict(scene, Stroke.from_offsets(*numbers)), target)


def test_a_ball_that_touches_the_struck_one_is_a_combination():
    shot = predict('frozen_combination', Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3.0))
    assert shot.pocketed == {'8': 'foot_left'}
    assert 'combination' in kind_of(shot, Pot('8')).split(', ')
    assert 'combination' not in kind_of(shot, Pot('1')).split(', ')


@pytest.mark.parametrize(
    ('target', 'kind'),
    [
        (Pass((0.5, 0.0)), 'direct'),
        (Gate(((0.5, -0.05), (0.5, 0.05))), 'direct'),
        (Rest((1.0, 0.0)), 'kick'),  # the cue ball comes back from the cushion
        (Pass((0.5, 0.3), radius=0.01), 'kick'),  # it never passes this point
    ],
)
def test_a_cushion_counts_only_before_the_target(target, kind):
    shot = predict('pool_table', Stroke.from_offsets(b=0.1, elevation_deg=5, speed=2))
    assert kind_of(shot, target) == kind

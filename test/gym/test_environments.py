"""The environments pass Gymnasium's own checks, follow the referee, and can be learnt from."""

from dataclasses import replace

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.game import judge, start
from billiard_shot.game.rack import scene_of

gymnasium = pytest.importorskip('gymnasium')
from gymnasium.utils.env_checker import check_env  # noqa: E402

from billiard_shot.gym import (  # noqa: E402
    action_of,
    EightBallEnv,
    PracticeEnv,
    PracticeVectorEnv,
    strokes_of,
)

TABLE = Scene.load('seven_foot')
EXACT = replace(TABLE, noise=TABLE.noise.times(0.0))


@pytest.mark.parametrize('name', ['Practice', 'EightBall'])
@pytest.mark.filterwarnings('error')
def test_environments_pass_the_checks_of_gymnasium(name):
    env = gymnasium.make(f'BilliardShot/{name}-v0', scene='seven_foot')
    check_env(env.unwrapped)


def test_actions_and_strokes_are_inverse():
    offsets = np.array([(0.2, -0.1, 0.1, 3.0, 2.0), (0.0, 0.3, 0.05, -2.0, 0.5)])
    assert strokes_of(TABLE, action_of(TABLE, offsets)) == pytest.approx(offsets, abs=1e-6)
    corner = strokes_of(TABLE, np.ones((1, 7)))[0]
    assert np.hypot(*corner[:2]) == pytest.approx(TABLE.robot.offset_max)
    assert corner[4] == TABLE.robot.speed_max


def test_one_table_plays_as_one_of_many():
    one, many = PracticeEnv(TABLE), PracticeVectorEnv(3, TABLE)
    for env in (one, many):
        env.action_space.seed(1)
    seen, _ = one.reset(seed=5)
    again, _ = PracticeEnv(TABLE).reset(seed=5)
    assert (seen == again).all()
    assert seen.shape == (4, 3)
    assert seen[0].tolist() == [0.0, 0.0, 0.0]  # the cue ball is in hand
    seen, _ = many.reset(seed=5)
    assert len({rows.tobytes() for rows in seen}) == 3  # each table has its own balls
    for _ in range(5):
        seen, reward, ended, truncated, infos = many.step(many.action_space.sample())
        assert many.observation_space.contains(seen)
        assert (ended == (reward == 0.0) | infos.get('cleared', False)).all()
        assert not truncated.any()


def test_practice_plays_what_predict_predicts_by_the_rules():
    """Strokes in all directions on one table, without errors: row by row."""
    count = 300
    env = PracticeVectorEnv(count, EXACT, balls=5)
    env.reset(seed=2)
    tables = env._tables
    state = start('practice', EXACT, seed=7, balls=5).with_cue_ball(-0.9, 0.35)
    near = {**state.balls, '1': (-0.896 + 2.0 * EXACT.ball.radius, 0.35)}
    state = replace(state, balls=near)
    tables.position[:, :, :2] = [state.balls[name] for name in tables.names]
    tables.present[:] = True
    strokes = np.zeros((count, 5))
    strokes[:, 2], strokes[:, 4] = 0.1, np.linspace(0.5, 6.0, count)
    strokes[:, 3] = np.linspace(-np.pi, np.pi, count) * 0.999
    actions = action_of(EXACT, strokes)
    _, reward, ended, _, _ = env.step(actions)
    scene, refused, hit_again = scene_of(EXACT, state), 0, 0
    for i, row in enumerate(strokes_of(EXACT, actions).tolist()):
        shot = predict(scene, Stroke.from_offsets(*row))
        ruling = judge(state, shot=shot)
        refused += shot.status.refused
        hit_again += shot.double_hit is not None
        fallen = [ball for ball in shot.pocketed if ball != 'cue']
        assert reward[i] == (0 if ruling.fouls else len(fallen))
        assert ended[i] == (reward[i] == 0)
        for k, name in enumerate(tables.names):
            if not ended[i] and name not in shot.pocketed:
                place = shot.final_position[name]
                assert env._tables.position[i, k] == pytest.approx(place, abs=1e-6)
    assert 5 < np.count_nonzero(reward) < count - 5
    assert refused > 10
    assert hit_again > 10


def test_a_cue_ball_on_another_ball_ends_the_episode():
    env = PracticeEnv(TABLE, balls=1)
    seen, _ = env.reset(seed=3)
    action = np.zeros(7, np.float32)
    half = np.array([TABLE.table.length, TABLE.table.width]) / 2.0
    action[5:] = seen[1, :2] * half / (half - TABLE.ball.radius)
    _, reward, ended, _, infos = env.step(action)
    assert (reward, ended, infos) == (0.0, True, {'cleared': False})


def test_eight_ball_is_played_by_the_rules_until_somebody_wins():
    env = EightBallEnv(TABLE, 'random')
    seen, _ = env.reset(seed=11)
    env.action_space.seed(4)
    results = []
    for _ in range(400):
        seen, reward, ended, truncated, infos = env.step(env.action_space.sample())
        assert env.observation_space.contains(seen)
        assert infos['text']
        results.append(reward)
        if ended or truncated:
            break
    assert ended != truncated
    assert results[-1] in ((1.0, -1.0) if ended else (0.0,))
    assert not any(results[:-1])


def test_eight_ball_shows_what_may_be_potted_and_takes_the_ball_that_falls_as_called():
    env = EightBallEnv(EXACT, 'random')
    env.reset(seed=1)
    state = start('eight_ball', EXACT)
    balls = {'cue': (0.6, 0.15), '1': (0.8, 0.35), '9': (-0.5, 0.0), '8': (-0.6, 0.3)}
    env._state = replace(
        state, balls=balls, in_hand='', phase='play', groups=('solids', 'stripes')
    )
    seen = env._seen()
    assert [row[3] for row in seen[[0, 1, 8, 9]]] == [0.0, 1.0, -1.0, -1.0]
    aim = np.arctan2(0.35 - 0.15, 0.8 - 0.6)
    stroke = [(0.0, 0.0, 0.05, aim, 1.5)]
    seen, reward, ended, _, infos = env.step(action_of(EXACT, stroke)[0])
    assert infos['text'] == ['ball 1 falls as called']
    assert seen[8, 3] == 1.0
    assert (reward, ended) == (0.0, False)


def test_scenes_without_pockets_and_unknown_opponents_are_refused():
    with pytest.raises(ValueError, match='scene must have a table with pockets'):
        PracticeVectorEnv(2, 'carom')
    with pytest.raises(ValueError, match='num_envs'):
        PracticeVectorEnv(0)
    with pytest.raises(ValueError, match='balls'):
        PracticeVectorEnv(1, balls=16)
    with pytest.raises(ValueError, match='player'):
        EightBallEnv(opponent='best')


def drawn(name, **options):
    return gymnasium.make(f'BilliardShot/{name}-v0', scene='seven_foot', **options)


@pytest.mark.parametrize('name', ['Practice', 'EightBall'])
def test_an_environment_draws_its_table(name):
    env = drawn(name, render_mode='rgb_array')
    env.reset(seed=1)
    before = env.render()
    env.step(env.action_space.sample())
    after = env.render()
    assert before.shape == after.shape
    assert before.shape[2] == 3
    assert before.dtype == np.uint8
    assert (before != after).any(), 'the picture does not change with the balls'
    assert drawn(name).unwrapped.render() is None


@pytest.mark.parametrize('name', ['Practice', 'EightBall'])
def test_a_window_shows_each_step(name, monkeypatch):
    pyplot = pytest.importorskip('matplotlib.pyplot', reason='needs matplotlib')
    pyplot.switch_backend('agg')
    env = drawn(name, render_mode='human')
    env.reset(seed=1)
    (number,) = pyplot.get_fignums()
    (shown,) = pyplot.figure(number).axes[0].images
    before = shown.get_array().copy()
    env.step(env.action_space.sample())
    assert (before != shown.get_array()).any()
    env.close()
    assert not pyplot.get_fignums()


def test_many_tables_draw_a_picture_each():
    env = PracticeVectorEnv(3, TABLE, render_mode='rgb_array')
    env.reset(seed=1)
    pictures = env.render()
    assert len({picture.tobytes() for picture in pictures}) == 3
    with pytest.raises(ValueError, match="render_mode must be one of rgb_array, got 'human'"):
        PracticeVectorEnv(3, TABLE, render_mode='human')


@pytest.mark.parametrize('make', [PracticeEnv, EightBallEnv])
def test_wrong_actions_are_refused_by_name(make):
    env = make(TABLE)
    with pytest.raises(gymnasium.error.ResetNeeded, match='reset must be called before step'):
        env.step(np.zeros(7))
    env.reset(seed=1)
    for wrong in (np.zeros(3), np.zeros(8), np.zeros((2, 7))):
        with pytest.raises(ValueError, match=r'action must have the shape \(7,\)'):
            env.step(wrong)
    with pytest.raises(ValueError, match='action must be finite, got'):
        env.step(np.full(7, np.nan))

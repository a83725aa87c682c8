"""An agent plays the best direct shots, on all tables at once, and records a video of it."""

import gymnasium
import numpy as np
from PIL import Image

from billiard_shot import shots, TableStates
from billiard_shot.gym import action_of

PLACES = 100  # of the cue ball in hand, at random
env = gymnasium.make_vec(
    'BilliardShot/Practice-v0',
    8,
    vectorization_mode='vector_entry_point',
    render_mode='rgb_array',
    balls=3,
)
scene, draw = env.unwrapped.scene, np.random.default_rng(1)
half = np.array([scene.table.length, scene.table.width]) / 2 - scene.ball.radius


def act(seen):
    tables, balls, _ = seen.shape
    position = np.full((tables, PLACES, balls, 3), scene.ball.radius)
    position[..., :2] = seen[:, None, :, :2] * (half + scene.ball.radius)
    present = np.repeat(seen[:, None, :, 2] > 0, PLACES, axis=1)
    in_hand = ~present[:, 0, 0]
    position[in_hand, :, 0, :2] = half * draw.uniform(-1, 1, (in_hand.sum(), PLACES, 2))
    present[..., 0] = True
    names = ['cue', *map(str, range(1, balls))]
    states = TableStates(names, position.reshape(-1, balls, 3), present=present.reshape(-1, balls))
    direct = shots(scene, states)
    strokes, place = np.zeros((tables, 5)), np.zeros((tables, 2))
    for table in range(tables):
        own = np.flatnonzero((direct.table // PLACES == table) & (direct.distance > 0.1))
        if len(own):
            best = own[np.argmax(direct.chance[own])]
            strokes[table] = direct.offsets[best]
            place[table] = states.position[direct.table[best], 0, :2]
    return action_of(scene, strokes, place)


seen, _ = env.reset(seed=1)
cleared = episodes = 0
video = []
for number in range(20):
    if number < 5:
        video.append(Image.fromarray(env.render()[0]))  # of the first table
    seen, reward, ended, _, infos = env.step(act(seen))
    episodes += ended.sum()
    cleared += infos['cleared'].sum() if ended.any() else 0
print(f'{cleared} of {episodes} tables of 3 balls cleared')
video[0].save('practice.gif', save_all=True, append_images=video[1:], duration=1000, loop=0)

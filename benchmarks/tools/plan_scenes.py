"""Scenes for plans, drawn from a seed, and what was measured of a stroke by fresh noise."""
import math

import numpy as np

from billiard_shot import predict_batch, Scene
from billiard_shot.planning.plan import NOISES
from billiard_shot.planning.strikes import vectors_of
from billiard_shot.table.run import POCKET_NAMES

CUTS = (0, 15, 30, 45, 60, 75)  # degrees, limits of the bins
LENGTHS = (0.3, 0.7, 1.1, 1.6)  # m, from the cue ball to the ghost ball
POCKETS = {  # the middle of the mouth
    'foot_left': (1.23, 0.595), 'head_left': (-1.23, 0.595), 'head_right': (-1.23, -0.595),
    'foot_right': (1.23, -0.595), 'side_left': (0.0, 0.635), 'side_right': (0.0, -0.635),
}
POOL = Scene.load('pool').to_dict()
TABLE = Scene.load('pool_table').to_dict()
RADIUS = POOL['ball']['radius']


def table(balls):
    """Nine-foot table with balls."""
    return Scene.from_dict({**TABLE, 'balls': balls})


def can_lie(balls):
    """Scene if balls can lie so, else None."""
    try:
        return table(balls)
    except ValueError:
        return None


def pot_scene(draw, cut_bin, length_bin):
    """Scene, target and cut: one ball to be potted, nothing in the way; cut and length in bins."""
    while True:
        pocket = str(draw.choice(list(POCKETS)))
        there = np.array(POCKETS[pocket])
        ball = draw.uniform((-1.15, -0.55), (1.15, 0.55))
        ahead = there - ball
        distance = float(np.hypot(*ahead))
        if not 0.2 < distance < 1.5:
            continue
        line = ahead / distance
        if pocket.startswith('side') and abs(line[1]) < 0.7:
            continue  # a side pocket does not take balls that come along its cushion
        cut = math.radians(draw.uniform(CUTS[cut_bin], CUTS[cut_bin + 1]))
        turn = cut * draw.choice((-1.0, 1.0))
        way = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        length = draw.uniform(LENGTHS[length_bin], LENGTHS[length_bin + 1])
        cue = ball - 2.0 * RADIUS * line - length * (way @ line)
        if abs(cue[0]) > 1.2 or abs(cue[1]) > 0.57:
            continue
        scene = can_lie({'cue': cue.tolist(), '8': ball.tolist()})
        if scene:
            return scene, {'pot': '8', 'pocket': pocket}


def blocked_scene(draw):
    """Endless cloth, a ball to be hit and one or two in the way: only curve, massé or jump do."""
    while True:
        distance = draw.uniform(0.5, 1.4)
        balls = {'cue': (0.0, 0.0), '8': (distance, 0.0)}
        count = int(draw.integers(1, 3))
        along = draw.uniform(0.25, distance - 0.15)
        if count == 1:
            balls['1'] = (along, draw.uniform(-0.03, 0.03))
        else:
            gap = draw.uniform(2.02, 3.0) * RADIUS
            middle = draw.uniform(-0.02, 0.02)
            balls['1'], balls['2'] = (along, middle - 0.5 * gap), (along, middle + 0.5 * gap)
        try:
            return Scene.from_dict({**POOL, 'balls': balls}), {'hit': '8'}
        except ValueError:
            continue


def sigmas(noise):
    """Standard deviations of a, b (ball radii), elevation, azimuth (rad), speed (m/s)."""
    return np.array([noise.a / RADIUS, noise.b / RADIUS, math.radians(noise.elevation_deg),
                     math.radians(noise.azimuth_deg), noise.speed])


def measured(scene, target, strokes, tolerance=1e-4):
    """Whether strokes (n, 5) reach a target, and where the cue ball ends, from predict_batch."""
    batch = predict_batch(scene, *vectors_of(strokes), tolerance=tolerance)
    names = list(batch.table.names)
    good = np.isin(batch.status, (0, 2, 5))
    if 'pot' in target:
        ball = names.index(target['pot'])
        good &= batch.table.pocket[:, ball] == POCKET_NAMES.index(target['pocket'])
        good &= batch.table.pocket[:, 0] < 0
    else:
        good &= batch.table.first_met[:, 0] == names.index(target['hit'])
    return good, batch.rest[:, :2]


def noisy(stroke, noise, count, seed):
    """Strokes (count, 5) as they are played."""
    draw = np.random.default_rng(seed)
    return np.array(stroke) + draw.standard_normal((count, 5)) * sigmas(noise)


TOURNAMENT = NOISES['tournament']

"""Scenes for plans, drawn from a seed, and measurements of strokes under fresh noise."""

import math

import numpy as np

from billiard_shot import predict_batch, Scene
from billiard_shot.planning.problem import limits_of, raise_for_clearance
from billiard_shot.scene.player import NOISES
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.run.results import POCKET_NAMES

CUTS = (0, 15, 30, 45, 60, 75)  # degrees, limits of the bins
LENGTHS = (0.3, 0.7, 1.1, 1.6)  # m, from the cue ball to the ghost ball
POCKETS = {  # the middle of the mouth
    'foot_left': (1.23, 0.595),
    'head_left': (-1.23, 0.595),
    'head_right': (-1.23, -0.595),
    'foot_right': (1.23, -0.595),
    'side_left': (0.0, 0.635),
    'side_right': (0.0, -0.635),
}
POOL = Scene.load('pool').to_dict()
TABLE = Scene.load('pool_table').to_dict()
RADIUS = POOL['ball']['radius']
TOURNAMENT = NOISES['tournament']


def table(balls):
    """Nine-foot table with balls."""
    return Scene.from_dict({**TABLE, 'balls': balls})


def can_lie(balls):
    """Scene with these balls; None if they cannot lie there."""
    try:
        return table(balls)
    except ValueError:
        return None


def pot_scene(draw, cut_bin, length_bin):
    """Scene and target: one ball to be potted, nothing in the way; cut and length in bins."""
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


def crowded_scene(draw):
    """Table with 15 balls at random, the cue ball among them."""
    while True:
        names = ('cue', *map(str, range(1, 15)))
        scene = can_lie(
            {name: draw.uniform((-1.2, -0.58), (1.2, 0.58)).tolist() for name in names}
        )
        if scene:
            return scene


def blocked_scene(draw):
    """Scene and target: a ball that only a curve, massé or jump reaches, on an endless cloth."""
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


def raised_scene(draw):
    """Scene, target and limits: a raised cue, with a ball behind the cue ball."""
    while True:
        places = draw.uniform((-1.0, -0.5), (1.0, 0.5), (3, 2))
        turn = draw.uniform(0.0, 2.0 * np.pi)
        behind = places[0] + 0.12 * np.array([math.cos(turn), math.sin(turn)])
        names = ('cue', '8', '2', '1')
        balls = dict(zip(names, np.vstack([places, behind]).tolist(), strict=True))
        scene, low = can_lie(balls), float(draw.uniform(20.0, 60.0))
        if scene:
            limits = {'elevation_min_deg': low, 'elevation_max_deg': low + 15.0}
            return scene, {'hit': '8'}, limits


def position_scene(draw):
    """Scene, target, and a place where some stroke that pots the ball leaves the cue ball."""
    while True:
        scene, target = pot_scene(draw, int(draw.integers(4)), int(draw.integers(3)))
        count = 400
        strokes = np.zeros((count, 5))
        strokes[:, 0] = draw.uniform(-0.3, 0.3, count)
        strokes[:, 1] = draw.uniform(-0.4, 0.4, count)
        strokes[:, 3] = ghost_azimuth(scene, target) + 0.01 * draw.standard_normal(count)
        strokes[:, 4] = draw.uniform(0.6, 3.0, count)
        good, rest = measured(scene, target, lifted(scene, strokes, TOURNAMENT), 1e-3)
        if good.sum() >= 5:
            place = rest[draw.choice(np.flatnonzero(good))]
            return scene, target, tuple(place.tolist())


def ghost_azimuth(scene, target):
    """Direction from the cue ball to the ghost ball [rad]."""
    ball = np.array(scene.balls['8'])
    line = np.array(POCKETS[target['pocket']]) - ball
    way = ball - 2.0 * RADIUS * line / np.hypot(*line) - scene.cue_ball[:2]
    return math.atan2(way[1], way[0])


def lifted(scene, strokes, noise):
    """Strokes with the cue as low as clearance allows."""
    return raise_for_clearance(scene, limits_of(scene, None, noise), strokes)


def baseline(scene, target, noise, budget, seed):
    """Best stroke at the ghost ball, hit in the middle: the whole budget is spent on its speed."""
    speeds = np.geomspace(0.4, 4.5, 12)
    strokes = np.zeros((len(speeds), 5))
    strokes[:, 3], strokes[:, 4] = ghost_azimuth(scene, target), speeds
    strokes = lifted(scene, strokes, noise)
    count = budget // len(speeds)
    draw = np.random.default_rng(seed)
    played = strokes[:, None] + draw.standard_normal((1, count, 5)) * sigmas(noise)
    good, _ = measured(scene, target, played.reshape(-1, 5), 1e-3)
    return strokes[good.reshape(len(speeds), count).sum(axis=1).argmax()]


def brute_force(scene, target, noise, count, seed):
    """Best success under noise among random strokes that succeed without noise."""
    draw = np.random.default_rng(seed)
    hits = []
    for begin in range(0, count, 20_000):
        size = min(20_000, count - begin)
        strokes = np.empty((size, 5))
        radius, angle = 0.5 * np.sqrt(draw.random(size)), 2.0 * np.pi * draw.random(size)
        strokes[:, 0], strokes[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
        strokes[:, 2] = np.radians(draw.uniform(0.35, 85.0, size))
        strokes[:, 3] = draw.uniform(-np.pi, np.pi, size)
        strokes[:, 4] = draw.uniform(0.1, 4.5, size)
        hits.append(strokes[measured(scene, target, strokes, 1e-3)[0]])
    found = np.concatenate(hits)
    for tries, kept in ((16, 60), (100, 10), (1000, 1)):
        if not len(found):
            return 0.0
        played = found[:, None] + draw.standard_normal((1, tries, 5)) * sigmas(noise)
        good, _ = measured(scene, target, played.reshape(-1, 5), 1e-3)
        chances = good.reshape(len(found), tries).mean(axis=1)
        order = np.argsort(-chances, kind='stable')[:kept]
        found, chances = found[order], chances[order]
    return float(chances[0])


def sigmas(noise):
    """Standard deviations of a, b (ball radii), elevation, azimuth (rad), speed (m/s)."""
    return np.array(
        [
            noise.a / RADIUS,
            noise.b / RADIUS,
            math.radians(noise.elevation_deg),
            math.radians(noise.azimuth_deg),
            noise.speed,
        ]
    )


def measured(scene, target, strokes, tolerance=1e-4):
    """Whether strokes (n, 5) reach a target, and where the cue ball ends, from predict_batch."""
    batch = predict_batch(scene, *vectors_of(strokes), tolerance=tolerance)
    names = list(batch.names)
    good = np.isin(batch.status, (0, 2, 5)) & ~batch.miscue & ~batch.double_hit
    if 'pot' in target:
        ball = names.index(target['pot'])
        good &= batch.pocket[:, ball] == POCKET_NAMES.index(target['pocket'])
    else:
        good &= batch.first_met[:, 0] == names.index(target['hit'])
    good &= batch.pocket[:, 0] < 0
    return good, batch.final_position[:, 0, :2]


def noisy(stroke, noise, count, seed):
    """Strokes (count, 5) as they are played."""
    draw = np.random.default_rng(seed)
    return np.array(stroke) + draw.standard_normal((count, 5)) * sigmas(noise)

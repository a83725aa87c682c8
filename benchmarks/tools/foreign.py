"""
An arena that differs from ours: another strike, another table, another noise, another rule.

The strike is one impulse along the cue, as in W. Leckie and M. Greenspan, An event-based pool
physics simulator, Advances in Computer Games 2005 (LNCS 4250): no squirt, no miscue, no jump, no
obstacle for the cue. After a foul in eight-ball the balls go back to where they were.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from billiard_shot import BallState, Scene, simulate
from billiard_shot.calibration.calibrate import calibrate
from billiard_shot.game import find_game
from billiard_shot.game.state import outcome_of_run
from billiard_shot.scene import Noise

TABLE = Scene.load('seven_foot')
R = TABLE.ball.radius
NOISE = Noise(a=0.003 * R, b=0.003 * R, elevation_deg=0.1, azimuth_deg=0.1, speed=0.1)
NUMBERS = {
    'contacts.ball_ball.restitution': 0.97,
    'cloth.sliding_friction': 0.26,
    'cloth.rolling_resistance': 0.0125,
    'table.cushion.restitution': 0.85,
    'table.cushion.friction': 0.2,
}
THEIRS = TABLE.with_parameters(list(NUMBERS), list(NUMBERS.values()))
PERIOD = 0.02  # s between places that a calibration sees


def strike(scene, stroke):
    """Return the cue ball [m/s], [rad/s] after an impulse along the cue, without losses."""
    a, b, elevation, azimuth, speed = stroke.offsets
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    along = np.cos(elevation) * level - np.sin(elevation) * np.array([0.0, 0.0, 1.0])
    right = np.array([level[1], -level[0], 0.0])
    point = a * right + b * np.cross(right, along) - np.sqrt(1.0 - a * a - b * b) * along
    mass = scene.ball.mass
    change = 2.0 * speed / (1.0 + mass / scene.cue.mass + 2.5 * (a * a + b * b)) * along
    velocity = change * (1.0, 1.0, 0.0)  # the cloth stops the rest
    return velocity, 2.5 * np.cross(point, change) / scene.ball.radius


def run(scene, stroke, errors):
    """Play a stroke in that arena, with the noise of the scene."""
    velocity, spin = strike(THEIRS, scene.noise.perturb(stroke, errors, R))
    lying = {ball: BallState(position=(x, y, R)) for ball, (x, y) in scene.balls.items()}
    lying['cue'] = BallState(lying['cue'].position, velocity, spin)
    return simulate(THEIRS, lying)


def foreign(scene, stroke, errors):
    """Tell what rules ask of a stroke there. A `Simulator` of games."""
    return outcome_of_run(run(scene, stroke, errors), THEIRS)


def recorded(scene, stroke, errors):
    """Tell where the balls are after a stroke there. A `Simulator` of calibrations."""
    played = run(scene, stroke, errors)
    tracks = {}
    for name, ball in played.balls.items():
        end = played.duration if name in played.places_left else ball.duration
        times = np.arange(0.0, end, PERIOD)
        tracks[name] = np.column_stack([times, ball.at(times).position[:, :2]])
    return tracks


@lru_cache
def player_scene(fitted):
    """Return the scene with which a player plans there: ours with its noise, or fitted to it."""
    ours = replace(TABLE, noise=NOISE)
    return calibrate(recorded, ours).scene if fitted else ours


def rule(state, call, outcome):
    """Rule as in eight-ball, but a foul that does not end the rack puts the balls back."""
    ruling = find_game('eight_ball').rule(state, call, outcome)
    goes_back = bool(ruling.fouls) and state.phase != 'break' and not ruling.state.over
    return replace(ruling, restore=goes_back, spot=() if goes_back else ruling.spot)


GAME = replace(find_game('eight_ball'), name='tools.foreign', rule=rule)

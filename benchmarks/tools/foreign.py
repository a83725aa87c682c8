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
from billiard_shot.game import find_game, fitted_scene
from billiard_shot.game.outcome import outcome_of_run
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
SHOTS = 60  # that the fit plays


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


def foreign(scene, stroke, errors):
    """Play a stroke in that arena. A `Simulator`."""
    theirs = replace(THEIRS, balls=scene.balls)
    velocity, spin = strike(theirs, NOISE.perturb(stroke, errors, R))
    lying = {ball: BallState(position=(x, y, R)) for ball, (x, y) in scene.balls.items()}
    lying['cue'] = BallState(lying['cue'].position, velocity, spin)
    return outcome_of_run(simulate(theirs, lying), theirs)


@lru_cache
def their_scene(fitted):
    """Return the scene with which players plan there: ours with their noise, or fitted to it."""
    ours = replace(TABLE, noise=NOISE)
    return fitted_scene(ours, foreign, shots=SHOTS) if fitted else ours


def rule(state, call, outcome):
    """Rule as in eight-ball, but a foul that does not end the rack puts the balls back."""
    ruling = find_game('eight_ball').rule(state, call, outcome)
    goes_back = bool(ruling.fouls) and state.phase != 'break' and not ruling.state.over
    return replace(ruling, restore=goes_back, spot=() if goes_back else ruling.spot)


GAME = replace(find_game('eight_ball'), name='tools.foreign', rule=rule)

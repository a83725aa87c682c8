"""Friction between balls falls with their slip, also during an impact of several balls."""

from dataclasses import replace
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tables import POOL, R, state

from billiard_shot import simulate
from billiard_shot.table.model.geometry import stiffness_of

MASS, TURNING = POOL.ball.mass, POOL.ball.inertia
BALLS = replace(POOL.contacts.ball_ball, restitution=1.0)
SCENE = replace(POOL, contacts=replace(POOL.contacts, ball_ball=BALLS))
STILL = 1e-5
"""Slip [m/s] below which the integration lets friction fall to zero."""


def integrated(speed, angle):
    """Velocities (3, 2) of balls that touch, by springs and friction in small steps."""
    stiffness = stiffness_of(MASS, BALLS.duration, 1.0)
    normals = np.array([[math.cos(angle), math.sin(angle)], [1.0, 0.0]])
    tangents = np.array([[-y, x] for x, y in normals])

    def rates(_, values):
        velocity, spin, pressed = values[:6].reshape(3, 2), values[6:9], values[9:]
        force, torque, closing = np.zeros((3, 2)), np.zeros(3), np.zeros(2)
        for i, (n, t) in enumerate(zip(normals, tangents, strict=True)):
            relative = velocity[i] - velocity[i + 1]
            closing[i] = relative @ n
            slip = relative @ t + R * (spin[i] + spin[i + 1])
            push = stiffness * max(pressed[i], 0.0)
            coefficient = BALLS.friction_fast + BALLS.friction_slow * math.exp(
                -BALLS.friction_decay * abs(slip)
            )
            rub = coefficient * push * math.tanh(slip / STILL)
            force[i] -= push * n + rub * t
            force[i + 1] += push * n + rub * t
            torque[i : i + 2] -= R * rub
        return np.concatenate([force.ravel() / MASS, torque / TURNING, closing])

    begin = np.zeros(11)
    begin[:2] = speed * normals[0]
    ended = solve_ivp(rates, (0.0, 1e-3), begin, method='LSODA', rtol=1e-8, atol=1e-9)
    return ended.y[:6, -1].reshape(3, 2)


@pytest.mark.parametrize('angle', [0.3, 0.8, 1.2])
@pytest.mark.parametrize('speed', [0.5, 2.0, 6.0])
def test_it_agrees_with_an_integration(speed, angle):
    """Balls move by up to 3 mm meanwhile, which the integration leaves out."""
    away = 2 * R * np.array([math.cos(angle), math.sin(angle)])
    velocity = speed * away / np.linalg.norm(away)
    states = {'cue': state(*-away, (*velocity, 0)), 'one': state(0, 0), 'two': state(2 * R, 0)}
    run = simulate(SCENE, states)
    found = [ball.velocity[:2] for ball in run.at(2e-3).values()]
    assert np.array(found) == pytest.approx(integrated(speed, angle), abs=0.01 * speed)


def throw(gap, speed):
    """Tangent of the angle by which a ball is thrown that another one pushes at 45 degrees."""
    away = math.sqrt(2) * R
    states = {
        'cue': state(-away, -away, (speed, speed, 0)),
        'one': state(0, 0),
        'two': state(2 * R + gap, 0),
    }
    x, y, _ = simulate(SCENE, states).at(4e-3)['two'].velocity
    return y / x


@pytest.mark.parametrize('speed', [0.5, 2.0])
def test_frozen_balls_throw_as_balls_do_that_nearly_touch(speed):
    """Before, frozen ones had the friction of balls that do not slip: 0.118 at any speed."""
    throws = [throw(gap, speed) for gap in (0.0, 1e-6, 1e-5, 3e-5, 1e-4)]
    assert np.abs(np.diff(throws)).max() < 0.015
    assert throw(0.0, 4.0) < throw(0.0, 2.0) < throw(0.0, 0.5)

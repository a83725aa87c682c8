"""Shots for the mechanical cue, its plans and goals, and a bench to run a controller on."""

from collections.abc import Callable
from dataclasses import replace
import math

from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import Scene, Stroke
from billiard_shot.cue.controller import Controller, Result, Settings
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import TipPose
from billiard_shot.cue.plan import RefusedError, ShotPlan
from billiard_shot.cue.safety import SafetyState
from billiard_shot.cue.simulated import Imperfections, SimulatedMechanism
from billiard_shot.perception.sightings import Sighting

SCENE = Scene.load('paper')
RADIUS = SCENE.ball.radius
MECHANISM = Mechanism()
HOME = np.array([0.0, 0.0, 0.5, 0.0, MECHANISM.incline_geometry.length(0.0), 0.0])

SHOTS = st.tuples(
    st.floats(-0.6, 0.6),
    st.floats(-0.6, 0.6),
    st.floats(0.0, 1.2),
    st.floats(-3.1, 3.1),
    st.floats(0.1, 6.0),
)
"""a, b, elevation, azimuth, speed"""


def random_shot(random):
    """a, b, elevation (more flat than steep ones), azimuth, speed."""
    return (
        *random.uniform(-0.6, 0.6, 2),
        random.uniform(0, 1.2) * random.random(),
        random.uniform(-math.pi, math.pi),
        random.uniform(0.1, 6.0),
    )


def contact_of(shot, ball=(0.0, 0.0)):
    a, b, elevation, azimuth, speed = shot
    stroke = Stroke.from_offsets(a, b, elevation, azimuth, speed)
    position = np.array([*ball, RADIUS]) + RADIUS * np.array(stroke.normal)
    return TipPose(position, azimuth, elevation)


def plan_of(shot, ball=(0.0, 0.0), shot_id='shot', others=None):
    tip = contact_of(shot, ball)
    start = tip.position - 0.05 * tip.along
    return ShotPlan(
        shot_id,
        tuple(start.tolist()),
        tip.quaternion,
        shot[4],
        shot[2],
        sightings({'cue': tuple(ball), **(others or {})}),
    )


def sightings(places, time=0.0):
    """Balls that lie exactly at places (x, y)."""
    return {name: Sighting(place, time=time) for name, place in places.items()}


class Bench:
    """A controller with a simulated mechanism, on a clock of its own that `run` moves on."""

    def __init__(self, imperfections=None, settings=None, seed=0):
        self.now = 0.0
        self.states: list[SafetyState] = []
        self.results: list[Result] = []
        self.strikes = []
        self.estop = False  # what is said every 10 ms; None: silence
        self.interlock = True
        self.clock_offset = 1000.0  # of the ROS clock
        self.driver = True  # whether the controller still runs
        self.mechanism = SimulatedMechanism(
            MECHANISM, imperfections or Imperfections(), 0.1, HOME, 0.0, seed
        )
        self.controller = Controller(
            MECHANISM,
            SCENE,
            settings or Settings(),
            on_state=lambda: self.states.append(self.controller.state),
            on_command=self.send,
            on_strike=self.strikes.append,
            on_result=self.results.append,
        )
        self.controller.activate()
        self.balls = {'cue': (0.0, 0.0)}  # what the camera sees; None: it has ended
        self.camera_delay = 0.0
        self.frozen_at = None  # stamp that the camera repeats, if it is frozen
        self.hidden = {}  # since when balls are not detected, by name
        self.covariance = (0.0, 0.0, 0.0)  # of every ball that is seen
        self.run(0.1)

    def send(self, command):
        if command.trajectory is None:
            self.mechanism.stop(self.now)
        else:
            self.mechanism.command(command.trajectory, self.now)

    def run(self, seconds, until: Callable[[], bool] = lambda: False):
        """Let time pass; True as soon as `until` is."""
        ticks = round(seconds / 0.002)
        for i in range(ticks):
            self.now += 0.002
            self.mechanism.advance(self.now)
            if self.driver:
                self.controller.receive_joints(*self.mechanism.measured(), self.now, self.now)
                if i % 5 == 0:
                    self.tick()
            if until():
                return True
        return False

    def tick(self):
        if self.estop is not None:
            self.controller.receive_estop(self.estop, self.now, self.now)
        if self.interlock is not None:
            self.controller.receive_interlock(self.interlock, self.now, self.now)
        time = self.now + self.clock_offset
        self.controller.receive_clock(time, self.now)
        if self.balls is not None:
            picture = (self.frozen_at or time) - self.camera_delay
            seen = {
                name: Sighting(
                    place,
                    self.covariance,
                    is_seen=name not in self.hidden,
                    time=self.hidden.get(name, picture),
                )
                for name, place in self.balls.items()
            }
            self.controller.receive_table(seen, picture, self.now, time, self.now)
        self.controller.tick(self.now)
        if self.controller.command:
            self.send(self.controller.command)

    @property
    def stamp(self):
        """Time of the ROS clock."""
        return self.now + self.clock_offset

    def hide(self, *names):
        """Detect these balls no more from now on; pictures go on."""
        self.hidden |= dict.fromkeys(names, self.stamp)

    def freeze(self):
        """Repeat the last picture from now on."""
        self.frozen_at = self.stamp

    def reach(self, state, seconds=10.0):
        assert self.run(seconds, lambda: self.controller.state is state), self.controller.reason

    def plan(self, shot=(0.2, 0.1, 0.2, 0.4, 3.0), shot_id='shot', **changes):
        """Plan that is made now, for the balls on the table."""
        plan, balls = plan_of(shot, shot_id=shot_id), sightings(self.balls or {'cue': (0.0, 0.0)})
        return replace(plan, **{'balls': balls, 'made': self.stamp} | changes)

    def execute(self, plan, remaining=60.0):
        self.controller.execute(plan, remaining, lambda: self.now)

    def send_goal(self, shot=(0.2, 0.1, 0.2, 0.4, 3.0), shot_id='shot', remaining=60.0):
        self.execute(self.plan(shot, shot_id), remaining)

    def refused(self, words, *goal, **changes):
        """Send a goal that must be refused with these words; the outcome."""
        with pytest.raises(RefusedError, match=words) as caught:
            self.send_goal(*goal, **changes)
        return caught.value.outcome

    def arm(self):
        return self.controller.arm(self.controller.shot_id, self.now)

    def play(self, shot=(0.2, 0.1, 0.2, 0.4, 3.0), shot_id='shot'):
        """Send a goal, aim, arm and fire; the result."""
        before = len(self.results)
        self.send_goal(shot, shot_id)
        self.reach(SafetyState.AIMED)
        assert self.arm().accepted
        assert self.run(10.0, lambda: len(self.results) > before), self.controller.reason
        return self.results[-1]

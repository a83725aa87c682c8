"""Shots for the mechanical cue, its plans and goals, and a bench to run a controller on."""

from collections.abc import Callable
from dataclasses import replace
import math

from hypothesis import strategies as st
import numpy as np

from billiard_shot import Scene, Stroke
from billiard_shot.cue.controller import Controller
from billiard_shot.cue.execution import Result, Settings
from billiard_shot.cue.kinematics import TipPose
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.plan import ShotPlan
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
        self.balls = {'cue': (0.0, 0.0)}  # what the camera sees; None: it has ended
        self.camera_delay = 0.0
        self.hidden_since = None  # time since which no ball is detected
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
            detected = time if self.hidden_since is None else self.hidden_since
            seen = {
                name: replace(ball, is_seen=self.hidden_since is None)
                for name, ball in sightings(self.balls, detected - self.camera_delay).items()
            }
            self.controller.receive_table(seen, self.now, time, self.now)
        self.controller.tick(self.now)
        if self.controller.command:
            self.send(self.controller.command)

    def hide(self):
        """Detect no ball from now on."""
        self.hidden_since = self.now + self.clock_offset

    def reach(self, state, seconds=10.0):
        assert self.run(seconds, lambda: self.controller.state is state), self.controller.reason

    def send_goal(self, shot=(0.2, 0.1, 0.2, 0.4, 3.0), shot_id='shot', remaining=60.0):
        self.controller.execute(plan_of(shot, shot_id=shot_id), remaining, lambda: self.now)

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

"""
A simulated mechanism: six second-order actuators that follow trajectories.

The mechanism stops by itself when commands cease. Where the acceleration of the stroke in a
trajectory exceeds the limit of the drive, the excess is taken as the reaction of the ball: the
drive releases the cue during contact.
"""

from dataclasses import dataclass
import math
from typing import ClassVar

import numpy as np

from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE
from billiard_shot.records import Array
from billiard_shot.scene.fields import boolean, CheckedRecord, number

SUBSTEP = 1e-3  # s
MAX_REST_SPEED = 1e-6  # m/s or rad/s: slower joints are at rest


@dataclass(frozen=True, slots=True)
class Imperfections(CheckedRecord):
    """
    Imperfections of the simulated mechanism; by default only the bandwidth is limited.

    Parameters
    ----------
    bandwidth : float
        Natural frequency of the control loops, which are critically damped [rad/s].
    latency : float
        Delay from a command to its effect [s].
    noise : float
        Standard deviation of the disturbance accelerations, relative to the largest
        accelerations.
    encoder_step : float
        Resolution of the encoders, relative to the range of the joint.

    """

    READ_ONLY: ClassVar = None  # as parameters of a node: all
    bandwidth: float = number('rad/s', minimum=1.0, maximum=1000.0, default=150.0)
    latency: float = number('s', minimum=0, maximum=1.0, default=0.0)
    noise: float = number('', minimum=0, maximum=1.0, default=0.0)
    encoder_step: float = number('', minimum=0, maximum=0.1, default=0.0)


@dataclass(frozen=True, slots=True)
class Faults(CheckedRecord):
    """
    Simulated faults.

    Parameters
    ----------
    stuck_incline : bool
        Fault: the actuator of the incline does not move.
    lost_encoder : bool
        Fault: all measured positions and velocities are NaN.
    late_brake : float
        Fault: delay of the brake of the stroke [s].
    command_loss_rate : float
        Fault: fraction of the commands that are lost.
    no_ball : bool
        Fault: the cue meets no ball, so only the drive slows it down.

    """

    stuck_incline: bool = boolean(default=False)
    lost_encoder: bool = boolean(default=False)
    late_brake: float = number('s', minimum=0, maximum=10.0, default=0.0)
    command_loss_rate: float = number('', minimum=0, maximum=1.0, default=0.0)
    no_ball: bool = boolean(default=False)


class SimulatedMechanism:
    """
    The mechanism, simulated by calls of `advance`; times are those of any steady clock [s].

    Parameters
    ----------
    mechanism : Mechanism
    imperfections : Imperfections
    command_timeout : float
        Time without a command after which the mechanism stops by itself [s].
    start : (6,) float array
        Joints at the start.
    now : float
        Time of the start [s].
    seed : int
        Seed of all random numbers.

    Attributes
    ----------
    stops : list of str
        Cause of each stop, and the time from the start of braking until all joints stood still.

    """

    def __init__(
        self,
        mechanism: Mechanism,
        imperfections: Imperfections,
        command_timeout: float,
        start: Array,
        now: float,
        seed: int = 0,
    ) -> None:
        self.faults = Faults()
        self.stops: list[str] = []
        self.position = np.array(start, dtype=float)  # of the actuators
        self.velocity = np.zeros(len(JOINTS))
        self._command_timeout = command_timeout
        self._flaws = imperfections
        self._limits = mechanism.accelerations
        self._range = np.array([axis.max - axis.min for axis in mechanism.axes])
        self._random = np.random.default_rng(seed)
        self._now = now
        self._last_command = -math.inf
        self._trajectory: JointTrajectory | None = None  # None: stop and hold
        self._newest: JointTrajectory | None = None  # the last trajectory that was commanded
        self._begin = now
        self._brake: tuple[str, float] | None = None  # cause and time of the current stop
        self._brake_wanted = math.inf

    @property
    def moving(self) -> bool:
        """Whether any joint moves."""
        return bool(np.any(np.abs(self.velocity) > MAX_REST_SPEED))

    @property
    def stopped(self) -> bool:
        """Whether the mechanism is at rest and follows no trajectory."""
        return self._trajectory is None and not self.moving

    def command(self, trajectory: JointTrajectory, now: float) -> None:
        """Follow a trajectory; if it is not a new object, only note that the driver is alive."""
        self.advance(now)
        if self._random.random() < self.faults.command_loss_rate:
            return
        self._last_command = now
        if trajectory is not self._newest:
            self._newest = self._trajectory = trajectory
            self._begin = now + self._flaws.latency
            self._brake, self._brake_wanted = None, math.inf

    def stop(self, now: float) -> None:
        """Brake all joints at their largest accelerations, until a new trajectory is commanded."""
        self.advance(now)
        if self._random.random() >= self.faults.command_loss_rate and self._trajectory is not None:
            self._stop('stopped by command')

    def advance(self, now: float) -> None:
        """Simulate until the time `now` [s]."""
        steps = max(math.ceil((now - self._now) / SUBSTEP - 1e-6), 0)
        if self.stopped and not self._brake:
            self._now += steps * SUBSTEP
            return
        for _ in range(steps):
            silence = self._now - self._last_command
            if self._trajectory is not None and silence > self._command_timeout:
                self._stop(f'stopped by itself: no command for {silence:.3f} s')
            self._step()
            self._now += SUBSTEP
            if self._brake and not self.moving:
                cause, began = self._brake
                self.stops.append(f'{cause}; at rest after {self._now - began:.3f} s')
                self._brake = None

    def measured(self) -> tuple[Array, Array]:
        """Return positions and speeds (6,) as the encoders measure them."""
        if self.faults.lost_encoder:
            nothing = np.full(len(JOINTS), math.nan)
            return nothing, nothing
        step = self._flaws.encoder_step * self._range
        if not step.any():
            return self.position.copy(), self.velocity.copy()
        return np.round(self.position / step) * step, self.velocity.copy()

    def _stop(self, cause: str) -> None:
        self._trajectory = None
        self._brake = cause, self._now

    def _step(self) -> None:
        held = self.position[INCLINE]
        if self._trajectory is None:
            if not self.moving:
                return
            change = np.clip(-self.velocity, -self._limits * SUBSTEP, self._limits * SUBSTEP)
        else:
            change = self._acceleration(self._trajectory) * SUBSTEP
        before = self.velocity
        self.velocity = before + change
        self.position = self.position + 0.5 * (before + self.velocity) * SUBSTEP
        if self.faults.stuck_incline:
            self.position[INCLINE], self.velocity[INCLINE] = held, 0.0

    def _acceleration(self, trajectory: JointTrajectory) -> Array:
        """Acceleration over the next step: that of the trajectory at mid-step, and the control."""
        time = self._now - self._begin
        position, velocity, _ = trajectory.at(time)
        _, _, wanted = trajectory.at(time + 0.5 * SUBSTEP)
        bandwidth = self._flaws.bandwidth
        control = (
            wanted
            + 2.0 * bandwidth * (velocity - self.velocity)
            + (bandwidth * bandwidth * (position - self.position))
        )
        drive = np.clip(wanted, -self._limits, self._limits)
        ball = np.zeros(len(JOINTS))
        if not self.faults.no_ball:
            ball[STROKE] = wanted[STROKE] - drive[STROKE]
        force = np.clip(control - ball, -self._limits, self._limits)
        if self._flaws.noise:
            force = force + self._flaws.noise * self._limits * self._random.standard_normal(
                len(JOINTS)
            )
        if self.faults.late_brake and drive[STROKE] * self.velocity[STROKE] < 0.0:
            self._brake_wanted = min(self._brake_wanted, self._now)
            if self._now < self._brake_wanted + self.faults.late_brake:
                force[STROKE] = 0.0
        return force + ball

"""
A simulated mechanism: six second-order actuators that follow paths, and stop when nobody commands.

What the path asks of the stroke beyond its drive's strength is the push of the ball that the path
was made for: a drive that lets go of the cue while it touches the ball goes along with it.
"""

from dataclasses import dataclass
import math

import numpy as np

from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE
from billiard_shot.cue.path import Array, Path
from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number, yes_or_no

SUBSTEP = 1e-3  # s
STILL = 1e-6  # m/s or rad/s: slower is at rest


@dataclass(frozen=True, slots=True)
class Imperfections:
    """
    What keeps the simulated mechanism from being perfect; by default only its bandwidth does.

    Parameters
    ----------
    bandwidth : float
        Natural frequency of the actuators' control loops, which are critically damped [rad/s].
    latency : float
        From a command to what it does [s].
    noise : float
        Standard deviation of what disturbs the joints' accelerations, relative to the largest.
    backlash : float
        Play between each actuator and what it moves, relative to the joint's range.
    encoder_step : float
        Smallest difference that the encoders tell, relative to the joint's range.

    """

    bandwidth: float = number('rad/s', above=0, most=1000.0, default=150.0)
    latency: float = number('s', least=0, most=1.0, default=0.0)
    noise: float = number('', least=0, most=1.0, default=0.0)
    backlash: float = number('', least=0, most=0.1, default=0.0)
    encoder_step: float = number('', least=0, most=0.1, default=0.0)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Faults:
    """
    Faults on request.

    Parameters
    ----------
    stuck_incline : bool
        The incline's actuator does not move.
    lost_encoder : bool
        The encoders say nothing: measured positions and speeds are not numbers.
    late_brake : float
        The stroke's drive brakes so much later than it should [s].
    dropped : float
        Fraction of the commands that are lost.
    no_ball : bool
        The cue meets no ball, and nothing but the drive slows it down.

    """

    stuck_incline: bool = yes_or_no(default=False)
    lost_encoder: bool = yes_or_no(default=False)
    late_brake: float = number('s', least=0, most=10.0, default=0.0)
    dropped: float = number('', least=0, most=1.0, default=0.0)
    no_ball: bool = yes_or_no(default=False)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Stop:
    """
    Record of a stop, on the mechanism's own clock.

    Parameters
    ----------
    commanded : bool
        True: a command to stop. False: commands ceased.
    silence : float
        Time since the last command, when the brake began [s].
    braking : float
        Time from then until all joints stood still [s].

    """

    commanded: bool
    silence: float
    braking: float


class SimulatedMechanism:
    """
    The mechanism, moved on by `advance`; times are those of any steady clock [s].

    Parameters
    ----------
    mechanism : Mechanism
    imperfections : Imperfections
    deadline : float
        After so long without a command it stops by itself [s].
    start : (6,) float array
        Joints at the beginning.
    now : float
        The time then [s].
    seed : int
        Of everything random.

    """

    def __init__(
        self,
        mechanism: Mechanism,
        imperfections: Imperfections,
        deadline: float,
        start: Array,
        now: float,
        seed: int = 0,
    ) -> None:
        self.faults = Faults()
        self.stops: list[Stop] = []
        self.position = np.array(start, dtype=float)  # of the actuators
        self.velocity = np.zeros(len(JOINTS))
        self.output = self.position.copy()  # of what they move; differs by the backlash
        self._deadline = deadline
        self._flaws = imperfections
        self._limits = mechanism.accelerations
        self._range = np.array([axis.most - axis.least for axis in mechanism.axes])
        self._random = np.random.default_rng(seed)
        self._now = now
        self._heard = -math.inf
        self._path: Path | None = None  # None: stops, and holds where it has stopped
        self._number = 0
        self._begin = now
        self._brake: tuple[bool, float, float] | None = None  # the stop under way
        self._brake_wanted = math.inf

    @property
    def moving(self) -> bool:
        """Whether any joint moves."""
        return bool(np.any(np.abs(self.velocity) > STILL))

    @property
    def stopped(self) -> bool:
        """Whether it has stopped and follows no command."""
        return self._path is None and not self.moving

    def follow(self, path: Path, number: int, now: float) -> None:
        """Follow a path; repeated under its number, it only shows that the driver is alive."""
        self.advance(now)
        if self._random.random() < self.faults.dropped:
            return
        self._heard = now
        if number > self._number:
            self._number, self._path, self._begin = number, path, now + self._flaws.latency
            self._brake, self._brake_wanted = None, math.inf

    def stop(self, now: float) -> None:
        """Brake all joints as hard as they can; only a new path makes them move again."""
        self.advance(now)
        if self._random.random() >= self.faults.dropped and self._path is not None:
            self._stop(commanded=True)

    def advance(self, now: float) -> None:
        """Move on to the time `now` [s]."""
        steps = math.ceil((now - self._now) / SUBSTEP - 1e-6)
        for _ in range(max(steps, 0)):
            if self._path is not None and self._now - self._heard > self._deadline:
                self._stop(commanded=False)
            self._step()
            self._now += SUBSTEP
            if self._brake and not self.moving:
                commanded, silence, began = self._brake
                self.stops.append(Stop(commanded, silence, self._now - began))
                self._brake = None

    def measured(self) -> tuple[Array, Array]:
        """Positions and speeds (6,) as the encoders tell them."""
        if self.faults.lost_encoder:
            nothing = np.full(len(JOINTS), math.nan)
            return nothing, nothing
        step = self._flaws.encoder_step * self._range
        if not step.any():
            return self.position.copy(), self.velocity.copy()
        return np.round(self.position / step) * step, self.velocity.copy()

    def _stop(self, *, commanded: bool) -> None:
        self._path = None
        self._brake = commanded, self._now - self._heard, self._now

    def _step(self) -> None:
        held = self.position[INCLINE]
        if self._path is None:
            if not self.moving:
                return
            change = np.clip(-self.velocity, -self._limits * SUBSTEP, self._limits * SUBSTEP)
        else:
            change = self._acceleration(self._path) * SUBSTEP
        before = self.velocity
        self.velocity = before + change
        self.position = self.position + 0.5 * (before + self.velocity) * SUBSTEP
        if self.faults.stuck_incline:
            self.position[INCLINE], self.velocity[INCLINE] = held, 0.0
        play = 0.5 * self._flaws.backlash * self._range
        self.output = np.clip(self.output, self.position - play, self.position + play)

    def _acceleration(self, path: Path) -> Array:
        """Acceleration over the coming step: what the path has in its middle, and the control."""
        time = self._now - self._begin
        position, velocity, _ = path.at(time)
        _, _, wanted = path.at(time + 0.5 * SUBSTEP)
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

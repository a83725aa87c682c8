"""What the controller goes by, what it is doing, and what it says: its data."""

from dataclasses import dataclass
import math

from billiard_shot.cue.measurement import Strike, StrokeWatch
from billiard_shot.cue.outcome import Outcome
from billiard_shot.cue.path import Path
from billiard_shot.cue.plan import PreparedShot


@dataclass(frozen=True, slots=True)
class Settings:
    """
    What the controller goes by; times in s.

    `estop_timeout`, `interlock_timeout`, `joints_timeout`: silence of these inputs means stop. If
    the controller does not run for half of the shortest one, everything heard before is stale.
    `arm_timeout`: armed for so long without firing, it disarms. `settle_time`: from armed to the
    stroke. `order_longest`: for how long an order may be valid. `late`: how late the mechanism may
    be where the path has it already. `aim_tolerance`: of each joint, relative to its range.
    `brake_tolerance`: how far [m] beyond its end the stroke may go. `table_tolerance`: how far [m]
    a ball may lie from where the plan has it.
    """

    estop_timeout: float = 0.5
    interlock_timeout: float = 0.5
    joints_timeout: float = 0.5
    arm_timeout: float = 5.0
    settle_time: float = 0.1
    order_longest: float = 600.0
    late: float = 2.0
    aim_tolerance: float = 2e-4
    brake_tolerance: float = 0.005
    table_tolerance: float = 0.001

    @property
    def longest_pause(self) -> float:
        """Longest time between two ticks after which the inputs are still trusted [s]."""
        return 0.5 * min(self.estop_timeout, self.interlock_timeout, self.joints_timeout)


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """
    What the mechanism is told: to follow a path, or to stop.

    `number` grows by one with every new command; a command is repeated under its number.
    """

    number: int
    path: Path | None  # None: stop


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """How an order ended; `strike` is what was measured, if the cue came to the ball."""

    outcome: Outcome
    message: str
    strike: Strike | None


@dataclass(slots=True, eq=False)
class Job:
    """An order that is being executed; times are those of the controller's clock [s]."""

    shot: PreparedShot
    expires: float
    watch: StrokeWatch
    armed_until: float = -math.inf
    fire_at: float = math.inf

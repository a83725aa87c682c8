"""Laws of restitution, and all numbers that steer the solver, with their units and reasons."""

from typing import NamedTuple

from billiard_shot.compiled import inner

BISTIFFNESS, ENERGETIC, POISSON = 0, 1, 2
LAWS = {'bistiffness': BISTIFFNESS, 'energetic': ENERGETIC, 'poisson': POISSON}


class Opening(NamedTuple):
    """Opening of a spring after its compression; the numbers have no unit."""

    rate: float  # opening speed of the spring relative to the speed at which the bodies part
    end: float  # compression at which the contact ends, relative to the peak
    lost: float  # share of the energy that is lost while the spring opens


@inner
def opening(law: int, restitution: float, exponent: float) -> Opening:
    """
    Return the opening of springs by a law.

    Law poisson opens a spring until its impulse is complete (events.py). The contact may then end
    before the spring is relaxed, or need more energy than the spring has.
    """
    if restitution == 0.0:
        return Opening(1.0, 1.0, 0.0)
    square = restitution * restitution
    if law == BISTIFFNESS:
        return Opening(1.0 / square, 0.0, 1.0 - square)
    if law == ENERGETIC:
        return Opening(1.0, (1.0 - square) ** (1.0 / (exponent + 1.0)), 0.0)
    return Opening(1.0, 0.0, 0.0)


@inner
def elastic_energy(stiffness: float, compression: float, exponent: float) -> float:
    """Energy in a contact's spring; zero at an open contact."""
    return stiffness * max(compression, 0.0) ** (exponent + 1.0) / (exponent + 1.0)


class Options(NamedTuple):
    """
    Options of the solver.

    They are constants of the compiled code. If a value in this file changes, the library is
    compiled again.

    Velocities are relative to the largest approach speed of the collision. Lengths of steps are in
    its unit of time, 1 / sqrt(W k) for the largest response W [1/kg] and stiffness k.

    Attributes
    ----------
    max_tolerance : float
        Loosest tolerance. A looser one would save a sixth of the steps, and lose its meaning.
    rounding : float
        Smaller velocities count as zero. They are rounding errors of velocities of size one.
    time_rounding : float
        Relative to the time at which contacts take their normals anew. They take them earlier by
        this fraction, to avoid a last step that is only rounding.
    step_share : float
        Fraction of the tolerance that a step may use up, as long as there are few steps.
    nominal_steps : int
        A collision with more steps than this takes smaller shares, because their errors add up.
    min_step_tolerance : float
        Lowest tolerance of a step, relative to the velocities: smaller errors are rounding.
    zero_slip_share : float
        Slip below this fraction of the tolerance is zero.
    max_steps : int
        Largest number of steps of a collision. More would take over 0.1 s.
    max_steps_per_contact : int
        The same per contact, if that is more.
    max_step : float
        Longest step, if nothing else ends it.
    max_redundant_step : float
        Longest step while contacts stick beyond their own cones. After every step it is checked
        again whether some division of the friction can hold them.
    rescale_interval : int
        Number of steps without an event after which the largest velocity is determined again.
    jam_speed : float
        Normal velocity below which a contact that is pressed does not move.
    swing_left : float
        Motion of a cue's end that counts as rest: its speed, and the speed that its shift causes.
    energy_floor : float
        Velocities below this fraction of the tolerance end an infinite sequence.
    negligible_force : float
        A spring force below this fraction of the tolerance counts as zero, and so does that of a
        tip if it has changed the velocity by less: with exponent 3/2 the force has no Taylor
        series at zero.
    min_softened : float
        Lowest restitution of a contact that softens with energy.
    end_margin : float
        Compression, relative to its peak, that counts as zero at the end of restitution, so that
        contacts that end together stay together.

    explicit_margin : float
        Fraction of its estimated length that an explicit step takes. The estimate covers only the
        first terms that the polynomials leave out.
    max_rescale : float
        Largest factor between the scales of successive explicit steps. Coefficients are powers of
        the scale, and could overflow.
    direction_error : float
        Largest error of a slip direction in a step.
    min_remaining_slip : float
        Fraction of the slip that a step leaves. The series of its direction ends at zero slip.
    planar_slip : float
        Slip that turns by less than this fraction of the tolerance in a step counts as straight.

    creeping_share : float
        A slip is stiff, and needs implicit steps, if it is below this fraction of the change that
        friction can cause within the step.
    implicit_cost : int
        An implicit step with n stiff contacts counts as 1 + `implicit_cost` n^2 steps.
    implicit_factor : float
        Tolerance of an implicit step relative to an explicit one: its errors count for more.
    min_implicit_tolerance : float
        Lowest tolerance of an implicit step, relative to the velocities.
    first_implicit_factor : float
        Length of the first implicit step relative to the explicit one before it.
    min_implicit_step : float
        Shortest implicit step. A slip onset that needs a shorter one is cancelled.
    implicit_margin : float
        Fraction of its estimated length that the next implicit step takes, because a step that is
        too long is solved in vain.
    min_growth, max_growth : float
        Smallest and largest factor between the lengths of successive implicit steps: the estimate
        does not hold beyond.
    retry_margin : float
        Fraction of its estimated length that an implicit step takes if the error of a longer one
        was too large.
    min_retry : float
        Smallest factor by which such a step is shortened.
    divergence_factor : float
        Factor by which a step is shortened if no solution was found.
    max_iterations : int
        Largest number of iterations of an implicit step. A step that needs more is shortened.
    stalling : float
        Iterations do not converge if their changes stay above this fraction of those before.
    min_contraction : float
        Smallest factor by which the changes are assumed to shrink in an iteration.
    iteration_share : float
        Fraction of the tolerance by which the remaining iterations may still change a step.
    min_iteration_share : float
        Fraction of the tolerance that is always allowed as the last change.
    min_turn : float
        Turn of a slip direction [rad] that is only rounding.

    least_lag : float
        Time in which the shear of a contact follows its slip, below which it follows at once. The
        slip turns by 1e-4 rad in it.
    aligned : float
        Cosine of the largest angle between slip and shear at which that begins.

    max_friction_sweeps : int
        Largest number of sweeps over contacts that share friction. They converge in far fewer, or
        not at all.
    cone_margin : float
        A force within this fraction of its friction cone counts as on the cone.
    min_yield : float
        Tangential response of a contact, relative to that of its bodies alone, above which it can
        slip: below, other contacts hold it.
    onset_noise, division_noise : float
        Tangential acceleration, relative to its terms, that is only rounding: when slip begins,
        and when contacts share friction, whose division is iterated.

    tail_after : int
        Events after which a sequence of impacts may be summed as a geometric series.
    max_section_events : int
        Events without the end of a section (kernel.py), after which another contact is
        chosen to count sections by.
    max_tail_ratio : float
        A sequence that decays more slowly is not summed as a series: its differences are only
        rounding.
    tail_share : float
        Fraction of the tolerance that the sum may use up.

    imbalance : float
        Energy imbalance, relative to the tolerance, above which the tolerance was not reached.
    min_imbalance : float
        Smallest energy imbalance that counts.

    """

    max_tolerance: float = 1e-6
    rounding: float = 1e-14
    time_rounding: float = 1e-12
    step_share: float = 0.2
    nominal_steps: int = 300
    min_step_tolerance: float = 1e-16
    zero_slip_share: float = 0.02
    max_steps: int = 20_000
    max_steps_per_contact: int = 2_000
    max_step: float = 1e100
    max_redundant_step: float = 0.005
    rescale_interval: int = 16
    jam_speed: float = 1e-12
    swing_left: float = 0.02
    energy_floor: float = 0.01
    negligible_force: float = 1e-3
    min_softened: float = 0.05
    end_margin: float = 1e-14

    explicit_margin: float = 0.9
    max_rescale: float = 1e3
    direction_error: float = 1e-3
    min_remaining_slip: float = 0.05
    planar_slip: float = 0.1

    creeping_share: float = 0.1
    implicit_cost: int = 4
    implicit_factor: float = 0.1
    min_implicit_tolerance: float = 1e-15
    first_implicit_factor: float = 0.05
    min_implicit_step: float = 1e-14
    implicit_margin: float = 0.8
    min_growth: float = 0.2
    max_growth: float = 4.0
    retry_margin: float = 0.7
    min_retry: float = 0.1
    divergence_factor: float = 0.25
    max_iterations: int = 25
    stalling: float = 0.8
    min_contraction: float = 1e-3
    iteration_share: float = 0.3
    min_iteration_share: float = 0.03
    min_turn: float = 1e-15

    least_lag: float = 0.02
    aligned: float = 1.0 - 1e-6

    max_friction_sweeps: int = 300
    cone_margin: float = 1e-12
    min_yield: float = 1e-9
    onset_noise: float = 1e-12
    division_noise: float = 1e-9

    tail_after: int = 100
    max_section_events: int = 100
    max_tail_ratio: float = 0.9999
    tail_share: float = 0.1

    imbalance: float = 1e4
    min_imbalance: float = 1e-8


METHOD_OPTIONS = Options()


@inner
def negligible_speed(tolerance: float) -> float:
    """Speed of a contact, relative to the largest one, below which its motion has died down."""
    return max(METHOD_OPTIONS.energy_floor * tolerance, 10.0 * METHOD_OPTIONS.rounding)

"""All numbers that steer the solver, each with its unit and its reason."""

from typing import NamedTuple


class Options(NamedTuple):
    """
    Options of the solver.

    Velocities are relative to the largest approach speed of the collision. Lengths of steps are in
    its unit of time, 1 / sqrt(W k) for the largest response W [1/kg] and stiffness k.

    Attributes
    ----------
    max_tolerance : float
        Loosest tolerance. A looser one would save a sixth of the steps, and lose its meaning.
    rounding : float
        Velocities below are zero. They are rounding errors of velocities of size one.
    step_share : float
        Fraction of the tolerance that a step may use up, as long as there are few steps.
    nominal_steps : int
        A collision with more steps than this takes smaller shares, because their errors add up.
    min_step_tolerance : float
        Lowest tolerance of a step, relative to the velocities: nothing finer can be seen.
    zero_slip_share : float
        Slip below this fraction of the tolerance is zero.
    max_steps : int
        Steps of a collision. More of them would take more than 0.1 s.
    max_steps_per_contact : int
        The same per contact, where that is more.
    implicit_cost : int
        An implicit step counts as so many, times the square of its stiff contacts.
    implicit_factor : float
        Tolerance of an implicit step relative to an explicit one: its errors count for more.
    min_implicit_tolerance : float
        Lowest tolerance of an implicit step, relative to the velocities.
    first_implicit_factor : float
        Length of the first implicit step relative to the explicit one before it.
    min_implicit_step : float
        A slip whose implicit step would be shorter does not begin at all.
    max_redundant_step : float
        Longest step while contacts stick beyond their own cones. After every step is it asked
        again whether any division of friction can hold them.
    max_step : float
        Longest step, where nothing would end it.
    rescale_interval : int
        Steps without an event after which velocities may have grown unnoticed.
    jam_speed : float
        Normal velocity below which a contact that is pressed does not move.
    energy_floor : float
        Velocities below this fraction of the tolerance end an infinite sequence.
    negligible_force : float
        A spring whose velocity is below this fraction of the tolerance exerts no force: with
        exponent 3/2 the force has no Taylor series at zero.
    min_remaining_slip : float
        Fraction of the slip that a step leaves. The series of its direction ends where slip does.
    planar_slip : float
        Slip that turns by less than this fraction of the tolerance in a step moves on a line.
    direction_error : float
        Largest error of a slip direction in a step.
    tail_after : int
        Events after which a sequence of impacts may be summed as a geometric series.
    imbalance : float
        Energy imbalance, in tolerances, above which the tolerance was not reached,
    min_imbalance : float
        and the lowest imbalance that counts.

    """

    max_tolerance: float = 1e-6
    rounding: float = 1e-14
    step_share: float = 0.2
    nominal_steps: int = 300
    min_step_tolerance: float = 1e-16
    zero_slip_share: float = 0.02
    max_steps: int = 20_000
    max_steps_per_contact: int = 2_000
    implicit_cost: int = 4
    implicit_factor: float = 0.1
    min_implicit_tolerance: float = 1e-15
    first_implicit_factor: float = 0.05
    min_implicit_step: float = 1e-14
    max_redundant_step: float = 0.005
    max_step: float = 1e100
    rescale_interval: int = 16
    jam_speed: float = 1e-12
    energy_floor: float = 0.01
    negligible_force: float = 1e-3
    min_remaining_slip: float = 0.05
    planar_slip: float = 0.1
    direction_error: float = 1e-3
    tail_after: int = 100
    imbalance: float = 1e4
    min_imbalance: float = 1e-8


DEFAULT_OPTIONS = Options()

"""Clocks that stand still or jump back are named; all others are trusted."""

import time

import pytest

from billiard_shot.cue.inputs import CLOCK_RECOVERY, ClockWatch, steady_time


@pytest.fixture
def clock():
    """Return a watch that has seen a clock run for a second."""
    watch = ClockWatch('ROS clock', timeout=0.25)
    for step in range(51):
        watch.update(100.0 + 0.02 * step, 0.02 * step)
    assert watch.problem(1.0) == ''
    return watch


def test_a_clock_that_is_never_read_is_not_judged():
    assert ClockWatch('ROS clock', 0.25).problem(1.0) == ''


def test_simulated_time_without_a_clock():
    watch = ClockWatch('ROS clock', 0.25)
    watch.update(0.0, 1.0)
    assert watch.problem(1.0) == (
        'ROS clock: has not started: no message received on /clock (use_sim_time)'
    )


def test_standing_still(clock):
    clock.update(101.0, 1.2)
    assert clock.problem(1.2) == ''
    clock.update(101.0, 1.3)
    assert clock.problem(1.3) == 'ROS clock: has stood still for 0.3 s'
    clock.update(101.1, 1.4)
    assert clock.problem(1.4) == ''


def test_jumping_back(clock):
    clock.update(90.0, 1.02)
    assert clock.problem(1.02) == 'ROS clock: jumped back by 11 s'
    clock.update(90.0 + CLOCK_RECOVERY, 1.0 + CLOCK_RECOVERY)
    assert 'jumped back' in clock.problem(1.0 + CLOCK_RECOVERY)
    clock.update(90.1 + CLOCK_RECOVERY, 1.1 + CLOCK_RECOVERY)
    assert clock.problem(1.1 + CLOCK_RECOVERY) == ''


def test_jumping_ahead(clock):
    clock.update(3701.0, 1.02)
    assert clock.problem(1.02) == 'ROS clock: jumped ahead by 3.6e+03 s'
    clock.update(3701.1 + CLOCK_RECOVERY, 1.1 + CLOCK_RECOVERY)
    assert clock.problem(1.1 + CLOCK_RECOVERY) == ''


def test_corrections_pauses_and_the_first_time_are_no_jumps(clock):
    clock.update(100.995, 1.02)
    assert clock.problem(1.02) == ''
    clock.update(130.995, 31.02)  # this process was suspended
    assert clock.problem(31.02) == ''
    started = ClockWatch('ROS clock', 0.25)
    started.update(0.0, 1.0)
    started.update(1.7e9, 1.02)
    assert started.problem(1.02) == ''


def test_a_quick_simulator_is_no_jump():
    """Ten times faster than real time, with ten messages a second."""
    watch = ClockWatch('ROS clock', 0.25)
    for step in range(500):
        watch.update(1.0 + float(step // 5), 0.02 * step)
        assert watch.problem(0.02 * step) == ''


@pytest.mark.skipif(not hasattr(time, 'CLOCK_BOOTTIME'), reason='Linux alone has this clock')
def test_the_steady_clock_goes_on_while_the_machine_is_suspended():
    before = time.clock_gettime(time.CLOCK_BOOTTIME)
    assert before <= steady_time() <= time.clock_gettime(time.CLOCK_BOOTTIME)

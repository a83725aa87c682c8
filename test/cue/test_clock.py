"""Clocks that stand still or jump back are named; all others are trusted."""

import pytest

from billiard_shot.cue.clock import ClockWatch, RECOVERY


@pytest.fixture
def clock():
    """Return a watch that has seen a clock run for a second."""
    watch = ClockWatch('ROS clock', patience=0.25)
    for step in range(51):
        watch.see(100.0 + 0.02 * step, 0.02 * step)
    assert watch.complaint(1.0) == ''
    return watch


def test_a_clock_that_is_never_read_is_not_judged():
    assert ClockWatch('ROS clock', 0.25).complaint(1.0) == ''


def test_simulated_time_without_a_clock():
    watch = ClockWatch('ROS clock', 0.25)
    watch.see(0.0, 1.0)
    assert watch.complaint(1.0) == (
        'ROS clock: has not started: nothing was heard on /clock (use_sim_time)'
    )


def test_standing_still(clock):
    clock.see(101.0, 1.2)
    assert clock.complaint(1.2) == ''
    clock.see(101.0, 1.3)
    assert clock.complaint(1.3) == 'ROS clock: has stood still for 0.3 s'
    clock.see(101.1, 1.4)
    assert clock.complaint(1.4) == ''


def test_jumping_back(clock):
    clock.see(90.0, 1.02)
    assert clock.complaint(1.02) == 'ROS clock: jumped back by 11 s'
    clock.see(90.0 + RECOVERY, 1.0 + RECOVERY)
    assert 'jumped back' in clock.complaint(1.0 + RECOVERY)
    clock.see(90.1 + RECOVERY, 1.1 + RECOVERY)
    assert clock.complaint(1.1 + RECOVERY) == ''


def test_corrections_and_jumps_ahead_are_allowed(clock):
    clock.see(100.995, 1.02)
    assert clock.complaint(1.02) == ''
    clock.see(500.0, 1.04)
    assert clock.complaint(1.04) == ''

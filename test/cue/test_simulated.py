from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
from plans import HOME, MECHANISM, plan_of, SCENE
import pytest

from billiard_shot.cue.mechanism import INCLINE, STROKE
from billiard_shot.cue.plan import aim_trajectory, prepare_shot
from billiard_shot.cue.simulated import Faults, Imperfections, SimulatedMechanism

PREPARED = prepare_shot(MECHANISM, SCENE, plan_of((0.2, 0.1, 0.2, 0.4, 4.0)))
DEADLINE = 0.1


def simulated(imperfections=None, start=HOME):
    return SimulatedMechanism(MECHANISM, imperfections or Imperfections(), DEADLINE, start, 0.0, 7)


def follow(mechanism, trajectory, seconds, begin=0.0, period=0.02):
    """Command a trajectory over and over; the time afterwards."""
    for time in np.arange(begin, begin + seconds, period):
        mechanism.command(trajectory, time)
    mechanism.advance(begin + seconds)
    return begin + seconds


def test_follows_a_path_that_keeps_its_limits():
    mechanism = simulated()
    trajectory = aim_trajectory(MECHANISM, HOME, PREPARED.aimed)
    time = follow(mechanism, trajectory, trajectory.duration + 0.1)
    np.testing.assert_allclose(mechanism.position, PREPARED.aimed, atol=1e-9)
    stroke = PREPARED.stroke
    begin = time
    while time < begin + stroke.trajectory.duration:
        mechanism.command(stroke.trajectory, time)
        position, _, _ = stroke.trajectory.at(time - begin)
        assert abs(mechanism.position[STROKE] - position[STROKE]) < 1e-3
        if begin + stroke.contact - 0.01 < time < begin + stroke.contact:
            assert mechanism.velocity[STROKE] == pytest.approx(4.0, rel=1e-3)
        time += 0.001


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 3.0))
def test_stops_by_itself_when_commands_cease(moment):
    mechanism = simulated()
    trajectory = aim_trajectory(MECHANISM, HOME, PREPARED.aimed)
    follow(mechanism, trajectory, moment)
    slowest = max(MECHANISM.speeds[:STROKE] / MECHANISM.accelerations[:STROKE])
    mechanism.advance(moment + DEADLINE + slowest + 0.01)
    assert mechanism.stopped
    where = mechanism.position.copy()
    mechanism.advance(moment + 10.0)
    np.testing.assert_array_equal(mechanism.position, where)


def test_a_stroke_whose_driver_dies_brakes():
    """At every moment of the stroke: within deadline and brake the cue stands still."""
    stroke = PREPARED.stroke
    for moment in np.linspace(0.0, stroke.trajectory.duration, 40):
        mechanism = simulated(start=PREPARED.aimed)
        follow(mechanism, stroke.trajectory, moment, period=0.01)
        mechanism.advance(moment + DEADLINE + 4.0 / MECHANISM.stroke.acceleration + 0.5)
        assert mechanism.stopped


def test_stop_brakes_at_once_and_voids_the_path():
    mechanism = simulated(start=PREPARED.aimed)
    stroke = PREPARED.stroke
    follow(mechanism, stroke.trajectory, stroke.contact - 0.01, period=0.01)
    speed = mechanism.velocity[STROKE]
    assert speed == pytest.approx(4.0, rel=1e-3)
    now = stroke.contact - 0.01
    mechanism.stop(now)
    mechanism.command(stroke.trajectory, now)  # a late repetition
    mechanism.advance(now + speed / MECHANISM.stroke.acceleration + 0.001)
    assert mechanism.stopped


def test_imperfections():
    trajectory = aim_trajectory(MECHANISM, HOME, PREPARED.aimed)
    late = simulated(Imperfections(latency=0.05))
    follow(late, trajectory, 0.5)
    on_time = simulated()
    follow(on_time, trajectory, 0.45)
    np.testing.assert_allclose(late.position, on_time.position, atol=1e-9)

    coarse = simulated(Imperfections(encoder_step=0.01))
    follow(coarse, trajectory, trajectory.duration + 0.1)
    step = 0.01 * MECHANISM.stroke.max
    measured, _ = coarse.measured()
    assert measured[STROKE] / step == pytest.approx(round(measured[STROKE] / step))
    assert abs(measured - coarse.position).max() > 1e-4

    noisy, again = simulated(Imperfections(noise=0.05)), simulated(Imperfections(noise=0.05))
    follow(noisy, trajectory, 1.0)
    follow(again, trajectory, 1.0)
    np.testing.assert_array_equal(noisy.position, again.position)
    assert 0.0 < abs(noisy.position - trajectory.at(1.0)[0]).max() < 0.02


def test_faults():
    trajectory = aim_trajectory(MECHANISM, HOME, PREPARED.aimed)
    stuck = simulated()
    stuck.faults = Faults(stuck_incline=True)
    follow(stuck, trajectory, trajectory.duration)
    assert stuck.position[INCLINE] == HOME[INCLINE]
    blind = simulated()
    blind.faults = Faults(lost_encoder=True)
    assert np.isnan(blind.measured()).all()
    deaf = simulated()
    deaf.faults = Faults(command_loss_rate=1.0)
    follow(deaf, trajectory, 0.5)
    np.testing.assert_array_equal(deaf.position, HOME)
    for faults in (Faults(late_brake=0.03), Faults(no_ball=True)):
        broken = simulated(start=PREPARED.aimed)
        broken.faults = faults
        worst_case_stop = 0.0
        for time in np.arange(0.0, PREPARED.stroke.stop + 0.05, 0.001):
            broken.command(PREPARED.stroke.trajectory, time)
            worst_case_stop = max(worst_case_stop, broken.position[STROKE])
        assert worst_case_stop > PREPARED.profile.stop_at + 0.005
        if faults.no_ball:  # which plans allow for
            assert worst_case_stop < PREPARED.profile.worst_case_stop + 1e-3
    with pytest.raises(ValueError, match=r'command_loss_rate must be .*, got 2'):
        Faults(command_loss_rate=2)

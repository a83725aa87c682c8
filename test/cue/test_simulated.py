from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
from plans import HOME, MECHANISM, plan_of, SCENE
import pytest
from quintic import quintic

from billiard_shot.cue.controller import StrikeDetector
from billiard_shot.cue.joint_trajectory import excerpt, stroke_trajectory, StrokeProfile
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


# --- A part of a trajectory follows the trajectory, and brakes within the limits -----------------

SHOT = prepare_shot(MECHANISM, SCENE, plan_of((0.1, 0.2, 0.3, 0.5, 2.0)))
AIM = aim_trajectory(MECHANISM, HOME, SHOT.aimed)
LOW, HIGH = np.array([(axis.min, axis.max) for axis in MECHANISM.axes]).T


@settings(max_examples=60, deadline=None)
@given(st.floats(0.01, 0.999))
@pytest.mark.parametrize('trajectory', [AIM, SHOT.stroke.trajectory], ids=['aim', 'stroke'])
def test_it_follows_the_trajectory_and_then_brakes(trajectory, fraction):
    end = fraction * trajectory.duration
    if trajectory is not AIM:  # a stroke is cut only after the cue is drawn back
        end = SHOT.stroke.home + fraction * (trajectory.duration - SHOT.stroke.home)
    part = excerpt(trajectory, end, MECHANISM.accelerations)
    assert (np.diff(part.times) > 0.0).all()
    for time in np.linspace(0.0, end * (1 - 1e-9), 40):
        np.testing.assert_allclose(quintic(part, time)[0], trajectory.at(time)[0], atol=1e-9)
    assert not part.velocities[-1].any()
    for time in np.linspace(end, part.duration, 40):
        position, _, acceleration = quintic(part, time)
        assert (position >= LOW - 1e-9).all()
        assert (position <= HIGH + 1e-9).all()
        assert (np.abs(acceleration) <= 2.0 * MECHANISM.accelerations).all()


def test_the_end_of_a_trajectory_is_the_whole_trajectory():
    assert excerpt(AIM, AIM.duration, MECHANISM.accelerations) is AIM


# --- the measured speed of a strike, from joints that arrive seldom, or not at all ---------------

PERIOD = 0.01
"""Time between two messages [s]."""


def strike(speed, drive, random, loss):
    """Play a stroke with a drive of some bandwidth; the true speed, and the measured one."""
    profile = StrokeProfile(MECHANISM, speed, 0.4 * speed, 0.002, 150.0, 150.0)
    stroke = stroke_trajectory(profile, HOME, HOME[2])
    mechanism = SimulatedMechanism(
        MECHANISM, Imperfections(bandwidth=drive, noise=0.002), 1.0, HOME, 0.0, random.integers(99)
    )
    mechanism.command(stroke.trajectory, 0.0)
    detector = StrikeDetector(profile)
    true, now = None, random.uniform(0.0, PERIOD)
    while now < stroke.stop:
        while mechanism._now < now:
            before = mechanism.velocity[STROKE]
            mechanism.advance(mechanism._now + 1e-3)
            if true is None and mechanism.position[STROKE] >= profile.contact_at:
                true = before
        if random.random() >= loss:
            detector.update(*mechanism.measured())
        now += PERIOD
    return true, detector.strike and detector.strike.speed


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 5.5))
def test_the_speed_is_that_of_the_contact_or_it_is_not_measured(seed, speed):
    random = np.random.default_rng(seed)
    true, measured = strike(speed, random.uniform(120.0, 300.0), random, 0.1)
    assert measured is None or measured == pytest.approx(true, rel=0.02)


@pytest.mark.parametrize(('loss', 'least'), [(0.0, 95), (0.1, 80)])
def test_nearly_all_strikes_are_measured(loss, least):
    """The distance at constant speed lasts for two messages."""
    random = np.random.default_rng(1)
    strokes = [strike(random.uniform(0.1, 5.5), 150.0, random, loss) for _ in range(100)]
    assert sum(measured is not None for _, measured in strokes) >= least

"""The controller with the simulated mechanism: whole shots, and everything that goes wrong."""

import math

from hypothesis import given, settings
import numpy as np
from plans import Bench, contact_of, MECHANISM, SCENE, SHOTS
import pytest

from billiard_shot.cue.controller import Settings
from billiard_shot.cue.mechanism import INCLINE, STROKE
from billiard_shot.cue.plan import GoalOutcome, RefusedError
from billiard_shot.cue.safety import BEFORE_STROKE, MOVING, SafetyState
from billiard_shot.cue.simulated import Faults, Imperfections

SHOT = (0.2, 0.1, 0.2, 0.4, 3.0)
WAY = [*MOVING, SafetyState.DISARMED]


@pytest.fixture
def bench():
    return Bench()


def test_a_shot_from_goal_to_rest(bench):
    result = bench.play(SHOT)
    assert result.outcome is GoalOutcome.OK
    assert bench.states == WAY
    (strike,) = bench.strikes
    assert result.strike is strike
    wanted = contact_of(SHOT)
    assert strike.speed == pytest.approx(3.0, rel=1e-3)
    assert strike.tip.elevation == pytest.approx(0.2, abs=math.radians(0.001))
    np.testing.assert_allclose(strike.tip.position, wanted.position, atol=1e-6)
    assert not bench.mechanism.moving
    assert abs(bench.mechanism.position[STROKE]) < 1e-9


@settings(max_examples=15, deadline=None)
@given(SHOTS)
def test_speed_and_angle_are_reached(shot):
    """Within 0.5 % and 0.02 degrees, with the noise-free mechanism."""
    bench = Bench()
    try:
        result = bench.play(shot)
    except RefusedError:
        return
    assert result.outcome is GoalOutcome.OK
    assert result.strike.speed == pytest.approx(shot[4], rel=5e-3)
    assert result.strike.tip.elevation == pytest.approx(shot[2], abs=math.radians(0.02))


def test_shots_in_a_row(bench):
    random = np.random.default_rng(3)
    shots = [
        (
            *random.uniform(-0.2, 0.2, 2),
            0.3 * random.random(),
            random.uniform(-3, 3),
            random.uniform(0.2, 4.0),
        )
        for _ in range(20)
    ]
    for i, shot in enumerate(shots):
        bench.states.clear()
        bench.send_goal(shot, f'shot {i}')
        bench.reach(SafetyState.AIMED)
        assert bench.arm().accepted
        bench.reach(SafetyState.DISARMED)
        assert bench.results[-1].outcome is GoalOutcome.OK
        assert bench.states == WAY
    assert len(bench.strikes) == 20


def in_state(bench, state):
    bench.send_goal(SHOT)
    bench.reach(
        SafetyState.AIMED
        if state in (SafetyState.ARMED, SafetyState.FIRING, SafetyState.RETRACTING)
        else state
    )
    if state not in (SafetyState.AIMING, SafetyState.AIMED):
        assert bench.arm().accepted
        bench.reach(state)


@pytest.mark.parametrize('state', MOVING)
def test_estop_stops_at_once_and_latches(bench, state):
    in_state(bench, state)
    before = bench.now
    bench.controller.receive_estop(True, bench.now, bench.now)
    assert bench.controller.state is SafetyState.ESTOP
    assert bench.now == before, 'in the same call'
    assert bench.results[-1].outcome is GoalOutcome.ESTOP
    bench.estop = False
    bench.run(1.5)
    assert bench.controller.state is SafetyState.ESTOP
    assert bench.mechanism.stopped
    assert bench.refused('aim: not possible in state ESTOP, only in DISARMED', SHOT, 'again')
    assert bench.controller.clear(bench.now).accepted
    assert bench.play(SHOT, 'later').outcome is GoalOutcome.OK


@pytest.mark.parametrize('state', [SafetyState.DISARMED, *MOVING])
def test_what_is_not_active_moves_nothing(bench, state):
    """Before, a goal that waited while the node was deactivated moved the cue by up to 2 m."""
    if state is not SafetyState.DISARMED:
        in_state(bench, state)
    bench.controller.deactivate(bench.now, 'the node is not active', 'deactivated')
    assert bench.controller.state is SafetyState.DISARMED
    assert [result.outcome for result in bench.results] == (
        [GoalOutcome.DISARMED] if state in MOVING else []
    ), 'the goal has ended already'
    bench.run(1.5)
    assert bench.mechanism.stopped
    there = bench.mechanism.position.copy()
    assert bench.refused('needs: the node is active', SHOT, 'later') is GoalOutcome.NOT_READY
    assert not bench.arm().accepted
    bench.run(3.0)
    assert (bench.mechanism.position == there).all()
    bench.controller.receive_estop(True, bench.now, bench.now)
    assert bench.controller.state is SafetyState.ESTOP, 'a press is heard all the same'
    assert 'the node is active' in bench.controller.clear(bench.now).reason
    bench.controller.activate()
    bench.run(0.02)  # the button is released
    assert bench.controller.clear(bench.now).accepted
    assert bench.play(SHOT, 'at last').outcome is GoalOutcome.OK


def test_a_state_from_before_the_start_stays_until_it_is_cleared():
    bench = Bench()
    bench.controller.restore(SafetyState.FAULT, 'base_x: 3 m off')
    bench.controller.configure(MECHANISM, SCENE, Settings())
    bench.controller.activate()
    bench.run(5.0)
    assert bench.controller.state is SafetyState.FAULT
    assert bench.controller.reason == 'before this start: base_x: 3 m off'
    assert bench.refused('not possible in state FAULT', SHOT)
    assert bench.controller.clear(bench.now).accepted
    assert bench.play(SHOT).outcome is GoalOutcome.OK


@pytest.mark.parametrize('state', MOVING)
@pytest.mark.parametrize('name', ['estop', 'interlock'])
def test_silence_stops(name, state):
    bench = Bench(settings=Settings(estop_timeout=0.05, interlock_timeout=0.05))
    in_state(bench, state)
    setattr(bench, name, None)
    bench.run(0.07)
    bench.run(1.5)
    assert bench.mechanism.stopped
    stroke = state not in BEFORE_STROKE
    wanted = (
        SafetyState.ESTOP
        if name == 'estop'
        else SafetyState.FAULT
        if stroke
        else SafetyState.DISARMED
    )
    assert bench.controller.state is wanted
    assert f'{name}: no message for' in bench.controller.reason
    assert bench.results[-1].outcome is not GoalOutcome.OK


def pause(bench, seconds=1.0):
    """Stop the controller alone; messages wait meanwhile and come in afterwards."""
    before = bench.now
    bench.driver = False
    bench.run(seconds)
    bench.driver = True
    bench.controller.receive_estop(False, before + 0.5 * seconds, bench.now)
    bench.controller.receive_interlock(True, before + 0.5 * seconds, bench.now)
    bench.controller.receive_joints(*bench.mechanism.measured(), before + 0.5 * seconds, bench.now)


@pytest.mark.parametrize('state', MOVING)
def test_a_pause_of_the_controller_ends_the_shot(bench, state):
    """What waited meanwhile is no permission, neither to arm nor to clear."""
    in_state(bench, state)
    pause(bench)
    assert not bench.arm().accepted
    stroke = state not in BEFORE_STROKE
    assert bench.controller.state is (SafetyState.FAULT if stroke else SafetyState.DISARMED)
    assert 'this process did not run for 1' in bench.controller.reason
    assert bench.results[-1].outcome is (GoalOutcome.FAULT if stroke else GoalOutcome.DISARMED)
    assert not bench.controller.clear(bench.now).accepted
    words = 'only in DISARMED' if stroke else 'estop: not trusted for another 4 s'
    assert bench.refused(words, SHOT, 'too early')
    bench.run(4.1)
    assert bench.mechanism.stopped
    assert not stroke or bench.controller.clear(bench.now).accepted
    assert bench.play(SHOT, 'later').outcome is GoalOutcome.OK


@pytest.mark.parametrize('latch', [SafetyState.ESTOP, SafetyState.FAULT])
def test_a_latch_is_not_cleared_by_messages_that_waited(bench, latch):
    if latch is SafetyState.ESTOP:
        bench.controller.receive_estop(True, bench.now, bench.now)
    else:
        bench.controller.fail(bench.now, 'for the test')
    bench.run(0.1)
    pause(bench)
    refused = bench.controller.clear(bench.now)
    assert not refused.accepted
    assert 'estop: not trusted for another 4 s, because this process paused' in refused.reason
    bench.run(4.1)
    assert bench.controller.clear(bench.now).accepted


def test_a_short_pause_is_allowed(bench):
    in_state(bench, SafetyState.AIMED)
    pause(bench, 0.09)
    bench.run(0.05)
    assert bench.controller.state is SafetyState.AIMED


def test_a_press_counts_however_old_it_is(bench):
    in_state(bench, SafetyState.AIMING)
    bench.controller.receive_estop(True, bench.now - 5.0, bench.now)
    assert bench.controller.state is SafetyState.ESTOP


@pytest.mark.parametrize('state', [SafetyState.DISARMED, *MOVING])
def test_another_driver_is_a_fault(bench, state):
    if state is not SafetyState.DISARMED:
        in_state(bench, state)
    rival = 'another node commands the mechanism: /other/cue_driver'
    for _ in range(3):
        bench.controller.receive_commands(rival, rival, False, bench.now)
        bench.run(0.05)
    assert bench.controller.state is SafetyState.FAULT
    assert bench.states.count(SafetyState.FAULT) == 1
    assert bench.controller.reason == rival
    assert '/other/cue_driver' in bench.controller.clear(bench.now).reason
    bench.controller.receive_commands('', '', False, bench.now)
    assert bench.controller.clear(bench.now).accepted


@pytest.mark.parametrize('state', BEFORE_STROKE)
@pytest.mark.parametrize(('jump', 'way'), [(-100.0, 'back'), (3600.0, 'ahead')])
def test_a_clock_that_jumps_disarms(bench, state, jump, way):
    in_state(bench, state)
    bench.clock_offset += jump
    bench.run(0.02)
    assert bench.controller.state is SafetyState.DISARMED
    assert bench.controller.reason.startswith(f'ROS clock: jumped {way} by {abs(jump):.3g} s')
    assert bench.refused(f'jumped {way} by', SHOT, 'again')


def test_a_goal_that_has_expired_on_its_own_clock_is_not_fired(bench):
    """A step of the clock that is too small for a jump."""
    bench.send_goal(SHOT, remaining=5.0)
    bench.reach(SafetyState.AIMED)
    left = 5.0 - bench.now
    bench.clock_offset += 0.9
    bench.run(left - 0.5)
    assert bench.controller.state is SafetyState.DISARMED
    assert bench.results[-1].outcome is GoalOutcome.EXPIRED
    assert not bench.arm().accepted


@pytest.mark.parametrize('state', MOVING)
def test_interlock_opened(bench, state):
    in_state(bench, state)
    bench.interlock = False
    bench.controller.receive_interlock(False, bench.now, bench.now)
    stroke = state not in BEFORE_STROKE
    assert bench.controller.state is (SafetyState.FAULT if stroke else SafetyState.DISARMED)
    assert bench.results[-1].outcome is (GoalOutcome.FAULT if stroke else GoalOutcome.DISARMED)
    bench.run(1.5)
    assert bench.mechanism.stopped
    if stroke:
        assert bench.controller.clear(bench.now).accepted
    assert bench.refused('interlock: is false', SHOT, 'again')


@pytest.mark.parametrize('state', MOVING)
def test_a_dead_driver_stops_the_mechanism(bench, state):
    in_state(bench, state)
    bench.driver = False
    bench.run(0.1 + 0.6)
    assert bench.mechanism.stopped


@pytest.mark.parametrize('state', BEFORE_STROKE)
def test_disarm(bench, state):
    in_state(bench, state)
    assert bench.controller.disarm(bench.now, 'by hand', GoalOutcome.CANCELED).accepted
    assert bench.results[-1].outcome is GoalOutcome.CANCELED
    assert bench.results[-1].message == 'by hand'
    bench.run(1.0)
    assert bench.mechanism.stopped
    assert bench.controller.state is SafetyState.DISARMED


@pytest.mark.parametrize(
    ('faults', 'state', 'words'),
    [
        (Faults(stuck_incline=True), SafetyState.AIMING, 'incline: -0.'),
        (Faults(lost_encoder=True), SafetyState.AIMED, 'joint_states: base_x is at nan'),
        (Faults(late_brake=0.05), SafetyState.ARMED, 'beyond where it should have stopped'),
        (Faults(no_ball=True), SafetyState.ARMED, 'or there was no ball'),
        (Faults(command_loss_rate=1.0), SafetyState.AIMED, 'has not met the ball'),
    ],
)
def test_faults_are_found_and_named(bench, faults, state, words):
    in_state(bench, SafetyState.AIMING if state is SafetyState.AIMING else SafetyState.AIMED)
    bench.mechanism.faults = faults
    if state is not SafetyState.AIMING:
        bench.arm()
    assert bench.run(6.0, lambda: bench.controller.state is SafetyState.FAULT)
    assert words in bench.controller.reason
    assert bench.results[-1].outcome is GoalOutcome.FAULT
    bench.run(1.0)
    assert bench.mechanism.stopped


def test_a_strike_that_was_not_measured_is_named(bench):
    """Before, the shot ended with a fault, and nobody judged it."""
    in_state(bench, SafetyState.FIRING)
    receive = bench.controller.receive_joints
    profile = bench.controller._execution.shot.profile

    def lose_the_last(position, velocity, *times):
        if not 0.0 < profile.contact_at - position[STROKE] <= profile.steady_way:
            receive(position, velocity, *times)

    bench.controller.receive_joints = lose_the_last
    bench.reach(SafetyState.DISARMED)
    result = bench.results[-1]
    assert result.outcome is GoalOutcome.OK
    assert result.message == (
        'done; the strike was not measured: no joint_states in the last 16 ms before it'
    )
    assert (result.has_met, result.strike) == (True, None)
    assert bench.strikes == [None]


def test_some_lost_commands_do_no_harm(bench):
    bench.mechanism.faults = Faults(command_loss_rate=0.3)
    assert bench.play(SHOT).outcome is GoalOutcome.OK


def test_silent_encoders_are_a_fault(bench):
    in_state(bench, SafetyState.AIMING)
    for _ in range(52):  # nothing is heard of the joints from here on
        bench.now += 0.01
        bench.tick()
    assert bench.controller.state is SafetyState.FAULT
    assert 'joint_states: no message for' in bench.controller.reason


def test_armed_times_out():
    bench = Bench(settings=Settings(arm_timeout=0.3, settle_time=1.0))
    in_state(bench, SafetyState.ARMED)
    bench.reach(SafetyState.DISARMED, 0.5)
    assert bench.results[-1].outcome is GoalOutcome.ARM_TIMEOUT
    assert not bench.arm().accepted


def test_a_goal_expires_while_it_waits(bench):
    bench.send_goal(SHOT, remaining=4.0)
    bench.reach(SafetyState.AIMED)
    bench.reach(SafetyState.DISARMED)
    assert bench.now == pytest.approx(4.1, abs=0.05)
    assert bench.results[-1].outcome is GoalOutcome.EXPIRED


@pytest.mark.parametrize('state', BEFORE_STROKE)
def test_a_ball_that_moves_disarms(bench, state):
    in_state(bench, state)
    bench.balls = {'cue': (0.0, 0.002)}
    bench.run(0.02)
    assert bench.controller.state is SafetyState.DISARMED
    assert bench.results[-1].outcome is GoalOutcome.TABLE_MOVED
    assert 'lies 2 mm from its planned place' in bench.results[-1].message


@pytest.mark.parametrize('is_repeated', [False, True])
@pytest.mark.parametrize('state', BEFORE_STROKE)
def test_a_camera_that_ends_is_noticed(state, is_repeated):
    """Also if somebody repeats its last picture in new messages."""
    bench = Bench(settings=Settings(settle_time=4.0))
    in_state(bench, state)
    if is_repeated:
        bench.freeze()
    else:
        bench.balls = None
    bench.run(1.1)
    assert bench.controller.state is SafetyState.DISARMED
    assert bench.results[-1].outcome is GoalOutcome.TABLE_STALE
    assert 'table_state: no picture for' in bench.results[-1].message
    assert bench.refused('table_state: no picture for', SHOT, 'again') is GoalOutcome.TABLE_UNKNOWN


def test_a_picture_that_was_taken_too_long_ago(bench):
    """The message is new, but the picture of which it tells is not."""
    bench.camera_delay = 3600.0
    bench.run(0.02)
    assert (
        bench.refused(r'the last picture must be at most 1 s old, got 3\.6e\+03 s', SHOT)
        is GoalOutcome.TABLE_UNKNOWN
    )


def test_a_ball_must_be_seen_before_a_shot_is_aimed(bench):
    bench.balls['8'] = (0.5, 0.0)
    bench.run(0.02)
    bench.hide('8')
    bench.run(1.1)
    assert (
        bench.refused(r"detection of ball '8' must .* got 1\.09 s", SHOT)
        is GoalOutcome.TABLE_UNKNOWN
    )


def test_a_detection_in_the_future_is_refused(bench):
    bench.camera_delay = -0.2
    bench.run(0.02)
    assert bench.refused(r'must be at most 0\.1 s ahead of now, got 0\.2 s', SHOT)


def test_the_cue_hides_the_ball_for_a_while():
    """A ball counts as lying where it was seen last, but not for ever."""
    bench = Bench(settings=Settings(unseen_timeout=6.0, arm_timeout=60.0, settle_time=10.0))
    bench.balls['8'] = (0.5, 0.0)
    bench.run(0.02)
    in_state(bench, SafetyState.ARMED)
    bench.hide('cue')
    bench.run(5.9)
    assert bench.controller.state is SafetyState.ARMED, bench.controller.reason
    bench.run(0.2)
    assert bench.results[-1].outcome is GoalOutcome.TABLE_STALE
    assert bench.refused('last detection of ball', SHOT, 'hidden')


@pytest.mark.parametrize(('distance', 'fires'), [(0.09, True), (0.11, False)])
def test_the_armed_cue_hides_only_balls_beside_it(distance, fires):
    """Somebody takes a ball away while the cue travels to its aim, 0.3 m behind the cue ball."""
    bench = Bench(settings=Settings(hidden_width=0.1, settle_time=1.5))
    cos, sin = math.cos(SHOT[3]), math.sin(SHOT[3])
    bench.balls['8'] = (-0.3 * cos - distance * sin, -0.3 * sin + distance * cos)
    bench.run(0.02)
    in_state(bench, SafetyState.AIMING)
    bench.hide('8')
    bench.reach(SafetyState.AIMED)
    assert bench.arm().accepted
    bench.run(5.0, lambda: bool(bench.results))
    ended = bench.results[-1]
    assert bool(bench.strikes) is fires
    assert ended.outcome is (GoalOutcome.OK if fires else GoalOutcome.TABLE_STALE), ended.message


def test_pictures_without_any_ball_are_no_view_of_the_table():
    """A lens that is covered: pictures go on, but show nothing."""
    bench = Bench(settings=Settings(hidden_width=1.0, arm_timeout=60.0, settle_time=10.0))
    bench.balls['8'] = (0.5, 0.0)
    bench.run(0.02)
    in_state(bench, SafetyState.ARMED)
    bench.hide('cue', '8')
    bench.run(1.9)
    assert bench.controller.state is SafetyState.ARMED, bench.controller.reason
    bench.run(0.2)
    assert bench.results[-1].outcome is GoalOutcome.TABLE_STALE
    assert (
        'the last picture that shows a ball must be at most 2 s old' in bench.results[-1].message
    )


def test_after_a_pause_a_picture_from_before_it_is_not_trusted(bench):
    """A publisher that repeats it is still heard, but its camera may have paused, too."""
    bench.freeze()
    bench.run(0.1)
    pause(bench, 0.5)
    bench.run(4.1)
    assert bench.controller.problems(bench.now)['table'] == (
        'table_state: no picture since this process paused'
    )


def test_a_ball_that_has_moved_while_it_was_hidden(bench):
    in_state(bench, SafetyState.AIMED)
    bench.hide('cue')
    bench.run(0.5)
    bench.hidden.clear()
    bench.balls = {'cue': (0.0, 0.003)}
    bench.run(0.02)
    assert bench.results[-1].outcome is GoalOutcome.TABLE_MOVED


def test_refusals_before_anything_moves(bench):
    def refused(plan, remaining=60.0):
        with pytest.raises(RefusedError) as caught:
            bench.execute(plan, remaining)
        return caught.value.outcome

    plan = bench.plan(SHOT)
    bench.balls = {'cue': (0.1, 0.0)}
    bench.run(0.02)
    assert refused(plan) is GoalOutcome.TABLE_DIFFERS
    bench.balls = {'cue': (0.0, 0.0)}
    bench.run(0.02)
    assert refused(plan, -1.0) is GoalOutcome.ALREADY_EXPIRED
    fast = bench.plan((*SHOT[:4], 6.5), shot_id='fast')
    assert refused(fast) is GoalOutcome.SPEED_OUT_OF_LIMITS
    bench.send_goal(SHOT)
    assert refused(plan) is GoalOutcome.BUSY
    assert bench.states == [SafetyState.AIMING]


@pytest.mark.parametrize('state', [SafetyState.DISARMED, SafetyState.AIMED, SafetyState.ARMED])
def test_a_layout_that_hides_a_motion_of_3_mm_is_not_played(bench, state):
    """Four standard deviations of the distance are 1.6 mm; before, 1 m^2 allowed any place."""
    uncertain = (4e-4**2, 0.0, 1e-8)
    if state is not SafetyState.DISARMED:
        in_state(bench, state)
    bench.covariance = uncertain
    bench.run(0.02)
    words = (
        "ball 'cue': 4 standard deviations of its distance from the planned place must be at most "
        '1.5 mm, got 1.6 mm'
    )
    if state is SafetyState.DISARMED:
        with pytest.raises(RefusedError, match=words) as caught:
            bench.send_goal(SHOT)
        assert caught.value.outcome is GoalOutcome.TABLE_UNKNOWN
    else:
        assert bench.results[-1].outcome is GoalOutcome.TABLE_STALE
        assert bench.results[-1].message == words


def test_a_ball_that_moves_by_3_mm_is_noticed_at_the_largest_uncertainty(bench):
    bench.covariance = (3.7e-4**2, 0.0, 3.7e-4**2)
    bench.run(0.02)
    in_state(bench, SafetyState.AIMED)
    bench.balls = {'cue': (0.003, 0.0)}
    bench.run(0.02)
    assert bench.results[-1].outcome is GoalOutcome.TABLE_MOVED


@pytest.mark.parametrize(
    ('made', 'outcome'),
    [
        (999.0, GoalOutcome.ALREADY_EXPIRED),
        (0.0, GoalOutcome.ALREADY_EXPIRED),
        (math.nan, GoalOutcome.ALREADY_EXPIRED),
        (1001.0, GoalOutcome.INVALID_PLAN),
    ],
)
def test_a_plan_from_before_the_start_or_ahead_of_the_clock_is_refused(bench, made, outcome):
    """Another program may have played it, or may play it after the next start."""
    with pytest.raises(RefusedError, match=r'plan\.header\.stamp must be from 1000\.') as caught:
        bench.execute(bench.plan(SHOT, made=made))
    assert caught.value.outcome is outcome
    bench.send_goal(SHOT)


def test_a_clock_that_was_set_back_does_not_shut_out_new_plans(bench):
    old = bench.plan(SHOT, 'old')
    bench.clock_offset -= 100.0
    bench.run(2.1)
    with pytest.raises(RefusedError, match='must be from 900') as caught:
        bench.execute(old)
    assert caught.value.outcome is GoalOutcome.INVALID_PLAN
    assert bench.play(SHOT, 'new').outcome is GoalOutcome.OK


def test_a_shot_is_played_once(bench):
    bench.play(SHOT, 'a')
    assert bench.refused("shot_id must be new, got 'a'", SHOT, 'a') is GoalOutcome.ALREADY_PLAYED
    assert bench.play(SHOT, 'b').outcome is GoalOutcome.OK


@pytest.mark.parametrize(
    ('remaining', 'outcome'),
    [
        (0.0, GoalOutcome.ALREADY_EXPIRED),
        (-5.0, GoalOutcome.ALREADY_EXPIRED),
        (math.nan, GoalOutcome.ALREADY_EXPIRED),
        (Settings().max_goal_validity + 0.1, GoalOutcome.INVALID_PLAN),
    ],
)
def test_a_goal_that_is_late_or_valid_for_too_long_is_refused(bench, remaining, outcome):
    with pytest.raises(RefusedError) as caught:
        bench.send_goal(SHOT, remaining=remaining)
    assert caught.value.outcome is outcome


def test_an_arm_for_another_shot_is_refused(bench):
    """Also after a client was ended while its shot was aimed."""
    bench.send_goal(SHOT, 'A')
    bench.reach(SafetyState.AIMED)
    bench.controller.disarm(bench.now, 'canceled', GoalOutcome.CANCELED)
    assert bench.run(5.0, lambda: not bench.mechanism.moving)
    bench.send_goal(SHOT, 'B')
    bench.reach(SafetyState.AIMED)
    decision = bench.controller.arm('A', bench.now)
    assert not decision.accepted
    assert decision.reason == "arm: shot_id must be 'B', got 'A'"
    bench.run(1.0)
    assert bench.controller.state is SafetyState.AIMED
    refused = bench.controller.arm(10_000 * '\x1b[2J', bench.now).reason
    assert refused.isprintable()
    assert len(refused) < 300
    assert bench.controller.arm('B', bench.now).accepted


def test_a_table_without_balls_is_known(bench):
    """As a tracker tells it that has just started."""
    bench.balls = {}
    bench.run(0.02)
    assert bench.controller.problems(bench.now)['table'] == ''
    assert bench.refused("'cue' of the plan is not on the table", SHOT)


def test_table_unknown():
    bench = Bench()
    bench.controller.reject_table('table_state: wrong', bench.now)
    assert bench.refused('table_state: wrong', SHOT) is GoalOutcome.TABLE_UNKNOWN


@pytest.mark.parametrize('beyond', [-1e-5, 0.0, 1e-5])
@pytest.mark.parametrize('end', ['min', 'max'])
def test_the_elevation_is_known_where_an_encoder_reads_a_little_beyond_the_range(
    bench, end, beyond
):
    geometry = bench.controller.mechanism.incline_geometry
    length, step = getattr(MECHANISM.incline, end) + beyond, 1e-7
    position, velocity = bench.mechanism.measured()
    position[INCLINE], velocity[INCLINE] = length, 0.01
    bench.controller.receive_joints(position, velocity, bench.now, bench.now)
    elevation, rate = bench.controller.measured_elevation(bench.now)
    assert elevation == geometry.elevation(length)
    slope = (geometry.elevation(length + step) - geometry.elevation(length - step)) / (2.0 * step)
    assert rate == pytest.approx(0.01 * slope, rel=1e-6)


@pytest.mark.parametrize(
    'imperfections',
    [
        Imperfections(latency=0.01),
        Imperfections(noise=0.002),
        Imperfections(encoder_step=1e-5),
        Imperfections(bandwidth=60.0),
    ],
)
def test_an_imperfect_mechanism_still_plays(imperfections):
    bench = Bench(imperfections)
    result = bench.play(SHOT)
    assert result.outcome is GoalOutcome.OK, result.message
    assert result.strike.speed == pytest.approx(3.0, rel=0.01)


def test_a_joint_where_it_cannot_be_is_a_fault_at_once(bench):
    """Before the next message: the pose of the strike was computed from it."""
    in_state(bench, SafetyState.FIRING)
    position, velocity = bench.mechanism.measured()
    position[INCLINE] = 5.0
    bench.controller.receive_joints(position, velocity, bench.now, bench.now)
    assert bench.controller.state is SafetyState.FAULT
    assert 'incline is at 5 m, which is not between' in bench.controller.reason


@pytest.mark.parametrize('place', [500.0, 1e103])
def test_no_motion_begins_from_a_place_beyond_the_axes(bench, place):
    """Millimetres, sent as metres."""
    position, velocity = bench.mechanism.measured()
    position[0] = place
    bench.controller.receive_joints(position, velocity, bench.now, bench.now)
    assert bench.refused(r'base_x is at .* m, which is not between', SHOT) is GoalOutcome.NOT_READY
    assert bench.states == []


def test_an_open_interlock_that_was_overtaken_stops_all_the_same(bench):
    """Two publishers: the message of the one with the longer way is older when it arrives."""
    in_state(bench, SafetyState.ARMED)
    bench.controller.receive_interlock(False, bench.now - 0.05, bench.now)
    assert bench.controller.state is SafetyState.DISARMED
    assert bench.controller.reason == 'interlock: is false'


def test_a_pause_while_a_shot_is_prepared_is_noticed(bench):
    before = iter([bench.now])
    with pytest.raises(RefusedError, match='because this process paused') as caught:
        bench.controller.execute(
            bench.plan(SHOT), 60.0, lambda: next(before, bench.now + Settings().max_pause + 0.01)
        )
    assert caught.value.outcome is GoalOutcome.NOT_READY
    assert SafetyState.AIMING not in bench.states
    bench.run(0.1)
    assert not np.abs(bench.mechanism.measured()[1]).max() > 1e-3


def test_other_settings_undo_no_latch_and_no_distrust(bench):
    in_state(bench, SafetyState.AIMED)
    bench.estop = True
    bench.tick()
    bench.estop = False
    bench.now += 1.0
    bench.tick()  # notices the pause
    bench.now += 2.0  # in which the node is not configured
    bench.controller.configure(MECHANISM, SCENE, Settings(estop_timeout=1.0))
    assert bench.controller.state is SafetyState.ESTOP
    assert bench.controller.reason == 'estop: pressed'
    assert bench.controller.command.trajectory is None
    bench.run(0.1)
    assert 'not trusted for another' in bench.controller.clear(bench.now).reason
    bench.run(5.0)
    assert bench.controller.clear(bench.now).accepted
    assert bench.refused('has been aimed', SHOT) is GoalOutcome.ALREADY_PLAYED


def test_other_settings_forget_no_pressed_emergency_stop(bench):
    """Before, a latch could be cleared until a slow publisher of true was heard again."""
    bench.controller.receive_estop(True, bench.now, bench.now, 'gate')
    bench.controller.configure(MECHANISM, SCENE, Settings(estop_timeout=1.0))
    bench.run(0.3)  # another publisher says false
    assert 'estop: is true (one of 2 publishers)' in bench.controller.clear(bench.now).reason
    bench.run(1.0)
    assert 'estop: no message for 1.3 s, limit 1 s' in bench.controller.clear(bench.now).reason
    bench.controller.receive_estop(False, bench.now, bench.now, 'gate')
    assert bench.controller.clear(bench.now).accepted


def test_no_goal_is_accepted_while_the_cue_still_brakes(bench):
    """Its trajectory would begin at rest, and replace the stop."""
    in_state(bench, SafetyState.FIRING)
    bench.run(0.04)
    bench.controller.disarm(bench.now, 'by hand')
    assert bench.refused('stroke still moves, at', SHOT, 'too early') is GoalOutcome.NOT_READY
    bench.run(1.0)
    assert bench.play(SHOT, 'later').outcome is GoalOutcome.OK


def test_one_of_two_emergency_stops_counts_until_it_is_released(bench):
    """Before, a quick publisher of false covered a slow one of true."""
    in_state(bench, SafetyState.AIMING)
    bench.controller.receive_estop(True, bench.now, bench.now, 'gate')
    bench.run(0.3)
    assert bench.controller.state is SafetyState.ESTOP
    refused = bench.controller.clear(bench.now)
    assert not refused.accepted
    assert 'estop: is true (one of 2 publishers)' in refused.reason
    bench.controller.estop.keep({None: ''}, bench.now)  # the publisher has died
    assert bench.controller.state is SafetyState.ESTOP
    assert bench.controller.clear(bench.now).accepted


def test_missing_joints_are_named(bench):
    bench.controller.missing_joints = 'stroke'
    bench.run(0.1)
    assert bench.controller.mechanism_fault(bench.now) == ''
    assert bench.controller.mechanism_fault(bench.now + 2.0) == (
        'joint_states: no message for 2 s, limit 0.5 s (without stroke)'
    )


def test_no_stroke_begins_while_the_controller_has_not_answered(bench):
    """Until then the balls are watched, as they are before every stroke."""
    in_state(bench, SafetyState.ARMED)
    for _ in range(30):
        bench.controller.receive_commands('', '', True, bench.now)
        bench.run(0.01)
    assert bench.controller.state is SafetyState.ARMED
    bench.balls = {'cue': (0.01, 0.0)}
    bench.reach(SafetyState.DISARMED)
    assert bench.results[-1].outcome is GoalOutcome.TABLE_MOVED


def test_a_stop_that_is_not_followed_is_a_fault_at_rest_too(bench):
    failure = 'controller: no answer to a goal for 1 s'
    for _ in range(2):
        bench.controller.receive_commands(failure, failure, False, bench.now)
    assert bench.states == [SafetyState.FAULT]
    assert bench.controller.reason == failure
    assert not bench.controller.clear(bench.now).accepted
    bench.controller.receive_commands('', '', False, bench.now)
    commands = []
    bench.controller._tell_command = commands.append
    assert bench.controller.clear(bench.now).accepted
    assert [each.trajectory for each in commands] == [None], 'the first command is to hold'


def test_joints_without_velocities_play_no_shot(bench):
    """Speeds that follow from positions are wrong by more than they may be."""
    position, velocity = bench.mechanism.measured()
    velocity[STROKE] = math.nan
    bench.controller.receive_joints(position, velocity, bench.now, bench.now)
    assert bench.refused('joint_states: stroke has no velocity', SHOT) is GoalOutcome.NOT_READY
    assert bench.states == []

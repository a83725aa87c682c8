"""Goals to a controller that handles them late, in any order or never; without nodes."""

from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('control_msgs', reason='needs control_msgs')

from control_msgs.action import FollowJointTrajectory
from rclpy.task import Future
from rclpy.time import Time

from billiard_shot.cue.controller import Command
from billiard_shot.cue.joint_trajectory import TrajectoryBuilder
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.ros import commands as controller_client
from billiard_shot.ros.commands import ControllerClient, GOAL_TIMEOUT, GoalSequence, LEAD
from billiard_shot.ros.conversions import seconds

MECHANISM = Mechanism()
STILL = np.zeros(6)
TICK = 0.02
RESULT = FollowJointTrajectory.Result


def move(duration):
    builder = TrajectoryBuilder(STILL)
    builder.piece(duration, STILL)
    return builder.trajectory()


AIM = Command(move(2.0))
STROKE = Command(move(0.4), 0.4)
STOP = Command(None)


class Handle:
    """Goal at the server; what the client does with it waits in the server's `inbox`."""

    def __init__(self, server, goal):
        self.server, self.goal = server, goal
        self.accepted, self.result = True, Future()
        self.is_stop = seconds(goal.trajectory.header.stamp) == 0.0

    def get_result_async(self):
        assert not self.server.is_destroyed
        return self.result

    def cancel_goal_async(self):
        assert not self.server.is_destroyed
        answer = Future()
        self.server.inbox.append(lambda: self.server.cancel(self, answer))
        return answer


class Server:
    """
    Follows the goal that it has handled last, as joint_trajectory_controller does.

    A test decides which of the requests in `inbox` is handled next, and which of the answers in
    `outbox` arrives next.
    """

    def __init__(self):
        self.inbox, self.outbox, self.sent = [], [], []
        self.is_destroyed = False
        self.active = None
        self.rejects, self.is_ready = False, True

    def server_is_ready(self):
        return self.is_ready

    def destroy(self):
        self.is_destroyed = True

    def send_goal_async(self, goal):
        handle, answer = Handle(self, goal), Future()
        self.sent.append((handle, answer))
        self.inbox.append(lambda: self.accept(handle, answer))
        return answer

    def accept(self, handle, answer):
        if self.rejects:
            handle.accepted = False
        else:
            self.end(RESULT.INVALID_GOAL)
            self.active = handle
        self.outbox.append(lambda: answer.set_result(handle))

    def cancel(self, handle, answer):
        if handle is self.active:
            self.end(RESULT.SUCCESSFUL)
        self.outbox.append(lambda: answer.set_result(None))

    def end(self, code):
        """End the active goal; the joints are held."""
        if ended := self.active:
            self.active = None
            result = SimpleNamespace(result=RESULT(error_code=code))
            self.outbox.append(lambda: ended.result.set_result(result))

    def run(self, random=None):
        """Handle all that waits, in an order by chance or in the order of sending."""
        while waiting := [each for each in (self.inbox, self.outbox) if each]:
            box = waiting[random.integers(len(waiting)) if random else 0]
            box.pop(random.integers(len(box)) if random else 0)()


class Bench:
    """A client and its server, and the time."""

    def __init__(self):
        self.now = 100.0
        self.server = Server()
        clock = SimpleNamespace(now=lambda: Time(nanoseconds=self.nanoseconds))
        node = SimpleNamespace(get_clock=lambda: clock, resolve_topic_name=lambda name: name)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(controller_client, 'ActionClient', lambda *_: self.server)
            self.client = ControllerClient(node, 'follow', list(JOINTS), MECHANISM.accelerations)
        self.client._goals = GoalSequence(self.server.send_goal_async, lambda: self.now)

    @property
    def nanoseconds(self):
        return round(1e9 * self.now)

    @property
    def stops(self):
        """For each goal that was sent, whether it is a stop."""
        return [handle.is_stop for handle, _ in self.server.sent]

    def send(self, command, position=STILL):
        self.client.send(command, self.nanoseconds, position, STILL)

    def tick(self, seconds=TICK):
        self.now += seconds
        self.client.repeat(self.nanoseconds, STILL, STILL)


@pytest.fixture
def bench():
    return Bench()


@given(st.integers(0, 2**32 - 1))
def test_no_stroke_is_followed_after_its_stop(seed):
    """Requests and answers pass each other by chance; the driver stops after every failure."""
    random = np.random.default_rng(seed)
    bench = Bench()
    server, client = bench.server, bench.client
    for command in (AIM, STROKE, STOP):
        bench.send(command)
        for _ in range(random.integers(12)):
            bench.tick()
            for box in (server.inbox, server.outbox):
                if box and random.random() < 0.4:
                    box.pop(random.integers(len(box)))()
        unanswered = [handle for handle, answer in server.sent if not answer.done()]
        assert sum(not each.is_stop for each in unanswered) <= 1
    for _ in range(3):
        server.run(random)
        assert server.active is None or server.active.is_stop
        if client.failure:  # the stop was overtaken
            bench.tick(GOAL_TIMEOUT + TICK)
    assert server.active.is_stop
    assert client.failure == ''
    assert client._goals.missing == 0


def test_a_stroke_waits_for_the_answer_to_the_goal_before_it(bench):
    bench.send(AIM)
    bench.send(STROKE)
    assert bench.client.awaits_answer
    for _ in range(10):
        bench.tick()
    assert len(bench.server.sent) == 1
    bench.server.run()
    assert not bench.client.awaits_answer
    bench.tick()
    _, (stroke, _) = bench.server.sent
    start = seconds(stroke.goal.trajectory.header.stamp)
    assert start == pytest.approx(bench.now + LEAD), 'not in the past: it is played from its start'


def test_a_stroke_whose_decision_is_old_is_sent_with_the_next_one(bench):
    """A process that paused in between would begin in the middle of the stroke."""
    decided = bench.nanoseconds
    bench.now += LEAD + TICK
    bench.client.send(STROKE, decided, STILL, STILL)
    assert not bench.server.sent
    bench.tick()
    assert bench.stops == [False]


def test_all_goals_for_a_trajectory_have_one_stamp_and_a_stop_has_none(bench):
    bench.send(AIM)
    for _ in range(20):
        bench.server.run()
        bench.tick()
    bench.send(STOP)
    stamps = [seconds(handle.goal.trajectory.header.stamp) for handle, _ in bench.server.sent]
    assert len(stamps) > 3
    assert stamps[:-1] == pytest.approx([100.0 + LEAD] * (len(stamps) - 1), abs=1e-9)
    assert stamps[-1] == 0.0


def test_a_goal_that_was_given_up_is_cancelled_as_soon_as_it_is_accepted(bench):
    bench.send(STROKE)
    bench.send(STOP)
    bench.server.inbox.pop()()
    bench.server.inbox.pop()()
    assert not bench.server.active.is_stop, 'it has overtaken its stop'
    bench.server.run()
    assert bench.server.active is None
    assert bench.client.failure.startswith('controller: INVALID_GOAL'), 'of the stop'


def test_without_an_answer_it_fails_until_a_stop_is_accepted(bench):
    """The server loses all; one that is started in its place gets stops first."""
    bench.send(AIM)
    bench.now += GOAL_TIMEOUT + TICK
    assert 'no answer to a goal for 1 s' in bench.client.failure
    lost = bench.server.inbox.pop()
    bench.send(STOP)
    assert bench.client.problem, 'the stop is not answered yet'
    bench.server.inbox.clear()
    bench.server.is_ready = False
    bench.tick(3.0)
    assert 'there is no action server' in bench.client.problem
    bench.server.is_ready = True
    bench.tick()
    bench.server.run()
    assert bench.client.problem == ''
    assert bench.stops == [False, True, True]
    lost()  # it was only late
    bench.server.run()
    assert bench.server.active is None
    assert bench.client.failure.startswith('controller: INVALID_GOAL')


def test_a_rejected_stop_is_sent_again_every_second(bench):
    bench.server.rejects = True
    bench.send(STOP)
    for _ in range(round(3.5 / TICK)):
        bench.server.run()
        bench.tick()
    assert bench.stops == [True] * 4
    assert 'rejected' in bench.client.problem
    bench.server.rejects = False
    bench.tick(GOAL_TIMEOUT)
    bench.server.run()
    assert bench.client.problem == ''


def test_a_stop_without_known_joints_cancels_and_brakes_once_they_are_known(bench):
    bench.send(AIM)
    bench.server.run()
    bench.send(AIM)  # not answered yet
    bench.send(STOP, np.full(6, np.nan))
    assert bench.stops == [False, False]
    bench.server.run()
    assert bench.server.active is None
    bench.tick()
    bench.server.run()
    assert bench.server.active.is_stop


def test_a_rejected_goal_cancels_the_goal_before_it(bench):
    bench.send(AIM)
    bench.server.run()
    bench.server.rejects = True
    bench.tick(0.2)
    bench.server.run()
    assert bench.server.active is None
    assert 'rejected' in bench.client.failure


@pytest.mark.filterwarnings('error:Unhandled exception')
@pytest.mark.parametrize('commands', [[STROKE], [STROKE, STOP]])
def test_answers_after_the_client_was_closed_are_ignored(bench, commands):
    """An executor calls back for an answer that it took before."""
    for command in commands:
        bench.send(command)
    bench.client.close()
    bench.server.run()

"""
Random sequences of events against the controller: it never fires unless it may.

A second, simpler bookkeeping runs beside it and judges every stroke that is commanded.
"""

from dataclasses import replace
import os

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import initialize, invariant, precondition, rule, RuleBasedStateMachine
import numpy as np
from plans import HOME, MECHANISM, plan_of, SCENE, sightings
import pytest

from billiard_shot.cue.controller import Controller, RECOVERY, Settings
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.plan import RefusedError
from billiard_shot.cue.safety import MOVING, SafetyState

SETTINGS = Settings()
PLANS = [
    plan_of((0.1, 0.1, 0.1, 0.0, 2.0), shot_id='one'),
    plan_of((-0.2, 0.0, 0.4, 1.0, 1.0), shot_id='two'),
    plan_of((0.0, 0.0, 0.1, 0.0, 9.0), shot_id='too fast'),
]
TABLES = [sightings({'cue': (x, 0.0)}) for x in (0.0, 0.01)]


class Ideal:
    """A mechanism that is where its trajectory has it."""

    def __init__(self):
        self.position, self.trajectory, self.begin = HOME.copy(), None, 0.0
        self.off = 0.0  # by how much it is not [m]

    def command(self, command, now):
        self.position = self.measured(now)[0] - self.off * (self.trajectory is not None)
        self.trajectory, self.begin = command.trajectory, now

    def measured(self, now):
        if self.trajectory is None:
            return self.position, np.zeros(6)
        position, velocity, _ = self.trajectory.at(now - self.begin)
        return position + self.off, velocity


class AnyEvents(RuleBasedStateMachine):
    @initialize()
    def start(self):
        self.now = 100.0
        self.said = {}  # input: value, time of writing
        self.resumed = -np.inf  # end of the last long pause
        self.says = {'estop': False, 'interlock': True}  # what is repeated; None: silence
        self.armed_at = self.ordered_until = self.ordered = None
        self.table = TABLES[0]
        self.used: set[str] = set()
        self.strokes = 0
        self.deaf = False
        self.mechanism = Ideal()
        self.controller = Controller(
            MECHANISM, SCENE, SETTINGS, on_command=self.judge, on_state=self.note
        )
        self.controller.activate()
        self.camera_does, self.seen = 'see', -np.inf  # or 'repeat', 'end'; its last picture
        self.pass_time(0.02)

    # --- the judge ------------------------------------------------------------------------------

    def note(self):
        if (
            self.controller.state is not SafetyState.ARMED
            and self.controller.state is not SafetyState.FIRING
        ):
            self.armed_at = None

    def judge(self, command):
        if command.trajectory is not None:
            assert not self.controller.inactive
        if (
            command.trajectory is not None
            and np.ptp(command.trajectory.positions[:, STROKE]) > 0.01
            and (command.trajectory.positions[0, STROKE] == 0.0)
        ):
            self.strokes += 1
            assert self.controller.state is SafetyState.FIRING
            value, heard = self.said['estop']
            assert value is False
            assert self.now - heard <= SETTINGS.estop_timeout
            assert heard >= self.resumed
            value, heard = self.said['interlock']
            assert value is True
            assert self.now - heard <= SETTINGS.interlock_timeout
            assert heard >= self.resumed
            assert self.armed_at is not None
            assert self.now - self.armed_at <= SETTINGS.arm_timeout + 1e-9
            assert self.now <= self.ordered_until
            assert self.table == self.ordered.balls
            assert self.now - self.seen <= SETTINGS.table_timeout
        self.mechanism.command(command, self.now)

    # --- what happens ---------------------------------------------------------------------------

    def pass_time(self, seconds, step=0.01):
        for _ in range(max(1, round(seconds / step))):
            self.now += step
            for name, value in self.says.items():
                if value is not None:
                    self.say(name, value)
            if not self.deaf:
                self.controller.receive_joints(
                    *self.mechanism.measured(self.now), self.now, self.now
                )
            if self.camera_does == 'see':
                self.seen = self.now
            if self.camera_does != 'end':
                self.tell_table()
            self.controller.receive_clock(self.now, self.now)
            self.controller.tick(self.now)

    def tell_table(self):
        balls = {name: replace(ball, time=self.seen) for name, ball in self.table.items()}
        self.controller.receive_table(balls, self.seen, self.now, self.now, self.now)

    def say(self, name, value, written=None):
        written = self.now if written is None else written
        self.said[name] = value, written
        getattr(self.controller, f'receive_{name}')(value, written, self.now)

    @rule(
        seconds=st.sampled_from([0.1, 0.24, 0.3, 1.0, 6.0]),
        requests=st.permutations(['messages', 'arm', 'clear', 'tick']),
    )
    def the_controller_pauses(self, seconds, requests):
        """Messages and requests wait meanwhile, and come in afterwards in any order."""
        before, joints = self.now, self.mechanism.measured(self.now)
        self.now += seconds
        trusts_nothing = seconds > SETTINGS.max_pause
        if trusts_nothing:
            self.resumed = self.now
        for request in requests:
            if request == 'messages':
                for name, value in self.says.items():
                    if value is not None:
                        self.say(name, value, before + 0.9 * seconds)
                if not self.deaf:
                    self.controller.receive_joints(*joints, before + 0.9 * seconds, self.now)
            elif request == 'tick':
                self.controller.tick(self.now)
            elif request == 'arm':
                self.arm()
                assert not (trusts_nothing and self.controller.state is SafetyState.ARMED)
            else:
                latched = self.controller.state in (SafetyState.ESTOP, SafetyState.FAULT)
                self.clear()
                still = self.controller.state in (SafetyState.ESTOP, SafetyState.FAULT)
                assert still or not (trusts_nothing and latched)

    @rule(seconds=st.sampled_from([0.01, 0.05, 0.2]))
    def time_passes(self, seconds):
        self.pass_time(seconds)

    @rule()
    def much_time_passes(self):
        self.pass_time(3.0, 0.05)

    @rule(name=st.sampled_from(['estop', 'interlock']), value=st.sampled_from([True, False, None]))
    def input_says(self, name, value):
        self.says[name] = value
        if value is not None:
            self.say(name, value)

    @rule()
    def all_is_well(self):
        self.says = {'estop': False, 'interlock': True}
        self.deaf, self.camera_does = False, 'see'
        self.table = TABLES[0]
        self.controller.activate()
        self.pass_time(max(0.02, self.resumed + RECOVERY + 0.1 - self.now), 0.05)
        self.controller.clear(self.now)

    @rule(deaf=st.booleans())
    def encoders(self, deaf):
        self.deaf = deaf

    @rule(table=st.sampled_from(TABLES))
    def balls_lie(self, table):
        self.table, self.seen = table, self.now
        self.tell_table()

    @rule(does=st.sampled_from(['see', 'repeat', 'end']))
    def camera(self, does):
        self.camera_does = does

    @rule(
        plan=st.sampled_from(PLANS),
        number=st.integers(0, 30),
        remaining=st.sampled_from([-1.0, 2.0, 60.0]),
    )
    def send_goal(self, plan, number, remaining):
        plan = replace(plan, shot_id=str(number), made=self.now)
        try:
            self.controller.execute(plan, remaining, lambda: self.now)
        except RefusedError:
            return
        assert plan.shot_id not in self.used
        self.used.add(plan.shot_id)
        assert plan.speed != PLANS[2].speed
        self.ordered, self.ordered_until = plan, self.now + remaining

    @precondition(lambda self: self.controller.state is SafetyState.AIMING)
    @rule()
    def wait_for_the_aim(self):
        self.pass_time(4.0, 0.05)

    @rule()
    def arm(self):
        if self.controller.arm(self.controller.shot_id, self.now).accepted:
            self.armed_at = self.now

    @rule(number=st.integers(0, 30))
    def arm_a_shot(self, number):
        if self.controller.arm(str(number), self.now).accepted:
            assert self.ordered.shot_id == str(number)
            self.armed_at = self.now

    @rule()
    def disarm(self):
        self.controller.disarm(self.now, 'by hand')

    @rule(what=st.sampled_from(['activate', 'deactivate', 'both']))
    def lifecycle(self, what):
        """After the node was deactivated, nothing moves and no goal is left."""
        if what != 'activate':
            self.controller.deactivate(self.now, 'not active', 'deactivated')
            assert self.controller.state not in MOVING
            assert self.controller.shot_id == ''
        if what != 'deactivate':
            self.controller.activate()

    @rule()
    def clear(self):
        before = self.controller.state
        if self.controller.clear(self.now).accepted:
            assert before in (SafetyState.ESTOP, SafetyState.FAULT)
            assert not self.controller.inactive
            assert self.says['estop'] is not True

    @rule()
    def fail(self):
        self.controller.fail(self.now, 'something')

    @invariant()
    def nothing_is_commanded_unless_it_may_move(self):
        state, command = self.controller.state, self.controller.command
        if state in MOVING:
            assert command is not None
            assert command.trajectory is not None
        elif state is SafetyState.DISARMED:
            assert command is None
        else:
            assert command.trajectory is None
        if state not in MOVING:
            assert self.mechanism.trajectory is None


TROUBLE = st.sampled_from(
    [
        'none',
        'none',
        'estop silent',
        'interlock silent',
        'estop',
        'interlock',
        'table',
        'deaf',
        'repeat',
        'end',
        'off',
        'time',
    ]
)


class Eager(AnyEvents):
    """The same, with one more rule that leads to strokes, or to trouble just before them."""

    @rule(
        plan=st.sampled_from(PLANS[:2]),
        remaining=st.sampled_from([6.0, 60.0]),
        aimed=TROUBLE,
        armed=TROUBLE,
        number=st.integers(1000, 1010),
    )
    def play(self, plan, remaining, aimed, armed, number):
        if self.controller.state is not SafetyState.DISARMED:
            return
        self.all_is_well()
        self.send_goal(plan, number, remaining)
        self.pass_time(4.0, 0.05)
        self.trouble(aimed)
        self.arm()
        self.trouble(armed)
        self.mechanism.off = 0.0
        self.pass_time(0.2)

    def trouble(self, kind):
        if kind == 'off':  # not settled for longer than it stays armed
            self.mechanism.off = 0.01
            self.pass_time(5.2, 0.05)
        elif kind == 'time':
            self.pass_time(3.0, 0.05)
        elif kind == 'table':
            self.balls_lie(TABLES[1])
        elif kind == 'deaf':
            self.deaf = True
        elif kind in ('repeat', 'end'):
            self.camera_does = kind
            self.pass_time(1.2, 0.05)
        elif kind in ('estop', 'interlock'):
            self.says[kind] = None
            self.say(kind, kind == 'estop')
        elif kind != 'none':
            self.says[kind.split()[0]] = None
            self.pass_time(0.6)


AnyEvents.TestCase.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)
Eager.TestCase.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)
TestAnyEvents = AnyEvents.TestCase
TestEager = Eager.TestCase


@pytest.mark.nightly
class TestManyEvents(Eager.TestCase):
    """More of them: SEQUENCES=10000 takes some two minutes."""

    settings = settings(
        max_examples=int(os.environ.get('SEQUENCES', '1000')),
        stateful_step_count=15,
        deadline=None,
    )

"""A cell of real processes: driver, simulated mechanism and simulated table, and a player."""

from contextlib import suppress
from pathlib import Path
import re
from threading import Thread
from typing import NamedTuple
import warnings

from billiard_shot_msgs.msg import Strike
from billiard_shot_msgs.srv import Arm
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Log
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from waiting import PATIENCE, PatientCaller

from billiard_shot import Scene, Stroke
from billiard_shot.cue.mechanism import JOINTS
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.client import NotReadyError, RobotClient
from billiard_shot.ros.robot import SIMULATION

SCENE = Scene.load('paper')
STROKE = Stroke.from_offsets(a=0.1, b=0.2, elevation=0.2, azimuth=0.5, speed=0.8)
PATIENT = {
    'cue_driver': ('-p', 'autostart:=true', *SIMULATION),
    'cue_sim': (*SIMULATION, '-p', 'rate:=100.0'),
    'table_sim': ('-p', 'real_time_factor:=100.0'),
    'predictor': (),
}
"""
Nodes and their arguments, patient with a machine that is busy with other tests.

At the default rate of joint_states the driver and the mechanism take half a core.
"""
LONG_RUN = ('-p', f'mechanism:={Path(__file__).with_name("long_run.yaml")}')
"""Argument of a driver whose joints are measured by a process without a clock of its own."""

ON_ROBOT_TABLE = ('-p', 'scene:=robot_table')
WITH_CAMERA = {
    'cue_driver': (*PATIENT['cue_driver'], *ON_ROBOT_TABLE),
    'cue_sim': PATIENT['cue_sim'],
    'table_sim': (*ON_ROBOT_TABLE, '-p', 'camera:=true', '-p', 'detection_noise:=0.0005'),
    'table_tracker': ON_ROBOT_TABLE,
    'predictor': (),
}
"""Nodes and their arguments for a table that a simulated camera sees."""

DEADLINE = 2.0
"""Seconds without a command after which the mechanism stops by itself."""

SLOWEST_BRAKE = 0.5
"""Seconds that a joint takes to brake from its full speed, with something to spare."""

STARTS = 3
"""
Times that a cell is started until its processes hear each other.

In a run of all tests on a busy machine, one cell in some hundred has a process that never hears
another one, as docs/ros.md says; it advises to start it again. The player is made anew, too: once
it was the player that heard none of the three drivers.
"""

STARVED = re.compile(
    'this process did not run for|: no (message|picture) for|because this process paused'
)
"""Reasons that the driver gives if it, the mechanism or this process did not run."""

LONG_DELAY = 1.0
"""Seconds that processes of a cell may wait for a processor in one test."""

STOPPED = re.compile(r'stopped by (command|itself: no command for (.*) s); at rest after (.*) s')


class Stop(NamedTuple):
    """What the mechanism logged of a stop, in seconds of its own clock."""

    silence: float | None  # None: commanded
    braking: float


class Cell:
    """Driver, mechanism, table and player in a namespace of their own, and what they say."""

    def __init__(self, launch, space, nodes=PATIENT):
        self.launch, self.space, self.nodes = launch, space, nodes
        self.processes = {}
        self._begin()

    def _begin(self):
        """Start the processes until they hear each other, and listen to them."""
        space, nodes = self.space, self.nodes
        for left in reversed(range(STARTS)):
            self.player = RobotClient(
                'player', space, simulate_safety_inputs=True, timeout=PATIENCE / 2
            )
            for name in nodes:
                self.start(name)
            try:
                self.player.wait_for_all()
                break
            except NotReadyError as error:
                if not left:
                    raise
                warnings.warn(f'the cell is started again: {error}', stacklevel=2)
                self.close()
        self.joints, self.commands, self.angles = [], [], []
        self.diagnostics, self.strikes, self.shots, self.log = [], [], [], []
        for kind, topic, heard in (
            (JointState, f'{space}/joint_states', self.joints),
            (JointTrajectory, f'{space}/cue_driver/actuation', self.commands),
            (Float64, f'{space}/cue_driver/incline_angle', self.angles),
            (Strike, f'{space}/cue_driver/strike', self.strikes),
            (String, f'{space}/table_sim/shot', self.shots),
            (DiagnosticArray, '/diagnostics', self.diagnostics),
        ):
            self.player.create_subscription(kind, topic, heard.append, 100)
        # A node may log before it is discovered: the log is latched for ten seconds.
        self.player.create_subscription(
            Log,
            '/rosout',
            self.log.append,
            QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL),
        )
        self.ended = None  # future of the result of the last goal
        self.services = {
            name: PatientCaller(self.player, Trigger, f'{space}/{name}')
            for name in (
                'cue_driver/disarm',
                'cue_driver/clear_fault',
                'table_sim/reset',
                *(['table_tracker/reset'] if 'table_tracker' in nodes else []),
            )
        }
        for name, kind in (('arm', Arm), ('change_state', ChangeState)):
            name = f'cue_driver/{name}'
            self.services[name] = PatientCaller(self.player, kind, f'{space}/{name}')
        self.wait_for_services()

    def close(self):
        """End the processes, then the player, whose endpoints others would discover in vain."""
        self.launch.close()
        self.player.destroy_node()
        # The executor keeps the endpoints of its last wait until it waits again. If they stayed,
        # the next player would find safety inputs of an unknown node.
        rclpy.get_global_executor().spin_once(timeout_sec=0.0)

    def wait_for_services(self, *more):
        """Wait, and go on saying that all is well."""
        for service in (*self.services.values(), *more):
            client = service.client
            assert self.player.until(client.service_is_ready, PATIENCE), client.service_name

    def start(self, name):
        process = self.launch(name, '-r', f'__ns:={self.space}', *self.nodes[name])
        # A node stops for good when its pipe is full, which takes some hundred lines.
        Thread(target=process.stdout.read, daemon=True).start()
        self.processes[name] = process

    def call(self, name, repeatable=False):
        return self.services[name].call(Trigger.Request(), repeatable=repeatable)

    def arm(self, shot_id=None):
        """Arm the shot that is aimed, or another one."""
        if shot_id is None:
            shot_id = self.player.states[-1].shot_id
        return self.services['cue_driver/arm'].call(Arm.Request(shot_id=shot_id))

    @property
    def estop(self):
        """The publisher of the emergency stop, which goes on saying that it is released."""
        return self.player.safety_publishers['estop']

    @property
    def state(self):
        return SafetyState(self.player.states[-1].state)

    def goal(self, name='shot', stroke=STROKE):
        """Goal with a new shot_id that begins with a name: a repeated test plays another shot."""
        return self.player.goal(stroke, self.player.balls(), SCENE, name)

    def begin(self, goal):
        """Send a goal; a future of how it ends."""
        sent = self.player.execute_shot.send_goal_async(goal)
        assert self.player.until(sent.done, PATIENCE)
        self.handle = sent.result()
        self.ended = self.handle.get_result_async()
        return self.ended

    def starved(self, error):
        """Whether a failed assertion shows that a process did not run, or waited long to run."""
        return (
            bool(STARVED.search(str(error)))
            or self.interrupted()
            or self.delay() - self.delay_before > LONG_DELAY
        )

    def interrupted(self):
        """Whether the driver last ended or refused something because a process did not run."""
        last = [state.reason for state in self.player.states[1:]][-1:]
        return any(map(STARVED.search, [*last, self.refusal]))

    def delay(self):
        """Seconds that the processes have waited for a processor so far, on Linux."""
        delay = 0.0
        for process in self.processes.values():
            with suppress(FileNotFoundError, ProcessLookupError):  # of processes that have ended
                delay += 1e-9 * int(Path(f'/proc/{process.pid}/schedstat').read_text().split()[1])
        return delay

    @property
    def refusal(self):
        """Why the last goal was refused; empty if it was not."""
        result = self.ended.result().result if self.ended and self.ended.done() else None
        return result.message if result and GoalOutcome(result.outcome).refused else ''

    def result(self):
        """Wait until the last goal has ended; its result."""
        assert self.player.until(self.ended.done, PATIENCE)
        return self.ended.result().result

    def transition(self, number):
        """Whether a transition of the driver succeeds."""
        change = self.services['cue_driver/change_state']
        return change.call(ChangeState.Request(transition=Transition(id=number))).success

    def clear(self):
        """Clear the latched state as soon as that is possible."""
        return self.player.until(lambda: self.call('cue_driver/clear_fault').success, PATIENCE)

    def restart_driver(self):
        self.player.states.clear()
        self.start('cue_driver')
        assert self.player.until(lambda: self.player.states, PATIENCE)
        self.player.wait_for_all()
        self.wait_for_services()

    def reach(self, state):
        self.player.until(lambda: self.state is state or self.interrupted(), PATIENCE)
        assert self.state is state, self.refusal or self.player.states[-1]

    def moving(self):
        """Whether any joint moved in the last joint_states of the mechanism."""
        self.joints.clear()
        known = self.player.until(
            lambda: any(len(message.name) == len(JOINTS) for message in self.joints), PATIENCE
        )
        assert known, 'the mechanism is silent'
        last = next(each for each in self.joints[::-1] if len(each.name) == len(JOINTS))
        return any(abs(velocity) > 1e-6 for velocity in last.velocity)

    def health(self):
        """What the latest diagnostics of the driver say, by name."""
        name = f'{self.space}/cue_driver'
        self.diagnostics.clear()
        assert self.player.until(
            lambda: any(
                status.name == name for each in self.diagnostics for status in each.status
            ),
            PATIENCE,
        ), 'no diagnostics of the driver'
        status = next(
            status
            for each in self.diagnostics[::-1]
            for status in each.status
            if status.name == name
        )
        return {each.key: each.value for each in status.values}

    def says(self, node, words):
        """Wait until a node of this cell has logged a line with these words."""
        return self.player.until(
            lambda: any(words in line for line in self.logged(node)), PATIENCE
        )

    def logged(self, node):
        """Messages that a node of this cell has logged."""
        name = f'{self.space}/{node}'.strip('/').replace('/', '.')
        return [each.msg for each in self.log if each.name == name]

    def stops(self):
        """Stops that the mechanism has recorded."""
        found = [STOPPED.fullmatch(line) for line in self.logged('cue_sim')]
        return [
            Stop(None if each[1] == 'command' else float(each[2]), float(each[3]))
            for each in found
            if each
        ]

    def stands_still(self):
        """Wait until the mechanism has stopped; its own record shows that it did so in time."""
        assert self.player.until(self.stops, PATIENCE), 'the mechanism has not stopped'
        stop = self.stops()[0]
        assert stop.braking <= SLOWEST_BRAKE
        assert stop.silence is None or stop.silence <= DEADLINE + 0.01
        assert self.player.until(lambda: not self.moving(), PATIENCE)
        return stop

    def prepare(self):
        """Bring the cell in order; start it again if its processes do not hear each other."""
        try:
            self._prepare()
        except NotReadyError as error:  # a starved process may lose the others for good
            warnings.warn(f'the cell is started again: {error}', stacklevel=2)
            self.close()
            self._begin()
            self._prepare()

    def _prepare(self):
        """Bring the cell in order: disarmed, ball in its place, every input heard."""
        for name, process in self.processes.items():
            if process.poll() is not None:  # a test that kills it may have failed before its end
                self.start(name)
        self.player.safety_inputs_on = True
        assert self.player.until(
            lambda: (
                self.state is SafetyState.DISARMED or self.call('cue_driver/clear_fault').success
            ),
            PATIENCE,
        )
        # Both may have been started again just now; then an answer can be lost.
        self.call('table_sim/reset', repeatable=True)
        if 'table_tracker/reset' in self.services:  # else it waits for balls that are gone
            self.call('table_tracker/reset', repeatable=True)
        reset = self.player.get_clock().now()
        assert self.player.until(
            lambda: Time.from_msg(self.player.table.header.stamp, reset.clock_type) > reset,
            PATIENCE,
        )
        assert self.player.until(lambda: self.state is SafetyState.DISARMED, PATIENCE)
        self.player.wait_for_all()  # a driver that has just become active has heard nothing yet
        assert self.player.until(lambda: not self.moving(), PATIENCE)
        for heard in (self.commands, self.angles, self.log):
            heard.clear()
        del self.player.states[:-1]
        self.ended = None
        self.delay_before = self.delay()

"""The page docs/firing.md, carried out: its commands, its program, and both players."""

from collections.abc import Iterator
import contextlib
import os
from pathlib import Path
import re
import shlex
import signal
import subprocess
import sys
from typing import NamedTuple

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from cell import PATIENT, STARVED
import rclpy
from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
from waiting import PATIENCE, RETRY_PERIOD

from billiard_shot.ros import player, predict_shot
from billiard_shot.ros.robot import quiet_environment

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / 'docs' / 'firing.md'
sys.path.append(str(ROOT / 'docs' / '_ext'))
from pages import text_of

BLOCKS = re.findall(r'^```(\w+)\n(.*?)^```$', text_of(PAGE), re.MULTILINE | re.DOTALL)
PLAYER = [sys.executable, '-m', 'billiard_shot.ros', 'player']
NODES = {
    **PATIENT,
    'cue_driver': (*PATIENT['cue_driver'], '-p', 'arm_timeout:=30.0'),
    'planner': ('-p', 'scene:=paper'),
}


def block(words: str, language: str = 'sh') -> str:
    found = {text for kind, text in BLOCKS if kind == language and words in text}
    assert len(found) == 1, (words, found)
    return found.pop()


ARM = block('service call /cue_driver/arm').strip()


class Shell(NamedTuple):
    """
    An environment with the nodes of the page, and a `ros2` command.

    A node looks on; its services put the cue ball back, and clear what a test has left.
    """

    environment: dict[str, str]
    node: Node
    executor: SingleThreadedExecutor
    services: tuple[Client, ...]

    def begin(self, command: str | list[str]) -> subprocess.Popen[str]:
        return subprocess.Popen(
            ['bash', '-c', command] if isinstance(command, str) else command,
            env=self.environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            process_group=0,
        )

    def run(self, command: str | list[str], seconds: float = PATIENCE) -> tuple[int, str]:
        process = self.begin(command)
        said, _ = process.communicate(timeout=seconds)
        return process.returncode, said

    def starved(self, error: AssertionError) -> bool:
        """Whether a failed assertion shows that the driver, or who talks to it, did not run."""
        return bool(STARVED.search(str(error)))

    def prepare(self) -> None:
        """Put the cue ball back, which would roll out of reach, and undo the changes of a test."""
        for service in self.services:
            self.trigger(service)

    def trigger(self, client: Client) -> Trigger.Response:
        """Call a service that may be called twice."""
        for _ in range(60):  # an answer is lost if the server has not yet discovered the client
            assert client.wait_for_service(PATIENCE), client.service_name
            future = client.call_async(Trigger.Request())
            self.executor.spin_until_future_complete(future, RETRY_PERIOD)
            if future.done():
                return future.result()
            client.remove_pending_request(future)
        raise TimeoutError(client.service_name)


def read_until(process: subprocess.Popen[str], words: str) -> str:
    """Lines that a process prints, up to the one with these words."""
    said = ''
    for line in process.stdout:
        said += line
        if words in line:
            return said
    raise AssertionError(f'{words!r} never came: {said}')


@pytest.fixture(scope='module')
def all_nodes(tmp_path_factory: pytest.TempPathFactory, domain: None) -> Iterator[Shell]:
    """Return a shell in a ROS domain of its own, with every node of the page running."""
    from domain_coordinator import domain_id

    folder = tmp_path_factory.mktemp('bin')
    command = folder / 'ros2'
    command.write_text(
        f'#!/bin/sh\nexec {sys.executable} {Path(__file__).with_name("ros2.py")} "$@"\n'
    )
    command.chmod(0o755)
    with domain_id() as number, contextlib.ExitStack() as stack:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=number)
        stack.callback(rclpy.shutdown, context=context)
        node = rclpy.create_node('onlooker', context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        shell = Shell(
            {**quiet_environment(number), 'PATH': f'{folder}{os.pathsep}{os.environ["PATH"]}'},
            node,
            executor,
            tuple(
                node.create_client(Trigger, name)
                for name in ('/table_sim/reset', '/cue_driver/clear_fault')
            ),
        )
        processes = [
            subprocess.Popen(
                [
                    sys.executable,
                    '-m',
                    'billiard_shot.ros',
                    name,
                    '--ros-args',
                    *settings,
                    '--log-level',
                    'warn',
                ],
                env=shell.environment,
            )
            for name, settings in NODES.items()
        ]
        stack.callback(stop, processes, signal.SIGINT)
        safety = block('ros2 topic pub')
        priority = 'renice -n -10 $$ > /dev/null 2>&1; '  # like the driver's, where permitted
        # Not in a session of its own: Linux divides busy cores among sessions first (autogroups),
        # and one that is nearly idle may then wait for seconds, whatever its priority.
        publishers = subprocess.Popen(
            ['bash', '-c', priority + safety + 'wait'], env=shell.environment, process_group=0
        )
        stack.callback(lambda: os.killpg(publishers.pid, signal.SIGKILL))
        yield shell


def stop(processes: list[subprocess.Popen[str]], number: int) -> None:
    for process in processes:
        process.send_signal(number)
    for process in processes:
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@pytest.fixture
def shell(all_nodes: Shell) -> Shell:
    """Return the shell with the nodes in order; a ball out of reach would be refused first."""
    all_nodes.prepare()
    return all_nodes


def test_one_command_plans_and_waits_for_the_operator_who_fires(shell):
    process = shell.begin(block("ros2 run billiard_shot player '"))
    said = read_until(process, 'aimed ')
    assert 'executed' not in said
    fire = said.rpartition('Enter, or: ')[2].strip()
    assert re.sub('shot_id: .*}', 'shot_id: }', fire) == re.sub('shot_id: .*}', 'shot_id: }', ARM)
    _, answer = shell.run(ARM)
    assert "got 'direct 1f0c52b7-1'" in answer, answer
    _, answer = shell.run(fire)
    assert 'success=True' in answer, answer
    rest, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said + rest
    assert 'executed    OK: done' in rest
    assert 'target      reached' in rest
    # and this is what the page shows
    shown = re.sub(r'[0-9a-f]{8}-\d', 'ID', block('executed', 'text'))
    said = re.sub(r'[0-9a-f]{8}-\d', 'ID', said)
    pattern = re.sub(r'[\d.]+', r'[\\d.e-]+', re.escape(shown).replace(r'\.', '.'))
    assert re.search(pattern.replace(r'\+', r'\W?').replace(r'\-', '-?'), said + rest), said + rest


def test_step_by_step_with_the_ros2_command(shell):
    code, said = shell.run(block('ros2 action send_goal /plan_shot'))
    assert code == 0, said
    assert 'Goal finished with status: 4' in said  # SUCCEEDED
    assert len(said.splitlines()) < 120, 'it fits a screen or two'
    executed = shell.begin(block('ros2 topic echo'))
    said = read_until(executed, 'waiting to be armed')
    said += read_until(executed, 'shot_id')
    shot_id = said.rpartition('shot_id: ')[2].strip()
    code, answer = shell.run(ARM.replace('direct 1f0c52b7-1', shot_id))
    assert 'success=True' in answer, answer
    rest, _ = executed.communicate(timeout=PATIENCE)
    assert 'outcome: 0' in rest, said + rest
    assert 'struck: true' in rest
    assert 'Goal finished with status: 4' in rest


def test_in_python(shell):
    process = shell.begin([sys.executable, '-u', '-c', block('import', 'python')])
    process.stdin.write('yes\n')
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said
    assert said.splitlines()[-1] == 'done'


def test_the_player_plays_strokes_from_a_file_and_for_several_targets(shell, tmp_path):
    strokes = tmp_path / 'strokes.yaml'
    strokes.write_text('- {name: one, b: 0.2, speed: 0.4}\n- {name: two, a: 0.1, speed: 0.5}\n')
    targets = ['{rest: [0.2, 0.1]}', '{pass: [-0.2, -0.1]}']
    arguments = [*PLAYER, *targets, '--strokes', str(strokes), '--arm']
    code, said = shell.run(arguments)
    assert code == 0, said
    assert said.count('executed    OK') == 4
    assert all(f'{name}: 0.' in said for name in ('one', 'two'))
    assert 'target      reached' in said
    assert 'target      not judged' in said


@pytest.mark.parametrize(
    ('arguments', 'code', 'words'),
    [
        ([*PLAYER, '--speed', '6.5', '--arm'], 1, 'SPEED_OUT_OF_LIMITS: stroke.speed: 6.5 m/s'),
        (
            [*PLAYER, '--speed', '1', '--wait', '1', '--ros-args', '-r', '__ns:=/nobody'],
            3,
            '/nobody/predictor: no such node is known so far; waited for 1 s',
        ),
        (
            [*PLAYER, '--speed', '1', '--simulate-safety-inputs'],
            3,
            # of 'estop' or 'interlock', whichever is discovered first
            'this cell has safety equipment',
        ),
        ([*PLAYER, '{rest: [90, 0]}', '--budget', '100'], 1, 'no stroke'),
        ([*PLAYER, '{pot: 8}'], 1, 'target.balls needs a ball; the scene has only the cue ball'),
    ],
)
def test_exit_codes_and_messages(shell, arguments, code, words):
    found, said = shell.run(arguments)
    assert found == code, said
    assert words in said
    assert 'Traceback' not in said


@pytest.mark.parametrize(
    ('program', 'arguments', 'words'),
    [
        (player, '', 'stroke is missing; give --speed and --azimuth-deg'),
        (predict_shot, '', 'stroke is missing; give --speed and --azimuth-deg'),
        (player, '--game ../../x', 'or a module such as package.module'),
        (player, '--speed 0', 'speed must be above 0, got 0.0'),
        (player, '--speed fast', "'fast'"),
        (player, '--speed 1 --scene no_such_scene', 'no_such_scene'),
        (player, '--speed 1 --valid-for -1', '--valid-for must be a finite number above 0'),
        (player, "'{rest: 3}'", 'rest must be two finite numbers, (x, y), got 3'),
        (player, "'{rest: ['", 'TARGET'),
        (player, '--speed 1 --serve', '--serve must not be given together with a stroke'),
        (
            player,
            "'{rest: [0, 0]}' --budget -1",
            '--budget must be a whole number, at least 1, got -1',
        ),
    ],
)
def test_wrong_arguments_end_with_exit_code_2(program, arguments, words, capsys):
    with pytest.raises(SystemExit) as ended:
        program.main(shlex.split(arguments))
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_a_player_that_is_ended_cancels_its_shot(shell):
    process = shell.begin([*PLAYER, '--b', '0.2', '--speed', '0.5'])
    read_until(process, 'aimed ')
    process.send_signal(signal.SIGTERM)
    said, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + signal.SIGTERM, said
    assert 'Traceback' not in said
    _, answer = shell.run(ARM)
    assert 'not possible in state DISARMED' in answer

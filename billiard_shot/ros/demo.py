"""
Run all nodes and their clients, each in its own process: `make demo`.

First the predictor answers for the shots of the paper. Then the simulated mechanical cue plays
shots on a simulated table, and the outcomes are compared with the predictions. At the end the
planner finds the strokes. The ROS domain is private, so that neither a robot nor a second demo can
interfere.
"""

from collections.abc import Iterator
import contextlib
import os
from pathlib import Path
import signal
import subprocess
import sys

from domain_coordinator import domain_id

SIMULATION = tuple(
    word
    for setting in (
        'estop_timeout:=2.0',
        'interlock_timeout:=2.0',
        'joint_states_timeout:=2.0',
        'motion_timeout:=10.0',
        'command_timeout:=2.0',
    )
    for word in ('-p', setting)
)
"""Time-outs for many processes on few cores: those of config/simulation.yaml."""

NODES = {
    'predictor': ('-p', 'scene:=paper'),
    'cue_driver': ('-p', 'autostart:=true', *SIMULATION, '--log-level', 'warn'),
    'cue_sim': (*SIMULATION, '--log-level', 'warn'),
    'table_sim': ('-p', 'real_time_factor:=4.0', '--log-level', 'warn'),
    'planner': ('-p', 'scene:=paper', '-p', 'plan_at_start:=false', '--log-level', 'warn'),
}
"""Nodes and their arguments."""


def quiet_environment(domain: int) -> dict[str, str]:
    """Environment of processes in the ROS domain `domain`, restricted to this machine."""
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    profile = Path(__file__).resolve().parents[2] / 'config' / 'fastdds.xml'
    if profile.exists():  # in a source checkout: speeds up discovery
        environment['FASTDDS_DEFAULT_PROFILES_FILE'] = str(profile)
    return environment


STROKES = Path(__file__).with_name('demo_strokes.yaml')
"""Strokes that are played in sequence, each from the resting place of the ball."""

TARGETS = ('{rest: [0.5, -0.3], radius: 0.1}', '{rest: [-0.2, 0.5], radius: 0.1}')
"""Targets for which strokes are planned and played."""

UNATTENDED = ('--arm', '--simulate-safety-inputs')
"""Options for a simulation without an operator."""


def run_client(name: str, environment: dict[str, str], *arguments: str) -> int:
    """Run a client to its end, and return its exit code."""
    command = [sys.executable, '-m', f'billiard_shot.ros.{name}', *arguments]
    return subprocess.run(command, env=environment, check=False).returncode


@contextlib.contextmanager
def running(names: list[str], environment: dict[str, str]) -> Iterator[None]:
    """Run nodes in the meantime; exit if one of them ends with an error."""
    nodes = [
        subprocess.Popen(
            [sys.executable, '-m', f'billiard_shot.ros.{name}', '--ros-args', *NODES[name]],
            env=environment,
        )
        for name in names
    ]
    try:
        yield
    finally:
        for node in nodes:
            node.send_signal(signal.SIGINT)
        codes = [node.wait(timeout=60) for node in nodes]
    if any(codes):
        sys.exit(f'exit codes of {", ".join(names)}: {codes}')


def main() -> None:
    """Start the nodes, run the clients, stop the nodes; exit with the first nonzero code."""
    with domain_id() as domain:
        environment = quiet_environment(domain)
        print(
            f'All nodes and clients run in their own processes, in the ROS domain {domain}.\n'
            'Frame table: x along the table, y across it, z up; the ball lies at (0, 0).\n',
            flush=True,
        )
        with running(['predictor'], environment):
            failed = run_client('client', environment)
        if not failed:
            print(
                'The mechanical cue and the table are simulated: predict, execute, compare.\n',
                flush=True,
            )
            with running(list(NODES), environment):
                failed = run_client(
                    'player', environment, '--strokes', str(STROKES), *UNATTENDED
                ) or run_client('plan_player', environment, *TARGETS, *UNATTENDED)
    sys.exit(failed)


if __name__ == '__main__':
    main()

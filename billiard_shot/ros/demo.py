"""
Every node in a process of its own, clients in others, and nobody else on the wire: `make demo`.

First the predictor answers for the shots of the paper. Then the mechanical cue, simulated like the
table, plays shots, and what comes of them is compared with what was predicted; in the end the
planner says what to play. The ROS domain is a private one, so that neither a robot nor a second
demo can get in between.
"""

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
        'joints_timeout:=2.0',
        'late:=10.0',
        'deadline:=2.0',
    )
    for word in ('-p', setting)
)
"""Time-outs for many processes on few cores: those of config/simulation.yaml."""

NODES = {
    'predictor': ('-p', 'scene:=paper'),
    'cue_driver': ('-p', 'autostart:=true', *SIMULATION, '--log-level', 'warn'),
    'cue_sim': (*SIMULATION, '--log-level', 'warn'),
    'table_sim': ('-p', 'haste:=4.0', '--log-level', 'warn'),
    'planner': ('-p', 'scene:=paper', '-p', 'plan_at_start:=false', '--log-level', 'warn'),
}
"""Nodes, and what they are started with."""


def quiet_environment(domain: int) -> dict[str, str]:
    """Environment of processes that talk in ROS domain `domain` on this machine only."""
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    profile = Path(__file__).resolve().parents[2] / 'config' / 'fastdds.xml'
    if profile.exists():  # in a source checkout: processes find each other sooner
        environment['FASTDDS_DEFAULT_PROFILES_FILE'] = str(profile)
    return environment


STROKES = Path(__file__).with_name('demo_strokes.yaml')
"""Strokes that are played one after the other, each from where the ball has come to rest."""

TARGETS = ('{rest: [0.5, -0.3], radius: 0.1}', '{rest: [-0.2, 0.5], radius: 0.1}')
"""Targets for which a stroke is planned and played."""

ALONE = ('--arm', '--simulate-safety-inputs')
"""Nobody attends the simulation."""


def run_client(name: str, environment: dict[str, str], *arguments: str) -> int:
    """Run a client to its end; its exit code."""
    command = [sys.executable, '-m', f'billiard_shot.ros.{name}', *arguments]
    return subprocess.run(command, env=environment, check=False).returncode


@contextlib.contextmanager
def running(names: list[str], environment: dict[str, str]):
    """Nodes that run meanwhile; they must end well in the end."""
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
        codes = [node.wait(timeout=10) for node in nodes]
    if any(codes):
        sys.exit(f'exit codes of {", ".join(names)}: {codes}')


def main() -> None:
    """Start the nodes, run the clients, stop the nodes; the exit code is the first that is bad."""
    with domain_id() as domain:
        environment = quiet_environment(domain)
        print(
            f'Nodes and their clients, each a process, in the ROS domain {domain}.\n'
            'Frame table: x along the table, y across it, z up; the ball lies at (0, 0).\n',
            flush=True,
        )
        with running(['predictor'], environment):
            failed = run_client('client', environment)
        if not failed:
            print(
                'The mechanical cue and the table, simulated: predicted, executed, compared.\n',
                flush=True,
            )
            with running(list(NODES), environment):
                failed = run_client(
                    'player', environment, '--strokes', str(STROKES), *ALONE
                ) or run_client('plan_player', environment, *TARGETS, *ALONE)
    sys.exit(failed)


if __name__ == '__main__':
    main()

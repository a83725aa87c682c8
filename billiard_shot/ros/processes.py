"""Nodes as processes of this machine, without the `ros2` command."""

from collections.abc import Iterator, Mapping, Sequence
import contextlib
import os
from pathlib import Path
import signal
import subprocess
import sys

# Places of the folder `config`: in a source checkout, and where pip installs it.
FOLDERS = (Path(__file__).resolve().parents[2], Path(sys.prefix) / 'share' / 'billiard_shot')


def config_file(name: str) -> Path:
    """Path of a file of the folder `config`; LookupError if it is not installed."""
    for folder in FOLDERS:
        if (path := folder / 'config' / name).exists():
            return path
    raise LookupError(f'config/{name} must be in one of {", ".join(map(str, FOLDERS))}')


# Time-outs for many processes on few cores.
SIMULATION = ('--params-file', str(config_file('simulation.yaml')))


def quick_environment() -> dict[str, str]:
    """Environment of processes that discover each other quickly on this machine."""
    profile = str(config_file('fastdds.xml'))
    return {'FASTDDS_DEFAULT_PROFILES_FILE': profile, **os.environ}


def quiet_environment(domain: int) -> dict[str, str]:
    """Environment of processes in the ROS domain `domain`, restricted to this machine."""
    return {
        **quick_environment(),
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }


def command(name: str, arguments: Sequence[str]) -> list[str]:
    """Command that runs a program of the package."""
    return [sys.executable, '-m', f'billiard_shot.ros.{name}', *arguments]


@contextlib.contextmanager
def running(
    nodes: Mapping[str, Sequence[str]], environment: Mapping[str, str]
) -> Iterator[dict[str, 'subprocess.Popen[bytes]']]:
    """Run nodes, which have ROS arguments, in the meantime; exit if one ends with an error."""
    processes = {
        name: subprocess.Popen(command(name, ['--ros-args', *arguments]), env=environment)
        for name, arguments in nodes.items()
    }
    try:
        yield processes
    finally:
        for process in processes.values():
            process.send_signal(signal.SIGINT)
        codes = {name: process.wait(timeout=60) for name, process in processes.items()}
    if failed := {name: code for name, code in codes.items() if code}:
        sys.exit(f'nodes that failed, and their exit codes: {failed}')

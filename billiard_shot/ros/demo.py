"""
The predictor in one process, its client in another, and nobody else on the wire: `make demo`.

The ROS domain is a private one, so that neither a robot nor a second demo can get in between.
"""
import os
from pathlib import Path
import signal
import subprocess
import sys

from domain_coordinator import domain_id


def quiet_environment(domain: int) -> dict[str, str]:
    """Environment of processes that talk in ROS domain `domain` on this machine only."""
    environment = {
        **os.environ, 'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    profile = Path(__file__).resolve().parents[2] / 'config' / 'fastdds.xml'
    if profile.exists():  # in a source checkout: processes find each other sooner
        environment['FASTDDS_DEFAULT_PROFILES_FILE'] = str(profile)
    return environment


def main() -> None:
    """Start the node, run the client, stop the node; the exit code is that of the worse."""
    with domain_id() as domain:
        environment = quiet_environment(domain)
        print(f'A predictor and its client, two processes in the ROS domain {domain}.\n'
              'Frame table: x along the table, y across it, z up; the ball lies at (0, 0).\n',
              flush=True)
        module = [sys.executable, '-m']
        node = subprocess.Popen(
            [*module, 'billiard_shot.ros.predictor', '--ros-args', '-p', 'scene:=paper'],
            env=environment)
        try:
            client = subprocess.run(
                [*module, 'billiard_shot.ros.client'], env=environment, check=False)
        finally:
            node.send_signal(signal.SIGINT)
            stopped = node.wait(timeout=10)
    sys.exit(client.returncode or stopped)


if __name__ == '__main__':
    main()

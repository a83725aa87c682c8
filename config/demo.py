"""
Run all nodes and their clients, each in its own process: `make demo`.

First the predictor answers for the shots of the paper. Then the simulated mechanical cue plays
strokes on a simulated table, two that are given and one that the planner finds, and the outcomes
are compared with the predictions. At the end the player clears three balls of a pool table. The
ROS domain is private, so that neither a robot nor a second demo can interfere.
"""

import subprocess
import sys

from domain_coordinator import domain_id

from billiard_shot.ros.robot import (
    command,
    config_file,
    nodes_of,
    OfRobot,
    quiet_environment,
    running,
)

PREDICTOR = {'predictor': ('-p', 'scene:=paper', '--log-level', 'warn')}
DEMO_SCENE = 'robot_table'  # of the mechanical cue
# Arguments of all nodes; each node takes those that it has.
QUICK = ('-p', 'real_time_factor:=4.0', '-p', 'rate:=100.0', '--log-level', 'error')

DEMO_STROKES = str(config_file('strokes/demo.yaml'))
TARGET = '{rest: [0.5, -0.3], radius: 0.1}'
GAME_OPTIONS = ('--game', 'practice', '--balls', '3', '--seed', '0')
UNATTENDED = ('--scene', DEMO_SCENE, '--arm', '--simulate-safety-inputs')
PLAYED = (TARGET, '--strokes', DEMO_STROKES, '--budget', '6000', *GAME_OPTIONS, *UNATTENDED)
"""
Arguments of the player.

The strokes are played in sequence, each from the resting place of the ball. Then a stroke is
planned for the target. In the game the first three balls lie at random, the cue ball is in hand.
"""

NEXT = """\
Three commands to try next, each in its own terminal:
  .venv/bin/robot --simulate
  .venv/bin/predict_shot --a 0.2 --elevation-deg 20 --speed 2
  .venv/bin/player --simulate-safety-inputs '{rest: [0.4, 0.2]}'  # type fire when it is aimed"""


def run_program(name: str, environment: dict[str, str], *arguments: str) -> int:
    """Run a client to its end, and return its exit code."""
    return subprocess.run(command(name, arguments), env=environment, check=False).returncode


def main() -> None:
    """Start the nodes, run the clients, stop the nodes; exit with the first nonzero code."""
    with domain_id() as domain:
        environment = quiet_environment(domain)
        print(
            f'All nodes and clients run in their own processes, in the ROS domain {domain}.\n'
            'Frame table: x along the table, y across it, z up; the ball lies at (0, 0).',
            flush=True,
        )
        with running(PREDICTOR, environment):
            strokes = str(config_file('strokes/paper.yaml'))
            failed = run_program('predict_shot', environment, '--strokes', strokes)
        if not failed:
            print(
                'A simulated cue plays two strokes, a planned one, and a game of three balls:',
                flush=True,
            )
            nodes = nodes_of(QUICK, OfRobot(scene=DEMO_SCENE, simulate=True))
            with running(nodes, environment):
                failed = run_program('player', environment, *PLAYED)
    if not failed:
        print(NEXT)
    sys.exit(failed)


if __name__ == '__main__':
    main()

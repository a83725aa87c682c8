"""
Run all nodes and their clients, each in its own process: `make demo`.

First the predictor answers for the shots of the paper. Then the simulated mechanical cue plays
shots on a simulated table, and the outcomes are compared with the predictions. Then the planner
finds the strokes, and at the end the player clears three balls of a pool table. The ROS domain is
private, so that neither a robot nor a second demo can interfere.
"""

from pathlib import Path
import subprocess
import sys

from domain_coordinator import domain_id

from billiard_shot.ros.processes import (
    command,
    config_file,
    quiet_environment,
    running,
    SIMULATION,
)

DEMO_SCENE = 'robot_table'
"""Scene of the mechanical cue."""

ON_IT, WARN = ('-p', f'scene:={DEMO_SCENE}'), ('--log-level', 'warn')
DEMO_PREDICTOR = {'predictor': ('-p', 'scene:=paper')}
NODES = {
    'predictor': (*ON_IT, *WARN),
    'cue_driver': (*ON_IT, '-p', 'autostart:=true', *SIMULATION, *WARN),
    'cue_sim': (*SIMULATION, '-p', 'rate:=100.0', *WARN),
    'table_sim': (*ON_IT, '-p', 'real_time_factor:=4.0', *WARN),
    'planner': (*ON_IT, *WARN),
}
"""Nodes and their arguments."""

STROKE_FILE = Path(__file__).with_name('demo_strokes.yaml')
"""Strokes that are played in sequence, each from the resting place of the ball."""

TARGETS = ('{rest: [0.5, -0.3], radius: 0.1}', '{rest: [-0.2, 0.5], radius: 0.1}')
"""Targets for which strokes are planned and played."""

GAME_OPTIONS = ('--game', 'practice', '--balls', '3', '--seed', '0')
"""Game that is played: the first three balls lie at random, the cue ball is in hand."""

UNATTENDED = ('--scene', DEMO_SCENE, '--arm', '--simulate-safety-inputs')
"""Options for a simulation without an operator."""

NEXT = """\
Three commands to try next, each in its own terminal:
  .venv/bin/robot --simulate
  .venv/bin/predict_shot --a 0.2 --elevation-deg 40 --speed 2
  .venv/bin/player --simulate-safety-inputs '{rest: [0.4, 0.2]}'     # type fire when it is aimed
Or, after `.venv/bin/robot --simulate --scene robot_table`, a game in which you fire each shot:
  .venv/bin/player --simulate-safety-inputs --scene robot_table --game practice --balls 3
"""


def run_client(name: str, environment: dict[str, str], *arguments: str) -> int:
    """Run a client to its end, and return its exit code."""
    return subprocess.run(command(name, arguments), env=environment, check=False).returncode


def main() -> None:
    """Start the nodes, run the clients, stop the nodes; exit with the first nonzero code."""
    with domain_id() as domain:
        environment = quiet_environment(domain)
        print(
            f'All nodes and clients run in their own processes, in the ROS domain {domain}.\n'
            'Frame table: x along the table, y across it, z up; the ball lies at (0, 0).\n',
            flush=True,
        )
        with running(DEMO_PREDICTOR, environment):
            strokes = str(config_file('strokes/paper.yaml'))
            failed = run_client('predict_shot', environment, '--strokes', strokes)
        if not failed:
            print(
                'The mechanical cue and the table are simulated: predict, execute, compare.\n',
                flush=True,
            )
            with running(NODES, environment):
                for said, arguments in (
                    ('', ('--strokes', str(STROKE_FILE))),
                    ('', (*TARGETS, '--budget', '6000')),
                    (
                        '\nThe player clears three balls: decides, aims, fires, watches.\n',
                        GAME_OPTIONS,
                    ),
                ):
                    print(said, end='', flush=True)
                    failed = failed or run_client('player', environment, *arguments, *UNATTENDED)
    if not failed:
        print(NEXT)
    sys.exit(failed)


if __name__ == '__main__':
    main()

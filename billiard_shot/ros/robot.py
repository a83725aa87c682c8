"""
Start the nodes on this machine, until Ctrl+C; for machines without the `ros2` command.

    robot --simulate
"""

from collections.abc import Sequence
import signal
import sys
import time

from billiard_shot.ros.node_runner import own_arguments, parser_of
from billiard_shot.ros.processes import quick_environment, running, SIMULATION

PROCESS_POLL_PERIOD = 0.2
"""Time between two checks whether all nodes still run [s]."""


def main(args: Sequence[str] | None = None) -> None:
    """Start the nodes; the exit code is 1 if one of them ends by itself."""
    given = list(sys.argv if args is None else ['', *args])
    own = own_arguments(args)
    ros = [each for each in given[1:] if each not in own and each != '--ros-args']
    codes = 'exit codes: 0 after Ctrl+C; 1 if a node ended by itself; 2 invalid arguments'
    parser = parser_of('robot', __doc__, codes)
    scene_help = 'bundled scene or YAML file for all nodes; its cue must be guided (paper)'
    parser.add_argument('--scene', default='paper', metavar='SCENE', help=scene_help)
    simulate_help = 'also start a simulated mechanism and table'
    parser.add_argument('--simulate', action='store_true', help=simulate_help)
    options = parser.parse_args(own)
    scene = ('-p', f'scene:={options.scene}', *ros)
    patience = SIMULATION if options.simulate else ()
    nodes = {
        'predictor': scene,
        'planner': scene,
        'cue_driver': (*scene, '-p', 'autostart:=true', *patience),
    }
    if options.simulate:
        nodes |= {'cue_sim': (*ros, *patience), 'table_sim': (*scene, *patience)}
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with running(nodes, quick_environment()) as processes:
        try:
            while all(process.poll() is None for process in processes.values()):
                time.sleep(PROCESS_POLL_PERIOD)
        except KeyboardInterrupt:
            return
    ended = [name for name, process in processes.items() if process.poll() is not None]
    sys.exit(f'robot: a node has ended: {", ".join(ended)}')


if __name__ == '__main__':
    main()

"""Start the nodes on this machine, until Ctrl+C; for machines without the `ros2` command."""

from collections.abc import Iterator, Mapping, Sequence
import contextlib
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from billiard_shot.cli.options import add_options, option
from billiard_shot.ros.node_runner import own_arguments, parser_of

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
    return [sys.executable, '-m', 'billiard_shot.ros', name, *arguments]


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


MORE_HELP = """\
ROS arguments hold for all nodes. The name of a node before a parameter makes it one of that node:

    robot --camera --ros-args -p "table_tracker:class_names:=['white=cue', 'solid']"

exit codes: 0 after Ctrl+C; 1 if a node ended by itself; 2 invalid arguments"""

PROCESS_POLL_PERIOD = 0.2  # s between two checks whether all nodes still run


@dataclass(frozen=True)
class OfRobot:
    """
    The scene and the nodes.

    Parameters
    ----------
    scene : SCENE
        Bundled scene or YAML file for all nodes; its cue must be guided (%(default)s).
    simulate : bool
        Also start a simulated table and, with the interface topic, a mechanism.
    camera : bool
        Also start the table_tracker, for the detections of a camera.
    pictures : bool
        Also start table_camera and table_tracker, for the pictures of a camera; a simulated table
        then publishes simulated_table.
    player : bool
        Also start the node that plays the turns of the action play_turn.
    interface : str
        How cue_driver commands the mechanism (%(default)s).
    record : FILE
        Also start the shot_recorder, which adds all shots to this file .csv.

    """

    scene: str = 'paper'
    simulate: bool = False
    camera: bool = False
    pictures: bool = False
    player: bool = False
    interface: str = option(default='topic', choices=('topic', 'follow_joint_trajectory'))
    record: str = ''


def nodes_of(ros: Sequence[str], robot: OfRobot) -> dict[str, tuple[str, ...]]:
    """Nodes and their ROS arguments; `ros` are arguments of all nodes."""
    patience = SIMULATION if robot.simulate else ()
    on_it = (*settings(scene=robot.scene), *ros)
    kept = '' if robot.simulate else state_file(ros)
    own = settings(autostart='true', interface=robot.interface)
    driver = (*settings(state_file=f"'{kept}'"), *on_it, *own, *patience)
    nodes = {'predictor': on_it, 'planner': on_it, 'cue_driver': driver}
    if robot.pictures:
        nodes['table_camera'] = on_it
    if robot.camera or robot.pictures:
        nodes['table_tracker'] = on_it
    if robot.record:
        nodes['shot_recorder'] = (*on_it, *settings(file=robot.record))
    if robot.player:
        nodes['player'] = (*ros, '--', '--serve', '--scene', robot.scene)
    if robot.simulate:
        table = ('-r', 'table_state:=simulated_table') if robot.pictures else ()
        camera = settings(camera=robot.camera and not robot.pictures)
        nodes['table_sim'] = (*on_it, *camera, *table, *patience)
        if robot.interface == 'topic':
            nodes['cue_sim'] = (*ros, *patience)
    return nodes


def settings(**values: object) -> tuple[str, ...]:
    """ROS arguments that set parameters."""
    return tuple(word for each in values for word in ('-p', f'{each}:={values[each]}'))


def state_file(ros: Sequence[str]) -> str:
    """Path of the file that keeps a latched state of the driver, for the namespace in `ros`."""
    spaces = [each.partition('__ns:=')[2].strip('/') for each in ros if '__ns:=' in each]
    home = Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')
    return str(home.joinpath('billiard_shot', *spaces[-1:], 'cue_driver.state'))


def main(args: Sequence[str] | None = None) -> None:
    """Start the nodes; the exit code is 1 if one of them ends by itself."""
    given = list(sys.argv if args is None else ['', *args])
    own = own_arguments(args)
    ros = [each for each in given[1:] if each not in (*own, '--ros-args', '--')]
    parser = parser_of('robot', __doc__, MORE_HELP)
    add_options(parser, OfRobot())
    options = parser.parse_args(own)
    nodes = nodes_of(ros, OfRobot(**vars(options)))
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    ended: list[str] = []
    with running(nodes, quick_environment()) as processes:
        try:
            while not ended:
                time.sleep(PROCESS_POLL_PERIOD)
                ended = [name for name, node in processes.items() if node.poll() is not None]
        except KeyboardInterrupt:
            return
    sys.exit(f'robot: a node has ended: {", ".join(ended)}')

"""
Start the nodes: `ros2 launch billiard_shot shot.launch.py scene:=robot_table simulate:=true`.

Its arguments:
    `scene`: name or path of a scene, for all nodes; if empty, that of the parameter files.
    `mechanism`: path of a YAML file with the mechanism; if empty, that of the parameter files.
    `frame`: name of the table's frame; if empty, that of the parameter files.
    `params_dir`: folder with a YAML file of parameters per node; default config/ of this package.
    `namespace`: namespace of all nodes, such as `cell1`.
    `use_sim_time`: true makes all nodes use the time of the topic /clock.
    `log_level`: logging level of all nodes, such as `debug`, or `cue_driver:=debug`.
    `cue`: false leaves out the cue_driver, for scenes whose cue is not guided.
    `simulate`: true also starts a simulated mechanism and a simulated table, with the longer
        time-outs of config/simulation.yaml.
    `model`: false leaves out the robot model of the mechanical cue and its transforms.
    `rviz`: true starts RViz, if it is installed, with a view of table, balls, stroke and plan.
    `autostart`: true configures and activates the cue_driver; false leaves that to the operator.

If a node of this package ends, the launch ends, and stops all other nodes.
"""

from pathlib import Path
import shutil

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import (
    LaunchConfiguration,
    PathJoinSubstitution,
    SubstitutionFailure,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import ExecutableInPackage, FindPackageShare
import yaml

from billiard_shot import Scene
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.urdf import urdf_of

# The kernel ends a node if its launch dies, even if the launch was killed. Linux only.
END_WITH_LAUNCH = 'setpriv --pdeathsig TERM ' if shutil.which('setpriv') else ''


def nodes(context):
    """
    List the actions that start the nodes.

    Everything that can fail is looked up here, before anything is started: if an action raises an
    exception, launch does not stop the processes that the actions before it have started.
    """

    def value(name):
        return LaunchConfiguration(name).perform(context)

    def is_on(name):
        return IfCondition(LaunchConfiguration(name)).evaluate(context)

    def process(package, executable, *arguments, **options):
        ExecutableInPackage(package=package, executable=executable).perform(context)
        level = value('log_level')
        return Node(
            package=package,
            executable=executable,
            exec_name=executable,
            output='screen',
            namespace=value('namespace') or None,
            prefix=[END_WITH_LAUNCH, LaunchConfiguration('launch-prefix', default='')],
            arguments=[*arguments, *(['--ros-args', '--log-level', level] if level else [])],
            **options,
        )

    def file_of(name):
        path = Path(value('params_dir'), f'{name}.yaml')
        if not path.is_file():
            raise RuntimeError(
                f'params_dir: {path} does not exist; the folder must have a file '
                'for each node that is started, as config/ of this package has'
            )
        return path

    def in_file(name, parameter, default):
        sections = (yaml.safe_load(file_of(name).read_text()) or {}).values()
        found = [
            each['ros__parameters'][parameter]
            for each in sections
            if parameter in each.get('ros__parameters', {})
        ]
        return found[-1] if found else default

    clock = {'use_sim_time': is_on('use_sim_time')}
    given = {
        name: ParameterValue(value(name), value_type=str)
        for name in ('scene', 'mechanism', 'frame')
        if value(name)
    }

    share = Path(FindPackageShare('billiard_shot').perform(context))
    time_outs = [str(share / 'config' / 'simulation.yaml')] if is_on('simulate') else []

    def node(name, **settings):
        files = [str(file_of(name)), *time_outs]
        return process(
            'billiard_shot',
            name,
            parameters=[*files, {**clock, **given, **settings}],
            on_exit=Shutdown(reason=f'{name} has ended'),
        )

    def table_frame():
        return value('frame') or in_file('table_display', 'frame', 'table')

    def robot_state_publisher():
        mechanism = Mechanism.load(value('mechanism') or in_file('cue_model', 'mechanism', ''))
        model = urdf_of(
            mechanism,
            table_frame(),
            in_file('cue_model', 'joint_names', JOINTS),
            in_file('cue_model', 'incline_joint', 'incline_angle'),
        )
        return process(
            'robot_state_publisher',
            'robot_state_publisher',
            parameters=[{**clock, 'robot_description': ParameterValue(model, value_type=str)}],
            on_exit=Shutdown(reason='robot_state_publisher has ended'),
        )

    def rviz():
        view = share / 'rviz' / 'shot.rviz'
        return process('rviz2', 'rviz2', '-d', str(view), '-f', table_frame(), parameters=[clock])

    def if_installed(make, *otherwise, message):
        try:
            return [make()]
        except (LookupError, SubstitutionFailure) as error:
            return [LogInfo(msg=f'WARNING: {message}: {error}'), *otherwise]

    cue, simulate, scene = is_on('cue'), is_on('simulate'), value('scene')
    if (cue or simulate) and scene and not Scene.load(scene).cue.guided:
        raise RuntimeError(
            f'scene: {scene!r} is not allowed with the mechanical cue; its cue must be guided, as '
            'in the scenes paper and robot_table; or leave the mechanical cue out with cue:=false '
            'and simulate:=false'
        )
    actions = [node('predictor'), node('planner'), node('table_display')]
    if cue:
        actions.append(node('cue_driver', autostart=is_on('autostart')))
    if simulate:
        actions += [node('cue_sim'), node('table_sim')]
    if is_on('model') and (cue or simulate):
        own = node('cue_model')
        # robot_state_publisher needs the elevation, which cue_driver publishes in joint_states.
        actions += (
            [own]
            if not cue
            else if_installed(
                robot_state_publisher,
                own,
                message='the node cue_model replaces robot_state_publisher',
            )
        )
    if is_on('rviz'):
        actions += if_installed(rviz, message='RViz is not started')
    return actions


def generate_launch_description():
    def argument(name, default, description):
        return DeclareLaunchArgument(name, default_value=default, description=description)

    return LaunchDescription(
        [
            argument('scene', '', 'Scene, name or path; if empty, that of the parameter files'),
            argument(
                'mechanism',
                '',
                'YAML file of the mechanism; if empty, that of the parameter files',
            ),
            argument(
                'frame', '', "Name of the table's frame; if empty, that of the parameter files"
            ),
            argument(
                'params_dir',
                PathJoinSubstitution([FindPackageShare('billiard_shot'), 'config']),
                'Folder with YAML files of parameters',
            ),
            argument('namespace', '', 'Namespace of all nodes'),
            argument('use_sim_time', 'false', 'Use the time of the topic /clock'),
            argument('log_level', '', 'Logging level of all nodes; if empty, info'),
            argument('cue', 'true', 'Start the cue_driver'),
            argument('simulate', 'false', 'Start a simulated mechanism and table'),
            argument('model', 'true', 'Robot model of the mechanical cue, and its transforms'),
            argument('rviz', 'false', 'Start RViz, if it is installed'),
            argument('autostart', 'true', 'Activate the cue_driver'),
            OpaqueFunction(function=nodes),
        ]
    )

"""
Start the nodes: `ros2 launch billiard_shot shot.launch.py scene:=robot_table simulate:=true`.

If a node ends, the launch starts it again after two seconds; the other nodes go on.
The nodes use the profile config/fastdds.xml of Fast DDS, unless FASTDDS_DEFAULT_PROFILES_FILE
names another one.
"""

import shutil

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import (
    AndSubstitution,
    EnvironmentVariable,
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    NotSubstitution,
    OrSubstitution,
    PathJoinSubstitution,
)
from launch_ros.actions import LifecycleNode, Node, PushROSNamespace
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

# The kernel ends a node if its launch dies, even if the launch was killed. Linux only.
END_WITH_LAUNCH = 'setpriv --pdeathsig TERM ' if shutil.which('setpriv') else ''

ARGUMENTS = {
    'scene': ('robot_table', 'name or path of a scene'),
    'mechanism': ('', 'path of a YAML file with the mechanism; if empty, the default mechanism'),
    'frame': ('table', "name of the table's frame"),
    'params_dir': (
        PathJoinSubstitution([FindPackageShare('billiard_shot'), 'config']),
        'folder with a YAML file of parameters per node, by default config/ of this package; '
        'scene, mechanism and frame, which all nodes have in common, take precedence',
    ),
    'namespace': ('', 'namespace of all nodes, such as cell1'),
    'use_sim_time': ('false', 'true makes all nodes use the time of the topic /clock'),
    'log_level': ('info', 'logging level of all nodes, such as debug, or cue_driver:=debug'),
    'cue': ('true', 'false leaves out the cue_driver, for scenes whose cue is not guided'),
    'simulate': (
        'false',
        'true also starts a simulated table and, if interface is topic, a simulated mechanism, '
        'with the longer time-outs of config/simulation.yaml',
    ),
    'interface': (
        'topic',
        'how cue_driver commands the mechanism: topic, or follow_joint_trajectory for a '
        'controller of yours',
    ),
    'control': (
        'false',
        'true starts a joint_trajectory_controller of ros2_control with the controllers and the '
        'hardware of config/controllers.yaml and of the robot model; interface is then '
        'follow_joint_trajectory',
    ),
    'camera': (
        'false',
        'true starts the table_tracker, which makes table_state from the detections of a camera; '
        'with simulate, the simulated table publishes the detections',
    ),
    'pictures': (
        'false',
        'true starts the table_camera and the table_tracker: the detections are made from the '
        'pictures of a camera; with simulate, the simulated table publishes simulated_table',
    ),
    'player': ('false', 'true starts the node that plays the turns of the action play_turn'),
    'record': ('', 'file .csv to which the shot_recorder adds all shots; if empty, no recorder'),
    'model': ('true', 'false leaves out the robot model of the mechanical cue and its transforms'),
    'rviz': ('false', 'true starts RViz, with a view of table, balls, stroke and plan'),
    'autostart': ('true', 'false leaves it to the operator to configure and activate cue_driver'),
}
"""Default and description of each argument."""

VALUE = {name: LaunchConfiguration(name) for name in ARGUMENTS}
SHARE = FindPackageShare('billiard_shot')
VIEW = PathJoinSubstitution([SHARE, 'rviz', 'shot.rviz'])
SIMULATION = PathJoinSubstitution([SHARE, 'config', 'simulation.yaml'])
FOR_ALL = ('scene', 'mechanism', 'frame')
CLOCK = {'use_sim_time': ParameterValue(VALUE['use_sim_time'], value_type=bool)}
HOME = EnvironmentVariable(
    'ROS_HOME', default_value=[EnvironmentVariable('HOME', default_value=''), '/.ros']
)
STATE_FILE = [
    HOME,
    '/billiard_shot/',
    LaunchConfiguration('ros_namespace', default=''),  # with the namespaces of groups around this
    '/cue_driver.state',
]
PROFILE = 'FASTDDS_DEFAULT_PROFILES_FILE'
OWN_PROFILE = PathJoinSubstitution([SHARE, 'config', 'fastdds.xml'])
SPAWNED = 'joint_state_broadcaster', 'joint_trajectory_controller'
CONTROLLERS = PathJoinSubstitution([VALUE['params_dir'], 'controllers.yaml'])


def process(package, executable, kind=Node, arguments=(), **options):
    """Node that ends with the launch, and is started again if it ends earlier."""
    return kind(
        package=package,
        executable=executable,
        exec_name=executable,
        output='screen',
        prefix=[END_WITH_LAUNCH, LaunchConfiguration('launch-prefix', default='')],
        arguments=[*arguments, '--ros-args', '--log-level', VALUE['log_level']],
        **{'respawn': True, 'respawn_delay': 2.0, **options},
    )


def node(executable, kind=Node, settings=(), **options):
    """Node of this package: first its parameter file, then what the launch sets."""
    file = PathJoinSubstitution([VALUE['params_dir'], f'{executable}.yaml'])
    return process(
        'billiard_shot',
        executable,
        kind,
        parameters=[
            file,
            IfElseSubstitution(VALUE['simulate'], SIMULATION, file),
            {each: ParameterValue(VALUE[each], value_type=str) for each in FOR_ALL},
            CLOCK,
            *settings,
        ],
        **options,
    )


def generate_launch_description():
    """List what is started, in this order."""
    with_cue, simulated, controlled = (VALUE[name] for name in ('cue', 'simulate', 'control'))
    interface = IfElseSubstitution(controlled, 'follow_joint_trajectory', VALUE['interface'])
    simulates_cue = AndSubstitution(simulated, EqualsSubstitution(interface, 'topic'))
    tracked = OrSubstitution(VALUE['camera'], VALUE['pictures'])
    simulates_camera = IfElseSubstitution(VALUE['pictures'], 'false', VALUE['camera'])
    simulated_table = IfElseSubstitution(VALUE['pictures'], 'simulated_table', 'table_state')
    any_cue = OrSubstitution(OrSubstitution(with_cue, simulated), controlled)
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            SetEnvironmentVariable(
                PROFILE, EnvironmentVariable(PROFILE, default_value=OWN_PROFILE)
            ),
            PushROSNamespace(VALUE['namespace']),
            process(
                'rviz2',
                'rviz2',
                parameters=[CLOCK],
                arguments=['-d', VIEW, '-f', VALUE['frame']],
                condition=IfCondition(VALUE['rviz']),
                respawn=False,
            ),
            node('predictor'),
            node('planner'),
            node('table_display'),
            node(
                'cue_driver',
                LifecycleNode,
                [
                    {
                        'autostart': ParameterValue(VALUE['autostart'], value_type=bool),
                        'interface': ParameterValue(interface, value_type=str),
                        'state_file': ParameterValue(
                            IfElseSubstitution(simulated, '', STATE_FILE), value_type=str
                        ),
                    }
                ],
                name='cue_driver',
                namespace='',
                condition=IfCondition(with_cue),
            ),
            process(
                'billiard_shot',
                'player',
                parameters=[CLOCK],
                arguments=[
                    *('--serve', '--scene', VALUE['scene']),
                    *('--mechanism', VALUE['mechanism']),
                ],
                condition=IfCondition(VALUE['player']),
            ),
            node(
                'table_camera',
                LifecycleNode,
                name='table_camera',
                namespace='',
                condition=IfCondition(VALUE['pictures']),
            ),
            node('table_tracker', condition=IfCondition(tracked)),
            node(
                'shot_recorder',
                settings=[{'file': ParameterValue(VALUE['record'], value_type=str)}],
                condition=IfCondition(NotSubstitution(EqualsSubstitution(VALUE['record'], ''))),
            ),
            node(
                'table_sim',
                settings=[{'camera': ParameterValue(simulates_camera, value_type=bool)}],
                remappings=[('table_state', simulated_table)],
                condition=IfCondition(simulated),
            ),
            node('cue_sim', condition=IfCondition(simulates_cue)),
            node('cue_model', condition=IfCondition(AndSubstitution(VALUE['model'], any_cue))),
            GroupAction(
                [
                    process(
                        'controller_manager', 'ros2_control_node', parameters=[CONTROLLERS, CLOCK]
                    ),
                    Node(
                        package='controller_manager',
                        executable='spawner',
                        arguments=[*SPAWNED, '--param-file', CONTROLLERS],
                    ),
                ],
                condition=IfCondition(controlled),
            ),
        ]
    )

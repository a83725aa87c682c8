"""
Start the nodes: `ros2 launch billiard_shot shot.launch.py scene:=paper simulate:=true`.

Its arguments:
    `params_dir`: folder with a YAML file of parameters per node, default config/ of this package.
    `scene`: name or path of a scene; where given, it wins over the files.
    `cue`: false leaves out the cue_driver, for scenes whose cue is no mechanical one.
    `simulate`: true starts a simulated mechanism and a simulated table too.
    `rviz`: true starts RViz with a view of the table, the balls, the stroke and what comes of it.
    `autostart`: true configures and activates the cue_driver; false leaves that to somebody else.
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def nodes(context):
    scene = LaunchConfiguration('scene').perform(context)
    scenes = [{'scene': scene}] if scene else []
    autostart = LaunchConfiguration('autostart').perform(context).lower() in ('true', '1', 'yes')

    def node(name, *parameters, **options):
        file = PathJoinSubstitution([LaunchConfiguration('params_dir'), f'{name}.yaml'])
        return Node(package='billiard_shot', executable=name, output='screen',
                    parameters=[file, *parameters], **options)

    view = PathJoinSubstitution([FindPackageShare('billiard_shot'), 'rviz', 'shot.rviz'])

    def where(argument):
        return {'condition': IfCondition(LaunchConfiguration(argument))}

    return [
        node('predictor', *scenes),
        node('planner', *scenes),
        node('table_display', *scenes),
        node('cue_driver', *scenes, {'autostart': autostart}, **where('cue')),
        node('cue_sim', **where('simulate')),
        node('table_sim', *scenes, **where('simulate')),
        Node(package='rviz2', executable='rviz2', output='screen', arguments=['-d', view],
             **where('rviz')),
    ]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument(
            'params_dir', description='Folder with YAML files of parameters',
            default_value=PathJoinSubstitution([FindPackageShare('billiard_shot'), 'config'])),
        DeclareLaunchArgument(
            'scene', default_value='', description='Scene, name or path; empty: as in the files'),
        DeclareLaunchArgument('cue', default_value='true', description='Start the cue_driver'),
        DeclareLaunchArgument(
            'simulate', default_value='false', description='Simulated mechanism and table'),
        DeclareLaunchArgument('rviz', default_value='false', description='Start RViz'),
        DeclareLaunchArgument(
            'autostart', default_value='true', description='Activate the cue_driver'),
        OpaqueFunction(function=nodes),
    ])

"""
Start the predictor: `ros2 launch billiard_shot predictor.launch.py scene:=paper`.

Arguments
    `params_file`: parameters of the node, default config/predictor.yaml of this package.
    `scene`: name or path of a scene; where given, it wins over the file.
"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def predictor(context):
    scene = LaunchConfiguration('scene').perform(context)
    return [Node(
        package='billiard_shot',
        executable='predictor',
        output='screen',
        parameters=[LaunchConfiguration('params_file'), *([{'scene': scene}] if scene else [])],
    )]


def generate_launch_description():
    default = PathJoinSubstitution(
        [FindPackageShare('billiard_shot'), 'config', 'predictor.yaml'])
    return LaunchDescription([
        DeclareLaunchArgument(
            'params_file', default_value=default, description='YAML file of parameters'),
        DeclareLaunchArgument(
            'scene', default_value='', description='Scene, name or path; empty: as in the file'),
        OpaqueFunction(function=predictor),
    ])

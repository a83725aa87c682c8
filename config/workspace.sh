#!/usr/bin/env bash
# What a workspace does with a ROS 2 from apt: `make workspace`, in a container of ros:jazzy or the
# like. It installs packages, builds and tests both packages, launches the nodes, and runs the demo.
set -eo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
ln -sfn billiard_shot/msg_defs src/billiard_shot_msgs
apt-get update
rosdep update
rosdep install -y --from-paths src --ignore-src
. "/opt/ros/$ROS_DISTRO/setup.bash"

colcon build
. install/setup.bash
python3 -c 'from billiard_shot import machine_code; assert machine_code.is_loaded()'
colcon test --return-code-on-test-failure --event-handlers console_direct+

ros2 launch billiard_shot shot.launch.py scene:=robot_table simulate:=true &
trap 'kill -INT $!; wait' EXIT
ros2 run billiard_shot predict_shot --a 0.2 --elevation-deg 20 --speed 2
ros2 node list | grep cue_driver

make -C src/billiard_shot demo

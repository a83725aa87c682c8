"""The nodes on ROS 2 Jazzy: what rclpy cannot do there is taken away from the one that is here."""

from pathlib import Path
import subprocess
import sys

from node_process import starts_and_ends
import pytest

rclpy = pytest.importorskip('rclpy', reason='needs ROS 2')
pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2 and msg_defs')
import billiard_shot.ros

MODULES = sorted(path.stem for path in Path(billiard_shot.ros.__file__).parent.glob('[a-z]*.py'))

AS_ON_JAZZY = """
import importlib, sys
import rclpy, rclpy.action, rclpy.lifecycle, rclpy.node, rclpy.parameter
import rclpy.client, rclpy.publisher, rclpy.service, rclpy.subscription, rclpy.task
init = rclpy.init
def init_without_result(*args, **options):
    init(*args, **options)
rclpy.init = init_without_result
for generic in (
        rclpy.action.ActionClient, rclpy.action.ActionServer, rclpy.client.Client,
        rclpy.parameter.Parameter, rclpy.publisher.Publisher, rclpy.service.Service,
        rclpy.subscription.Subscription):
    generic.__class_getitem__ = None
"""


def test_no_module_needs_more_than_jazzy():
    program = (
        AS_ON_JAZZY
        + f"""
for module in {MODULES}:
    importlib.import_module('billiard_shot.ros.' + module)
"""
    )
    assert len(MODULES) > 15
    subprocess.run([sys.executable, '-c', program], check=True)


def test_a_node_starts_and_ends(domain):
    program = AS_ON_JAZZY + 'from billiard_shot.ros.cue_sim import main\nmain()\n'
    starts_and_ends([sys.executable, '-c', program])

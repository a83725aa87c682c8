"""
The driver at rest, and under a flood of messages: processor time, and the emergency stop.

Real processes and middleware, the mechanism simulated. Fails if a limit is not kept:
- processor time of the idle nodes, as a fraction of a core: the driver at most 10 %, the simulated
  mechanism, the robot model and the display at most 5 % each;
- from the publication of the emergency stop to the arrival of the command to stop at a listener,
  always at most 20 ms: while one process calls `clear_fault`, and while one publishes
  `joint_states` of another robot, as fast as they can.

It takes about a minute.

    python benchmarks/driver.py [--seconds S] [--stops N]
"""

import argparse
import contextlib
import gc
import os
from pathlib import Path
from time import perf_counter

from domain_coordinator import domain_id
import numpy as np
from tools.processes import processes
from tools.stopping import stop_latencies
from tools.timing import QUICK, Report

from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.node_runner import initialized
from billiard_shot.ros.robot import quiet_environment, running

LIMITS = {'cue_driver': 10.0, 'cue_sim': 5.0, 'cue_model': 5.0, 'table_display': 5.0}
"""Largest processor time at rest, by node [% of a core]."""

LATEST = 20.0
"""Largest time from the publication of the emergency stop to the command to stop [ms]."""

FLOODS = {
    'clear_fault': """
import rclpy
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('flood')
client = node.create_client(Trigger, 'cue_driver/clear_fault')
client.wait_for_service()
while True:
    for _ in range(6):
        client.call_async(Trigger.Request())
    rclpy.spin_once(node, timeout_sec=0.01)
""",
    'joint_states': """
import time
import rclpy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
node = rclpy.create_node('flood')
publisher = node.create_publisher(JointState, 'joint_states', 10)
names = [f'arm_{i}' for i in range(7)]
while True:
    publisher.publish(JointState(name=names, position=[0.0] * 7, velocity=[0.0] * 7))
    time.sleep(0.0005)
""",
}


def processor_time(process):
    """Processor time that a process has used [s]."""
    fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def fractions_at_rest(player, nodes, seconds):
    """Processor time of processes while nothing happens [% of a core]."""
    before = [processor_time(each) for each in nodes]
    begin = perf_counter()
    player.until(lambda: False, seconds)
    elapsed = perf_counter() - begin
    return [
        100.0 * (processor_time(each) - was) / elapsed
        for each, was in zip(nodes, before, strict=True)
    ]


def main():
    """Measure; exit code 1 if a limit is not kept."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--seconds', type=float, default=3.0 if QUICK else 8.0)
    parser.add_argument('--stops', type=int, default=5 if QUICK else 20)
    options = parser.parse_args()
    report = Report('The driver, at rest and under a flood')
    with domain_id() as domain:
        os.environ.update(quiet_environment(domain))
        quiet = ('--log-level', 'error')
        nodes = dict.fromkeys((*LIMITS, 'table_sim', 'predictor'), quiet)
        nodes['cue_driver'] = ('-p', 'autostart:=true', *quiet)
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, -10)  # the safety inputs come from this process
        with running(nodes, os.environ) as cell, initialized():
            player = RobotClient(simulate_safety_inputs=True)
            gc.freeze()
            player.wait_for_all()
            player.until(lambda: False, 3.0)
            measured = [cell[name] for name in LIMITS]
            used_at_rest = fractions_at_rest(player, measured, options.seconds)
            for name, used in zip(LIMITS, used_at_rest, strict=True):
                report.row(f' {name} at rest', used, '% of a core', LIMITS[name])
            for name, program in FLOODS.items():
                with processes([('-c', program)]):
                    player.until(lambda: False, 3.0)
                    latencies = stop_latencies(player, options.stops)
                row = f'emergency stop under a flood of {name}, {options.stops} stops: '
                report.row(f' {row}median', float(np.median(latencies)), 'ms')
                report.row(f'{row}largest', max(latencies), 'ms', LATEST)
    report.end()


if __name__ == '__main__':
    main()

"""
Cost of the ROS service, compared with the simplest possible service in the same run.

Two processes, real middleware. Fails if a limit is not kept:
- p50 of a PredictShot round trip with a 200-point trajectory at most 4 times that of
  std_srvs/SetBool, calls taken in turns;
- 10,000 calls in a row: every one answered, the node's resident memory grows by less than 5 MB.

    python benchmarks/service.py [--calls N]
"""

import argparse
import os
import signal
import subprocess
import sys
from time import perf_counter

from billiard_shot_msgs.srv import PredictShot
from domain_coordinator import domain_id
import numpy as np
import rclpy
from std_srvs.srv import SetBool
from tools.caller import Caller
from tools.timing import QUICK, Report, resident

from billiard_shot import Scene, Status
from billiard_shot.ros.node_runner import initialized
from billiard_shot.ros.predict_shot import request_of
from billiard_shot.ros.robot import config_file, quiet_environment
from billiard_shot.shot.stroke import read_strokes

YARDSTICK = """
import rclpy
from rclpy.executors import ExternalShutdownException
from std_srvs.srv import SetBool

from billiard_shot.ros.node_runner import initialized
try:
    with initialized():
        node = rclpy.create_node('yardstick')
        node.create_service(SetBool, 'yardstick', lambda request, response: response)
        rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
MAX_RATIO = 4.0
MAX_GROWTH = 5.0  # MB


def ratio(predictor, yardstick, request, rounds=2000):
    """Ratio of the medians of both services' round trips, called in turns."""
    times = {predictor: [], yardstick: []}
    for _ in range(rounds):
        for client, message in ((predictor, request), (yardstick, SetBool.Request())):
            start = perf_counter()
            client.call(message)
            times[client].append(1e3 * (perf_counter() - start))
    medians = []
    for client in times:
        p50, p99 = np.percentile(times[client][rounds // 10 :], (50, 99))
        print(f'{client.client.service_name:16} p50 {p50:6.3f} ms   p99 {p99:6.3f} ms')
        medians.append(p50)
    return medians[0] / medians[1]


def growth(client, process, requests, calls):
    """Growth of the process's memory, in MB, over `calls` calls that are all answered."""
    for i in range(500):
        client.call(requests[i % len(requests)])
    before, start = resident(process), perf_counter()
    for i in range(calls):
        answer = client.call(requests[i % len(requests)])
        assert not Status(answer.status).refused, answer.message
        assert len(answer.trajectory.times) == 200
    seconds, grown = perf_counter() - start, resident(process) - before
    print(
        f'{calls} calls answered in {seconds:.1f} s; resident memory {before:.1f} MB, '
        f'grown by {grown:.2f} MB'
    )
    return grown


def main():
    """Run both measurements; exit code 1 if a limit is not kept."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--calls', type=int, default=1000 if QUICK else 10_000)
    calls = parser.parse_args().calls
    report = Report('The service')
    with domain_id() as domain:
        os.environ.update(quiet_environment(domain))
        processes = [
            subprocess.Popen([sys.executable, '-m', 'billiard_shot.ros', 'predictor']),
            subprocess.Popen([sys.executable, '-c', YARDSTICK]),
        ]
        try:
            with initialized():
                node = rclpy.create_node('benchmark')
                predictor = Caller(node, PredictShot, 'predict_shot')
                yardstick = Caller(node, SetBool, 'yardstick')
                assert predictor.client.wait_for_service(60.0)
                assert yardstick.client.wait_for_service(60.0)
                scene = Scene.load('paper')
                strokes = read_strokes(config_file('strokes/paper.yaml'), scene.cue_ball)
                requests = [request_of(stroke, scene) for stroke in strokes.values()]
                for request in requests:
                    request.sample_count = 200
                measured = ratio(predictor, yardstick, requests[0])
                report.row(
                    'round trip of PredictShot over SetBool, median', measured, 'x', MAX_RATIO
                )
                grown = growth(predictor, processes[0], requests, calls)
        finally:
            for process in processes:
                process.send_signal(signal.SIGINT)
                process.wait(timeout=10)
    report.row(f' growth of memory in {calls} calls', grown, 'MB', MAX_GROWTH)
    report.end()


if __name__ == '__main__':
    main()

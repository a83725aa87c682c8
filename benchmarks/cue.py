"""
The mechanical cue's nodes under load: latency of the emergency stop, and many shots.

Real processes and middleware, the mechanism simulated. Fails if a limit is not kept:
- from the publication of the e-stop's message to the arrival of the zero command at a listener of
  the mechanism's topic: p99 at most 20 ms, while two niced processes plan on both cores;
- many shots in a row: every one executed, no state missed, the speed within 0.5 % and the angle
  within 0.02 degrees of the planned values, and no node grown by more than 5 MB.

    python benchmarks/cue.py [--stops N] [--shots N]
"""

import argparse
import contextlib
import gc
import os
import tempfile
from time import perf_counter

from domain_coordinator import domain_id
import numpy as np
from std_srvs.srv import Trigger
from tools.caller import Caller
from tools.processes import processes
from tools.stopping import clear, goal, stop_latencies, stroke
from tools.timing import QUICK, Report, resident

from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import MOVING, SafetyState
from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.node_runner import initialized
from billiard_shot.ros.robot import quiet_environment, running

PLANNING = """
import os, signal
os.setpriority(os.PRIO_PROCESS, 0, 10)
signal.signal(signal.SIGINT, signal.SIG_DFL)
import numpy as np
from billiard_shot import predict_batch, Scene
random = np.random.default_rng(os.getpid())
scene = Scene.load('paper')
while True:
    normals = random.normal(size=(4000, 3)) * 0.3 - (1.0, 0.0, 0.0)
    predict_batch(scene, normals, np.tile((2.0, 0.0, -0.2), (4000, 1)))
"""
DRIVES = """
base_x:  {min: -2.5, max: 2.5, speed: 10.0, acceleration: 100.0, jerk: 4000.0}
base_y:  {min: -2.0, max: 2.0, speed: 10.0, acceleration: 100.0, jerk: 4000.0}
base_z:  {min: 0.0, max: 1.2, speed: 10.0, acceleration: 100.0, jerk: 4000.0}
azimuth: {min: -3.2, max: 3.2, speed: 30.0, acceleration: 300.0, jerk: 9000.0}
incline: {min: 0.40, max: 0.72, speed: 5.0, acceleration: 50.0, jerk: 2000.0}
"""
"""A mechanism that aims quickly, so that many shots take minutes."""

WAY = [*MOVING, SafetyState.DISARMED]


def play(player, clear_fault, reset, count):
    """Play shots in a row; return failures, worst speed (relative) and angle errors (degrees)."""
    random = np.random.default_rng(2)
    speed = angle = 0.0
    failed = 0
    for i in range(count):
        snapshot = int(reset.call(Trigger.Request()).message.split()[1])
        assert player.until(lambda wanted=snapshot: player.table.snapshot_id >= wanted, 5.0)
        player.until(lambda: False, 0.02)  # so that the driver has received it too
        planned = stroke(random)
        del player.states[:-1]
        result = player.execute(goal(player, planned)).result
        complete = player.until(lambda: player.states[-1].state == SafetyState.DISARMED, 5.0)
        seen = [SafetyState(each.state) for each in player.states[1:]]
        if result.outcome != GoalOutcome.OK or not complete or seen != WAY:
            failed += 1
            names = ' '.join(state.name for state in seen)
            print(f'  shot {i}: {GoalOutcome(result.outcome).name}: {result.message}: {names}')
            player.until(lambda: clear(player, clear_fault), 1.0)
            continue
        speed = max(speed, abs(result.strike.speed / planned.speed - 1))
        angle = max(angle, abs(np.degrees(result.elevation - planned.offsets[2])))
    return failed, speed, angle


def main():
    """Run both measurements; exit code 1 if a limit is not kept."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--stops', type=int, default=10 if QUICK else 40)
    parser.add_argument('--shots', type=int, default=10 if QUICK else 60)
    options = parser.parse_args()
    report = Report('The mechanical cue, simulated')
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file, domain_id() as domain:
        file.write(DRIVES)
        file.flush()
        os.environ.update(quiet_environment(domain))
        quiet = ('--log-level', 'error')
        quick = ('-p', f'mechanism:={file.name}', *quiet)
        nodes = {
            'cue_driver': ('-p', 'autostart:=true', *quick),
            'cue_sim': quick,
            'table_sim': ('-p', 'real_time_factor:=1000.0', *quiet),
            'predictor': quiet,
        }
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, -10)  # as a mechanism, which has its own processor
        with running(nodes, os.environ) as cell, initialized():
            player = RobotClient(simulate_safety_inputs=True)
            gc.freeze()
            player.wait_for_all()
            clear_fault, reset = (
                Caller(player, Trigger, name)
                for name in ('cue_driver/clear_fault', 'table_sim/reset')
            )
            with processes([('-c', PLANNING)] * 2):
                player.until(lambda: False, 5.0)
                latencies = stop_latencies(player, options.stops)
            report.row(
                'emergency stop while both cores plan, 99 % within',
                float(np.percentile(latencies, 99)),
                'ms',
                20.0,
            )
            failed, *_ = play(player, clear_fault, reset, 50)
            before = [resident(process) for process in cell.values()]
            begin = perf_counter()
            more, speed, angle = play(player, clear_fault, reset, options.shots)
            report.row(
                f'shots not executed, or with a state missed, of {50 + options.shots}',
                failed + more,
                '',
                0.5,
            )
            report.row(' a shot', (perf_counter() - begin) / options.shots, 's')
            report.row('speed at contact, worst error', 100 * speed, '%', 0.5)
            report.row('elevation at contact, worst error', angle, 'degrees', 0.02)
            grown = max(
                resident(each) - was for each, was in zip(cell.values(), before, strict=True)
            )
            report.row(' memory of a node grown by, at most', grown, 'MB', 5.0)
    report.end()


if __name__ == '__main__':
    main()

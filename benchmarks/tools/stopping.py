"""How quickly the driver stops the cue after the emergency stop has been pressed."""

from functools import partial
from time import perf_counter

import numpy as np
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from billiard_shot import Scene, Stroke
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.conversions import is_stop
from tools.caller import Caller

SCENE = Scene.load('paper')

ATTEMPTS = 30
"""Number of goals of which the driver may refuse all but the last."""


def stroke(random):
    """A stroke that the mechanism can play."""
    return Stroke.from_offsets(
        *random.uniform(-0.3, 0.3, 2),
        random.uniform(0.0, 0.3),
        random.uniform(-3.0, 3.0),
        random.uniform(0.2, 1.5),
    )


def goal(player, planned):
    """A goal to play a stroke."""
    return player.goal(planned, player.balls(), SCENE, 'shot')


def aim(player, random):
    """
    Send goals until the cue moves.

    The driver refuses a goal while a joint still moves from the shot before, and for four seconds
    after its process did not run for a while.
    """
    refused = ''
    for _ in range(ATTEMPTS):
        del player.states[:-1]
        sent = player.execute_shot.send_goal_async(goal(player, stroke(random)))
        assert player.until(sent.done, 10.0)
        ended = sent.result().get_result_async()
        player.until(partial(_moves_or_ended, player, ended), 10.0)
        if _has_been(player, SafetyState.AIMING):
            return
        refused = ended.result().result.message if ended.done() else 'no answer'
        player.until(lambda: False, 0.2)
    raise AssertionError(refused)


def stop_latencies(player, count, seed=1):
    """
    Times [ms] from the publication of the emergency stop to the command to stop.

    The subscription and the client stay: their end could deadlock the driver (Fast DDS 3.2).
    """
    estop = player.safety_publishers['estop']  # the publisher that says later that it is released
    caller = Caller(player, Trigger, 'cue_driver/clear_fault')
    stopped = []
    player.create_subscription(
        JointTrajectory,
        'cue_driver/actuation',
        lambda message: stopped.append(perf_counter()) if is_stop(message) else None,
        10,
    )
    random = np.random.default_rng(seed)
    latencies = []
    for _ in range(count):
        aim(player, random)
        player.until(lambda: False, 0.05 + 0.1 * random.random())
        stopped.clear()
        player.safety_inputs_on = False
        begin = perf_counter()
        estop.publish(Bool(data=True))
        assert player.until(lambda: stopped, 5.0)
        latencies.append(1e3 * (stopped[0] - begin))
        assert player.until(lambda: _has_been(player, SafetyState.ESTOP), 10.0), (
            player.states[-1]  # the driver stopped for another reason
        )
        player.safety_inputs_on = True
        assert player.until(lambda: clear(player, caller), 60.0)
    return latencies


def clear(player, caller):
    """Clear a latched state; return whether the driver is disarmed."""
    if player.states[-1].state == SafetyState.DISARMED:
        return True
    try:
        return caller.call(Trigger.Request(), repeatable=True).success
    except TimeoutError:  # a flood of requests may displace this one from the queue
        return False


def _moves_or_ended(player, ended):
    return _has_been(player, SafetyState.AIMING) or ended.done()


def _has_been(player, state):
    return any(each.state == state for each in player.states)

"""A game recorded from pictures to outcomes: its bag gives the same tables, decisions, rulings."""

from contextlib import nullcontext
import math
from pathlib import Path
import re
from tempfile import mkdtemp
from time import sleep
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('rosbags', reason='needs rosbags')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')

from action_msgs.msg import GoalStatus
from bags import content, messages, recording, topics_of
from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import BallState, GameState
from cell import WITH_CAMERA
import numpy as np
from rclpy.action import ActionClient
from waiting import PATIENCE

from billiard_shot import Scene
from billiard_shot.game.rack import find_agent
from billiard_shot.game.referee import start
from billiard_shot.perception.tracker import BallTracker, TrackerSettings
from billiard_shot.ros import turn
from billiard_shot.ros.conversions import (
    ball_message,
    plan_message,
    plan_of,
    seconds,
    sightings_of,
)
from billiard_shot.ros.table_tracker import class_names_of, detected_balls, TableTrackerParameters
from billiard_shot.ros.turn import balls_message, game_state_message, GameTable, places_of
from billiard_shot.table.run.outline import outline_of

SPACE = '/game'
SCENE = Scene.load('robot_table')
NODES = WITH_CAMERA | {'player': ('--', '--serve', '--scene', 'robot_table')}
ELSEWHERE = re.compile('/(planner/.*|table_display/.*|tf|tf_static|robot_description)$')
"""Topics of nodes that are tested elsewhere: `planner`, `table_display` and `cue_model`."""
PICTURES, TABLE = f'{SPACE}/detections', f'{SPACE}/table_state'
PLAN, STRIKE = f'{SPACE}/cue_driver/plan', f'{SPACE}/cue_driver/strike'
SHOT, FEEDBACK = f'{SPACE}/table_sim/shot', f'{SPACE}/play_turn/_action/feedback'
SEED = 1
LONGEST = 600.0
"""Longest time of a turn [s]."""


# --- a bag of a game ----------------------------------------------------------------------------


def played(client, action, goal, patience):
    """Play a turn; return the result, or None if its answer is late or lost."""
    sent = action.send_goal_async(goal)
    if not client.until(sent.done, 5.0) or not sent.result().accepted:
        return None
    ended = sent.result().get_result_async()
    return ended.result().result if client.until(ended.done, patience) else None


def record(cell, bag, state):
    """Record a turn that the action plays; return its result."""
    client = cell.player
    action = ActionClient(client, PlayTurn, f'{SPACE}/play_turn')
    topics = [
        topic for topic in topics_of('ros2 bag record', SPACE) if not ELSEWHERE.search(topic)
    ]
    # Until the server knows this client, answers are lost.
    refused = PlayTurn.Goal(state=GameState(game='cricket'))
    assert client.until(lambda: played(client, action, refused, 5.0), PATIENCE)
    for topic in topics:
        assert client.until(lambda topic=topic: client.count_publishers(topic), PATIENCE), topic
    goal = PlayTurn.Goal(state=game_state_message(state), seed=SEED, arm=True)
    goal.balls = balls_message(state.balls)
    with recording(bag, topics):
        cell.call('table_tracker/reset')  # what it saw before is not in the bag
        result = played(client, action, goal, LONGEST)
        client.until(lambda: False, 2.0)  # the last messages are still under way
    action.destroy()
    assert result, 'the turn has not ended'
    assert result.outcome == PlayTurn.Result.OVER, result.message
    return result


# --- pictures to tables -------------------------------------------------------------------------


def check_tables(bag):
    """
    Track the balls of the recorded pictures: every recorded table is the same.

    A tracker that has balls and then publishes none was told to forget them.
    """
    own = TableTrackerParameters()
    reading = class_names_of(own.class_names), own.min_score, own.detection_noise**2
    pictures = {stamp_of(picture): picture.detections for picture in content(bag, PICTURES)}
    tracker, last, compared = None, None, 0
    for _, written, table in messages(bag, TABLE):
        assert last is None or table.snapshot_id <= last.snapshot_id + 1, 'a table is missing'
        is_new = last is None or stamp_of(table) != stamp_of(last)
        last = table
        if not table.balls and (tracker is None or balls_of(tracker, tracker.time)):
            tracker = BallTracker(SCENE.ball.radius, TrackerSettings(), outline_of(SCENE).holes)
        if tracker is None:
            continue
        if is_new:
            balls, _ = detected_balls(pictures[stamp_of(table)], *reading, np.eye(3), np.zeros(3))
            tracker.update(balls, stamp_of(table))
        # Whether a ball is lost was decided some time between these two.
        first, later = (balls_of(tracker, time) for time in (tracker.time, 1e-9 * written))
        assert {ball.id for ball in table.balls} == first.keys()
        assert all(ball in (first[ball.id], later[ball.id]) for ball in table.balls)
        compared += bool(table.balls)
    assert compared > 100


def stamp_of(message):
    """Time of a picture [s]; that of a table is rounded to a number of this size."""
    return seconds(message.header.stamp)


def balls_of(tracker, time):
    """Messages of the balls of a tracker, by name."""
    pocketed = {name: BallState(id=name, state=BallState.POCKETED) for name in tracker.pocketed}
    return pocketed | {
        name: ball_message(name, ball) for name, ball in tracker.balls(time).items()
    }


# --- tables to decisions and rulings ------------------------------------------------------------


class RecordedShot(NamedTuple):
    """What a bag has of a shot."""

    plan: Any
    strike: Any
    record: Any  # of the simulated table
    balls: Any  # at the ruling


def shots_of(bag):
    """Shots of the game in a bag; it may begin with latched messages of an earlier shot."""
    plans, strikes, records, shots, struck = {}, {}, {}, [], ''
    for topic, _, message in messages(bag, TABLE, PLAN, STRIKE, SHOT, FEEDBACK):
        if topic == TABLE:
            table = message
        elif topic == PLAN:
            plans[message.shot_id] = message
        elif topic == STRIKE:
            struck = message.shot_id
            strikes[struck] = message
        elif topic == SHOT:
            records[struck] = message
        elif message.feedback.stage == PlayTurn.Feedback.JUDGED:
            name = message.feedback.shot_id
            balls = sightings_of(table.balls, table.header.stamp)
            shots.append(RecordedShot(plans[name], strikes[name], records[name], balls))
    return shots


class RecordedClient:
    """Client of a turn that hears what a bag has, and keeps the plans of the turn."""

    is_canceled = False
    to_the_end = nullcontext

    def __init__(self, shots):
        self.shots, self.plans = shots, []

    def create_subscription(self, kind, topic, callback, qos):
        self.hear_record = callback

    def create_client(self, *_):
        return None

    def count_publishers(self, topic):
        return 1

    def until(self, condition, seconds):
        while not condition():
            sleep(0.01)
        return True

    def wait_for_rest(self, strike=None, unseen_time=None):
        if strike:
            return self.shots[len(self.plans) - 1].balls
        return sightings_of(self.shots[len(self.plans)].plan.balls)

    def goal(self, stroke, balls, scene, name):
        shot = self.shots[len(self.plans)]
        shot_id = shot.plan.shot_id
        assert shot_id.startswith(f'{name} ')
        self.plans.append(plan_message(plan_of(stroke, balls, scene, shot_id), shot.plan.header))
        return shot

    def execute(self, shot, may_fire, on_aimed):
        on_aimed()
        self.hear_record(shot.record)
        result = SimpleNamespace(strike=shot.strike, struck=True)
        return SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED, result=result)


def check_turn(bag, shots, state, result):
    """Play the turn again: the same agent decides the same, and the shots are ruled the same."""
    client, told = RecordedClient(shots), []
    again = turn.Turn(
        GameTable(client, SCENE),
        find_agent('player')(SCENE, SEED),
        lambda stage, message, shot_id, _: told.append((stage, message, shot_id)),
        None,
        True,
        state,
    )
    assert again.play() == (result.outcome, result.message)
    assert client.plans == [shot.plan for shot in shots]
    assert again.shots == result.shots
    assert game_state_message(again.state) == result.state
    left = places_of(result.balls)
    assert left.keys() == again.state.balls.keys()
    assert all(math.dist(left[name], place) < 1e-3 for name, place in again.state.balls.items())
    feedback = [each.feedback for each in content(bag, FEEDBACK)]
    assert told == [
        (each.stage, each.message, each.shot_id)
        for each in feedback
        if each.stage != PlayTurn.Feedback.PLACE  # the balls of a replay lie where they lay
    ]


@pytest.mark.nightly
def test_a_recorded_game_is_decided_and_ruled_the_same(cell, tmp_path):
    bag, state = Path(mkdtemp(dir=tmp_path)) / 'game', start('practice', SCENE, seed=SEED, balls=2)
    result = record(cell, bag, state)
    check_tables(bag)
    seen = [sightings_of(table.balls, table.header.stamp) for table in content(bag, TABLE)]
    shots = shots_of(bag)
    assert len(shots) == len(result.shots)
    assert all(sightings_of(shot.plan.balls) in seen for shot in shots)
    check_turn(bag, shots, state, result)

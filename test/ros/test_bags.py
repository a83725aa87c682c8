"""A shot is recorded to an MCAP bag and replayed, by the topics that docs/ros.md names."""

import gc
import re
import sys
import time

from programs import ran
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('rosbags', reason='needs rosbags')

from bags import content, kind_of, PAGE, recording, ROOT, SHARED, topics_of, types, writing
from billiard_shot_msgs.msg import TableState
from cell import PATIENT
import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.interfaces import Nodetype, QosDurability
from rosbags.rosbag2 import Reader
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import MarkerArray
from waiting import spin_until

from billiard_shot import Scene, Stroke
from billiard_shot.cue.inputs import JointFeedback
from billiard_shot.cue.mechanism import JOINTS
from billiard_shot.ros.client import RobotClient
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.ros.player import play_shot
from billiard_shot.scene.placement import CUE_BALL

SPACE, COPY = '/recorded', '/replayed'
NODES = {**PATIENT, 'table_sim': ('-p', 'real_time_factor:=4.0'), 'table_display': ()}
ELSEWHERE = re.compile('/(planner/.*|tf|tf_static|robot_description|detections|play_turn/.*)$')
"""Topics of nodes that are tested elsewhere: `planner`, `cue_model`, a camera, and `player`."""
STROKE = Stroke.from_offsets(a=0.0, b=0.3, elevation=0.05, azimuth=0.0, speed=0.5)
UNKNOWN = '_NODE_NAME_UNKNOWN_'
"""Name of a node of which the middleware has told nothing yet, but for its topics."""
RATE = 4.0
"""How many times faster than recorded a bag is replayed."""


def is_at_rest(latest):
    """Whether the cue stands still."""
    last = latest[f'{SPACE}/joint_states']
    joints = JointFeedback(JOINTS).update(last.name, last.position, last.velocity)
    if joints is None:  # of other joints
        return False
    _, velocities = joints
    return np.abs(velocities).max() < 1e-3


def replay(bag, topics, node, copies):
    """Publish topics of a bag under other names, and the bag's time on `/clock`."""
    clock = node.create_publisher(Clock, '/clock', 10)
    publishers = {}
    with Reader(bag) as reader:
        connections = [each for each in reader.connections if each.topic in topics]
        for each in connections:
            (offered,) = each.ext.offered_qos_profiles
            publishers[each.topic] = node.create_publisher(
                kind_of(each.msgtype),
                copies(each.topic),
                QoSProfile(
                    depth=offered.depth,
                    reliability=ReliabilityPolicy[offered.reliability.name],
                    durability=DurabilityPolicy[offered.durability.name],
                ),
            )
        assert spin_until(
            node,
            lambda: all(each.get_subscription_count() for each in (clock, *publishers.values())),
        )
        last = None
        for connection, stamp, data in reader.messages(connections):
            time.sleep((stamp - (last or stamp)) / 1e9 / RATE)
            last = stamp
            now = Clock()
            now.clock.sec, now.clock.nanosec = divmod(stamp, 10**9)
            clock.publish(now)
            publishers[connection.topic].publish(bytes(data))
    return clock, *publishers.values()


def ends_of(node):
    """Return all publishers and listeners that a node knows of, each with its topic."""
    return [
        (topic, end)
        for topic, _ in node.get_topic_names_and_types()
        for ends in (node.get_publishers_info_by_topic, node.get_subscriptions_info_by_topic)
        for end in ends(topic)
    ]


def nameless(node):
    """Return our topics with ends of which no node is known; nodes of other tests may stay so."""
    ends = ends_of(node)
    return {topic for topic, end in ends if topic.startswith(SPACE) and end.node_name == UNKNOWN}


@pytest.fixture(scope='module')
def recorded(node, launch, tmp_path_factory):
    """Return a bag with a shot of nodes that have ended by now, and the QoS of their topics."""
    gc.freeze()  # a long collection would be a silence of the emergency stop
    path = tmp_path_factory.mktemp('bags') / 'shot'
    processes = [
        launch(name, '-r', f'__ns:={SPACE}', *arguments) for name, arguments in NODES.items()
    ]
    player = RobotClient('player', SPACE, simulate_safety_inputs=True)
    player.wait_for_all()
    topics = topics_of('ros2 bag record', SPACE)
    assert {f'{SPACE}/planner/best', f'{SPACE}/planner/markers', '/tf'} <= set(topics)
    topics = [topic for topic in topics if not ELSEWHERE.search(topic)]
    for topic in topics:
        assert player.until(lambda topic=topic: player.count_publishers(topic), 120.0), (
            f'docs/ros.md: nobody publishes {topic}'
        )
    assert player.until(lambda: not nameless(player), 120.0), nameless(player)
    qos = ends_of(player)
    with recording(path, topics) as latest:
        goal = player.goal(STROKE, player.balls(), Scene.load('paper'), 'follow', 60.0)
        assert play_shot(player, 'follow', goal, arm=True)
        rest = player.balls()[CUE_BALL].position
        assert player.until(lambda: is_at_rest(latest), 120.0), 'the cue moves on'
    player.destroy_node()
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait(120.0)
    assert content(path, f'{SPACE}/table_state')[-1].balls[0].position.x == rest[0]
    return path, qos


@pytest.fixture
def bag(recorded):
    return recorded[0]


def test_qos_is_as_documented(recorded):
    """Every topic of the nodes is in the table of docs/ros.md, with what each end asks for."""
    _, ends = recorded
    section = PAGE.partition('## Topics\n')[2].partition('\n## ')[0]
    (best_effort,) = re.findall(r'except `(\w+)`.* \(best effort\)', section)
    documented = {
        topic if topic in SHARED else f'{SPACE}/{topic}': (
            'RELIABLE',
            durability.upper().replace(' ', '_'),
        )
        for durability, names in re.findall(
            r'^- \*(volatile|transient local)\*: ((?:.+\n)+?)(?=-|\n)', section, re.MULTILINE
        )
        for topic in re.findall(r'`(.*?)`', names)
        if topic != best_effort
    }
    found = {}
    for topic, end in ends:
        # Nodes of other tests may be in the domain too.
        ours = end.node_name in NODES and end.node_namespace == SPACE
        if ours and not re.search(r'/_|/rosout|/parameter_events', topic):
            qos = end.qos_profile
            found.setdefault(topic, set()).add((qos.reliability.name, qos.durability.name))
    assert found == {
        topic: {qos} for topic, qos in documented.items() if not ELSEWHERE.search(topic)
    }


def test_a_bag_has_what_a_shot_is_made_of(bag):
    """Files that `ros2 bag` reads; every topic with messages; latched ones stay latched."""
    assert {file.suffix for file in bag.iterdir()} == {'.mcap', '.yaml'}
    with Reader(bag) as reader:
        latched = {
            each.topic.removeprefix(SPACE)
            for each in reader.connections
            if each.ext.offered_qos_profiles[0].durability is QosDurability.TRANSIENT_LOCAL
        }
        empty = {
            each.topic.removeprefix(SPACE) for each in reader.connections if not each.msgcount
        }
    assert not empty, 'nothing was recorded'
    assert {
        '/table_state',
        '/cue_driver/state',
        '/table_display/table',
        '/predictor/markers',
    } <= latched
    assert not latched & {'/joint_states', '/estop', '/interlock', '/cue_driver/actuation'}
    (strike,) = content(bag, f'{SPACE}/cue_driver/strike')
    assert strike.speed == pytest.approx(STROKE.speed, rel=0.01)


def test_a_replayed_bag_is_shown_as_it_was(bag, node, launch):
    """A new table_display publishes the same markers, with the bag's time."""
    topics = topics_of('ros2 bag play', SPACE)
    assert {topic.removeprefix(SPACE) for topic in topics} == {'/table_state', '/joint_states'}
    for name in ('table_display', 'cue_model'):  # who listens to the topics of the bag
        launch(name, '-r', f'__ns:={COPY}', '-p', 'use_sim_time:=true')
    shown = {'balls': [], 'table': []}
    for name, arrays in shown.items():
        node.create_subscription(
            MarkerArray, f'{COPY}/table_display/{name}', arrays.append, LATCHED
        )
    wanted = {name: content(bag, f'{SPACE}/table_display/{name}')[-1].markers for name in shown}

    def differ():
        return [
            name
            for name, arrays in shown.items()
            if not (arrays and alike(arrays[-1].markers, wanted[name]))
        ]

    for _ in range(3):  # Fast DDS may never tell a listener of a publisher: then with new ones
        publishers = replay(bag, topics, node, lambda topic: topic.replace(SPACE, COPY))
        if spin_until(node, lambda: not differ(), 60.0):
            break
        for each in publishers:
            node.destroy_publisher(each)
    assert not differ(), 'the last markers differ'
    with Reader(bag) as reader:
        begin, end = reader.start_time // 10**9, reader.end_time // 10**9
    assert begin <= shown['balls'][-1].markers[0].header.stamp.sec <= end


@pytest.mark.parametrize('is_changed', [False, True])
def test_a_bag_with_another_definition_is_refused_by_name(tmp_path, is_changed):
    """A ball has one field more: the type of the table differs, another type does not."""
    kinds = {'/table_state': 'billiard_shot_msgs/msg/TableState', '/estop': 'std_msgs/msg/Bool'}
    recorded = types()
    constants, fields = recorded.fielddefs['billiard_shot_msgs/msg/BallState']
    if is_changed:
        fields = [*fields, ('spin', (Nodetype.BASE, ('float64', 0)))]
    recorded.fielddefs['billiard_shot_msgs/msg/BallState'] = constants, fields
    table, bag = TableState(snapshot_id=7), tmp_path / 'bag'
    with writing(bag) as add:
        for topic, kind in kinds.items():
            write = add(topic, kind, recorded.hash_rihs01(kind))
            if topic == '/table_state':
                write(serialize_message(table))
    check = [sys.executable, ROOT / 'docs' / 'examples' / 'check_bag.py', bag]
    said = ran(check)
    assert said.returncode == is_changed, said.stderr
    if is_changed:
        with pytest.raises(ValueError, match=f'definitions of {kinds["/table_state"]}$'):
            content(bag, '/table_state')
        assert said.stdout.startswith(f'/table_state: the definition of {kinds["/table_state"]} ')
    else:
        assert content(bag, '/table_state') == [table]
        assert not said.stdout


def alike(some, others):
    """Whether markers are the same, but for motions of balls that a display does not show."""
    return [described(each) for each in some] == [described(each) for each in others] and close(
        some, others
    )


def close(some, others):
    """Whether markers are in the same places."""
    return all(
        abs(a - b) < 1e-4
        for one, other in zip(some, others, strict=True)
        for a, b in zip(places(one), places(other), strict=True)
    )


def described(marker):
    return (
        marker.ns,
        marker.id,
        marker.type,
        marker.text,
        marker.color,
        marker.scale,
        len(marker.points),
    )


def places(marker):
    return [
        number
        for point in (marker.pose.position, *marker.points)
        for number in (point.x, point.y, point.z)
    ]

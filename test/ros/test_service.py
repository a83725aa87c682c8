"""The service between two processes: what the library says is what comes back."""

from dataclasses import replace
from itertools import groupby
import math
import threading
from time import monotonic, sleep
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallState, BallTrajectory, TableState
from billiard_shot_msgs.srv import PredictShot, PredictShots
from geometry_msgs.msg import Point
from nav_msgs.msg import Path
from paper import PAPER_SHOTS, request_for
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray
from waiting import PATIENCE, PatientCaller, spin_until

from billiard_shot import effects_of, predict, Scene, Status, Stroke
from billiard_shot.ros import conversions
from billiard_shot.ros import predictor as predictor_node
from billiard_shot.ros.node_runner import BURST, LATCHED
from billiard_shot.ros.predict_shot import request_of, response_text
from billiard_shot.ros.predictor import Predictor, PredictorParameters
from billiard_shot.shot.replay import from_json

SCENE = Scene.load('paper')
RADIUS = SCENE.ball.radius


def answer_and_when(client, request):
    """Return the answer of a service that knows its client, and when the server sent it [ns]."""
    client.call_async(request)
    deadline = monotonic() + PATIENCE
    while monotonic() < deadline:
        header, answer = client.handle.take_response(PredictShot.Response)
        if header:
            return answer, header.source_timestamp
        sleep(0.01)
    raise TimeoutError(client.service_name)


def components(vector):
    return [vector.x, vector.y, vector.z]


@pytest.mark.parametrize('name', PAPER_SHOTS)
def test_answer_is_the_librarys(ask, name):
    shot = predict(SCENE, PAPER_SHOTS[name])
    answer = ask(request_for(name))
    assert answer.status == shot.status
    assert answer.message == shot.message
    np.testing.assert_allclose(components(answer.velocity), shot.velocity, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(components(answer.spin), shot.spin, rtol=1e-6, atol=1e-7)
    assert answer.cue_speed == pytest.approx(shot.cue_speed, rel=1e-6)
    trajectory = answer.trajectory
    positions = conversions.vectors(trajectory.positions)
    np.testing.assert_allclose(positions[0], (0, 0, RADIUS), atol=1e-9)
    np.testing.assert_allclose(positions[-1], shot.trajectory.final_position, atol=1e-4)
    assert trajectory.motion[-1] == BallTrajectory.REST
    assert {effect.name for effect in answer.effects} == {e.name for e in effects_of(shot)}
    assert 0.0 <= answer.error_estimate <= 1e-4
    assert answer.compute_time > 0.0
    assert f'{answer.velocity.x:.4f}' in response_text(answer)


@pytest.mark.parametrize('name', PAPER_SHOTS)
def test_a_short_answer_has_the_start_every_change_of_motion_and_the_rest(ask, name):
    request = request_for(name)
    short = ask(request).trajectory
    segments = predict(SCENE, PAPER_SHOTS[name]).trajectory.segments
    assert list(short.motion) == [
        motion for motion, _ in groupby(segment.motion for segment in segments)
    ]
    assert short.motion[-1] == BallTrajectory.REST
    request.sample_count = 5000
    fine = ask(request).trajectory
    assert len(fine.times) == len(fine.motion) == 5000
    assert np.ptp(np.diff(fine.times)) < 1e-9
    positions = [conversions.vectors(each.positions) for each in (fine, short)]
    for i, time in enumerate(short.times):
        nearest = np.abs(np.array(fine.times) - time).argmin()
        np.testing.assert_allclose(positions[0][nearest], positions[1][i], atol=2e-3)


def test_sample_count_tolerance_and_ball_position(ask):
    request = request_for('horizontal')
    at_origin = ask(request)
    request.sample_count = 50
    request.tolerance = 1e-6
    for point in (request.cue_pose.position, request.ball_position):
        point.x += 0.3
        point.y -= 0.2
    answer = ask(request)
    assert answer.status == Status.OK
    assert len(answer.trajectory.times) == 50
    assert answer.error_estimate <= 1e-6
    np.testing.assert_allclose(
        conversions.vectors(answer.trajectory.positions)[-1],
        conversions.vectors(at_origin.trajectory.positions)[-1] + (0.3, -0.2, 0),
        atol=2e-4,
    )


def test_ball_height_may_be_given_in_full(ask):
    request = request_for('jump')
    short = ask(request)
    for measured in (RADIUS, RADIUS + 2e-6, RADIUS - 4e-3):
        request.ball_position.z = measured
        assert ask(request).velocity == short.velocity


def test_ball_from_the_table_state(ask, node):
    request = request_for('vertical')
    request.use_table_state = True
    answer = ask(request)
    assert answer.status == Status.INVALID_REQUEST
    assert 'table_state' in answer.message

    publisher = node.create_publisher(TableState, 'table_state', LATCHED)
    request.cue_pose.position.x += 0.4
    request.cue_pose.position.y += 0.1

    def answer_comes(words, *balls):
        """Publish `balls`, and ask until the answer says so: state and request travel apart."""
        publisher.publish(TableState(balls=list(balls)))
        return spin_until(node, lambda: words in str(ask(request)))

    cue = BallState(id='cue', position=Point(x=0.4, y=0.1))
    other = BallState(id='8')
    assert answer_comes('velocities=[0.', other, cue)
    np.testing.assert_allclose(
        conversions.vectors(ask(request).trajectory.positions)[0], (0.4, 0.1, RADIUS)
    )
    assert answer_comes('must be on the table', BallState(id='cue', state=BallState.POCKETED))
    unseen = BallState(id='8', state=BallState.UNKNOWN)
    assert answer_comes("ball '8' is not seen", cue, unseen)
    assert answer_comes("ball '8' moves", cue, BallState(id='8', moving=True))
    assert answer_comes("'8' occurs twice", cue, other, other)
    assert answer_comes('must be at least', cue, BallState(id='8', position=Point(x=0.41, y=0.1)))
    node.destroy_publisher(publisher)


def test_other_balls_of_the_table_state_are_met(ask, node):
    """A ball in the way of the cue ball stops it; without the table state it rolls on."""
    request = request_for('horizontal')
    far = conversions.vectors(ask(request).trajectory.positions)[-1]
    way = far[:2] / np.hypot(*far[:2])
    publisher = node.create_publisher(TableState, 'table_state', LATCHED)
    publisher.publish(
        TableState(
            balls=[
                BallState(id='cue'),
                BallState(id='8', position=Point(x=float(0.2 * way[0]), y=float(0.2 * way[1]))),
            ]
        )
    )
    request.use_table_state = True

    def stopped():
        positions = conversions.vectors(ask(request).trajectory.positions)
        return len(positions) and np.hypot(*positions[-1][:2]) < 0.5 * np.hypot(*far[:2])

    assert spin_until(node, stopped)
    assert [effect.simulated for effect in ask(request).effects if effect.name == 'ball_ball'] == [
        True
    ]
    node.destroy_publisher(publisher)


def test_all_balls_on_request(ask, node):
    """The ball that is met moves, and its trajectory is the library's."""
    scene = replace(SCENE, balls={'cue': (0.0, 0.0), '8': (0.3, 0.0), '9': (0.0, 1.0)})
    publisher = node.create_publisher(TableState, 'table_state', LATCHED)
    publisher.publish(
        TableState(
            balls=[
                BallState(id=name, position=Point(x=x, y=y))
                for name, (x, y) in scene.balls.items()
            ]
        )
    )
    stroke = Stroke.from_offsets(b=0.1, speed=1.0)
    request = request_of(stroke, SCENE)
    request.use_table_state = True
    request.all_balls = True
    assert spin_until(node, lambda: len(ask(request).other_balls) == 1)
    (other,) = ask(request).other_balls
    assert other.id == '8'
    request.all_balls = False
    assert not ask(request).other_balls
    np.testing.assert_allclose(
        conversions.vectors(other.positions)[-1],
        predict(scene, stroke).run.balls['8'].final_position,
        atol=2e-4,
    )
    node.destroy_publisher(publisher)


def test_many_strokes_at_once(node, ask):
    client = PatientCaller(node, PredictShots, 'predict_shots')
    assert client.wait_for_service()
    singles = [request_for(name) for name in PAPER_SHOTS]
    wrong, aside = request_for('jump'), request_for('horizontal')
    wrong.speed = math.nan
    aside.cue_pose.position.y += 0.1
    singles += [wrong, aside]
    answer = client.call(
        PredictShots.Request(
            cue_poses=[each.cue_pose for each in singles], speeds=[each.speed for each in singles]
        ),
        repeatable=True,
    )
    assert answer.status == Status.OK, answer.message
    assert answer.balls == ['cue']
    alone = [ask(each) for each in singles]
    assert list(answer.statuses) == [each.status for each in alone]
    assert list(answer.statuses[-2:]) == [Status.INVALID_STROKE, Status.MISS]
    velocities, spins, ends = (
        conversions.vectors(each)
        for each in (answer.velocities, answer.spins, answer.final_positions)
    )
    assert len(velocities) == len(ends) == len(answer.final_motions) == len(singles)
    for i, each in enumerate(alone):
        np.testing.assert_allclose(velocities[i], components(each.velocity), atol=1e-9)
        np.testing.assert_allclose(spins[i], components(each.spin), atol=1e-9)
        if not Status(each.status).refused:
            np.testing.assert_allclose(
                ends[i], conversions.vectors(each.trajectory.positions)[-1], atol=1e-9
            )
            assert answer.final_motions[i] == BallTrajectory.REST


def test_a_burst_of_requests_is_answered(node, ask):
    """1,000 requests of a client with the documented QoS, which the server has discovered."""
    client = node.create_client(PredictShot, 'predict_shot', qos_profile=BURST)
    assert client.wait_for_service(PATIENCE)
    request = request_for('horizontal')

    def is_discovered():
        future = client.call_async(request)
        return spin_until(node, future.done, 2.0)

    assert spin_until(node, is_discovered)
    futures = [client.call_async(request) for _ in range(1000)]
    assert spin_until(node, lambda: all(future.done() for future in futures))
    assert {future.result().status for future in futures} == {Status.OK}
    node.destroy_client(client)


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'speeds': [1.0]}, 'speeds must have 0 elements'),
        ({'tolerance': -1.0}, 'tolerance must be finite'),
        ({'ball_position': Point(z=1.0)}, 'ball_position.z must be 0'),
    ],
)
def test_a_request_for_many_strokes_is_refused_by_name(node, ask, changes, words):
    client = PatientCaller(node, PredictShots, 'predict_shots')
    answer = client.call(PredictShots.Request(**changes), repeatable=True)
    assert answer.status == Status.INVALID_REQUEST
    assert words in answer.message


@pytest.mark.parametrize(
    ('name', 'kind'), [('predict', PredictShot), ('predict_batch', PredictShots)]
)
def test_an_unexpected_error_is_answered(domain, node, monkeypatch, name, kind):
    """Else the node would end, or a thread would leave no answer."""

    def broken(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr(predictor_node, name, broken)
    server, executor = predictor_node.Predictor(), SingleThreadedExecutor()
    executor.add_node(server)
    server.executor = executor
    work = server._predict_shot if kind is PredictShot else server._predict_shots
    request = request_for('horizontal') if kind is PredictShot else kind.Request()
    answer = executor.create_task(work, request, kind.Response())
    executor.spin_until_future_complete(answer, PATIENCE)
    assert answer.result().status == Status.INVALID_REQUEST
    assert 'ZeroDivisionError' in answer.result().message
    executor.shutdown()
    server.destroy_node()


def test_a_shot_into_other_balls_does_not_keep_the_node_from_answering(node, monkeypatch):
    """A rack whose balls touch takes seconds: another thread predicts it."""
    threads = []

    def spied(*_, **__):
        threads.append(threading.current_thread())
        raise ValueError('enough')

    monkeypatch.setattr(predictor_node, 'predict', spied)
    table = TableState(balls=[BallState(id='cue')])
    for count in (1, 2):
        executor = SingleThreadedExecutor()
        fake = SimpleNamespace(
            executor=executor, _own=PredictorParameters(), _scene=SCENE, _table=table
        )
        request = request_for('horizontal')
        request.use_table_state = True
        answer = executor.create_task(
            Predictor._predict_shot, fake, request, PredictShot.Response()
        )
        executor.spin_until_future_complete(answer, PATIENCE)
        assert (answer.result().message, len(threads)) == ('enough', count)
        executor.shutdown()
        table.balls.append(BallState(id='8', position=Point(x=0.5)))
    assert [each is threading.main_thread() for each in threads] == [True, False]


def test_path_and_markers_come_after_the_answer(start, node):
    start('-r', '__ns:=/display')
    client = PatientCaller(node, PredictShot, '/display/predict_shot')
    assert client.wait_for_service()
    arrived = []
    for kind, topic in ((Path, 'path'), (MarkerArray, 'markers'), (String, 'shot')):
        node.create_subscription(
            kind,
            f'/display/predictor/{topic}',
            lambda message, info, topic=topic: arrived.append(
                (topic, message, info['source_timestamp'])
            ),
            LATCHED,
        )
    refused = request_for('massé')
    refused.speed = 0.0
    assert client.call(refused, repeatable=True).status == Status.INVALID_STROKE
    assert not spin_until(node, lambda: arrived, seconds=0.5), 'nothing to show yet'

    answer, answered = answer_and_when(client.client, request_for('massé'))
    assert spin_until(node, lambda: len(arrived) == 3)
    assert all(sent > answered for _, _, sent in arrived)
    messages = {topic: message for topic, message, _ in arrived}
    path, shot = messages['path'], from_json(messages['shot'].data)
    trajectory = conversions.trajectory_message(shot.trajectory, 200)
    assert len(answer.trajectory.times) < 10, 'the path does not follow the answer'
    assert path.header.frame_id == 'table'
    np.testing.assert_array_equal(
        [components(pose.pose.position) for pose in path.poses],
        conversions.vectors(trajectory.positions),
    )
    stamps = [pose.header.stamp.sec + pose.header.stamp.nanosec * 1e-9 for pose in path.poses]
    np.testing.assert_allclose(np.diff(stamps), np.diff(trajectory.times), atol=1e-5)
    assert {marker.ns for marker in messages['markers'].markers} > {'cue', 'paths'}
    assert shot.scene == SCENE
    assert components(answer.velocity) == shot.velocity.tolist()
    again = predict(shot.scene, shot.stroke, shot.tolerance, shot.trajectory.at(0.0).position)
    np.testing.assert_array_equal(again.trajectory.rows, shot.trajectory.rows)

    late = []
    node.create_subscription(Path, '/display/predictor/path', late.append, LATCHED)
    assert spin_until(node, lambda: late), 'latched: who comes later sees it too'

    assert client.call(refused, repeatable=True).status == Status.INVALID_STROKE
    assert not spin_until(node, lambda: len(arrived) > 3, seconds=0.5), 'a refusal shows nothing'


def test_many_calls_leave_nothing_behind(ask, predictor):
    def resident():
        with open(f'/proc/{predictor.pid}/status') as status:
            return next(int(line.split()[1]) for line in status if line.startswith('VmRSS'))

    request = request_for('horizontal')
    for _ in range(200):
        ask(request)
    before = resident()
    for _ in range(400):
        assert not Status(ask(request).status).refused
    assert resident() - before < 2_000, 'kB'

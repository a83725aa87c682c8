"""What RViz and Foxglove get to see: the sizes of the scene, over the real middleware."""

import json
from pathlib import Path
import re
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallState, CueState, TableState
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from paper import PAPER_SHOTS
from std_msgs.msg import Bool, Header
from visualization_msgs.msg import Marker, MarkerArray
from waiting import PatientCaller, spin_until
import yaml

from billiard_shot import Motion, predict, Scene, Stroke
from billiard_shot.pictures.canvas import ball_colour, MOTIONS
from billiard_shot.ros import table_display
from billiard_shot.ros.node_runner import LATCHED

ROOT = Path(__file__).resolve().parents[2]
NOW = Header(frame_id='table', stamp=Time(sec=3))
TABLE = Scene.load('pool_table')
NINE = Scene.load('nine_ball')
COMBINATION = Scene.load('frozen_combination')


def named(array, namespace):
    return [marker for marker in array.markers if marker.ns == namespace]


def corners(marker):
    return np.array([[point.x, point.y, point.z] for point in marker.points])


def centre(marker):
    position = marker.pose.position
    return np.array([position.x, position.y, position.z])


def size(marker):
    return np.array([marker.scale.x, marker.scale.y, marker.scale.z])


def drawn(array):
    """Check what every array must be, and return what is drawn."""
    first, *rest = array.markers
    assert first.action == Marker.DELETEALL, 'what was there before goes'
    assert {marker.header.frame_id for marker in array.markers} == {'table'}
    names = [(marker.ns, marker.id) for marker in rest]
    assert len(set(names)) == len(names), 'or one would replace the other'
    for marker in rest:
        assert marker.color.a > 0.0
        assert marker.pose.orientation.w == 1.0
        assert len(marker.colors) in (0, len(marker.points))
        assert np.isfinite(corners(marker)).all()
        if marker.type == Marker.TRIANGLE_LIST:
            assert len(marker.points) % 3 == 0
    return rest


def check_table(array, scene):
    drawn(array)
    nose, depth = scene.ball.radius * 2 * scene.table.cushion.height, scene.table.cushion.depth
    half = 0.5 * np.array([scene.table.length, scene.table.width])
    (bed,) = named(array, 'bed')
    np.testing.assert_allclose(size(bed)[:2], 2 * (half + depth))
    assert centre(bed)[2] + size(bed)[2] / 2 == pytest.approx(0.0), 'the cloth is at z = 0'
    (cushions,) = named(array, 'cushions')
    points = corners(cushions)
    for axis in 0, 1:
        assert np.abs(points[:, axis]).max() == pytest.approx(half[axis] + depth)
    inside = (np.abs(points[:, :2]) < half - 1e-9).all(axis=1)
    assert not inside.any(), 'no cushion reaches over the bed'
    np.testing.assert_allclose(np.unique(points[:, 2].round(12)), (0.0, nose), atol=1e-12)
    pockets = named(array, 'pockets')
    assert len(pockets) == (6 if scene.table.pockets else 0)
    for pocket in pockets:
        kind = scene.table.side if centre(pocket)[0] == 0.0 else scene.table.corner
        assert size(pocket)[0] == size(pocket)[1] == 2 * kind.radius


@pytest.mark.parametrize('name', ['pool_table', 'snooker', 'carom'])
def test_furniture_has_the_sizes_of_the_scene(name):
    check_table(table_display.table_markers(Scene.load(name), NOW), Scene.load(name))


def test_cloth_without_end_is_a_cloth():
    (bed,) = drawn(table_display.table_markers(Scene.load('pool'), NOW))
    assert bed.ns == 'bed'


def test_balls_lie_where_they_do_in_their_colours():
    state = TableState(
        balls=[
            BallState(id='cue', position=Point(x=0.1, y=0.2)),
            BallState(id='3', position=Point(x=-0.4, y=0.0, z=0.2)),
            BallState(id='8', state=BallState.POCKETED),
        ]
    )
    array = table_display.ball_markers(table_display.ball_centres(state, 0.028), 0.028, NOW)
    drawn(array)
    balls = named(array, 'balls')
    np.testing.assert_allclose(
        [centre(ball) for ball in balls], [(0.1, 0.2, 0.028), (-0.4, 0.0, 0.2)]
    )
    assert [label.text for label in named(array, 'labels')] == ['cue', '3']
    for ball, name in zip(balls, ('cue', '3'), strict=True):
        np.testing.assert_allclose(size(ball), 0.056)
        assert ball.color == table_display.colour(ball_colour(name))


def test_a_shot_shows_the_cue_and_every_ball_that_moves():
    there = np.subtract(COMBINATION.balls['1'], COMBINATION.cue_ball[:2])
    stroke = Stroke.from_offsets(
        a=0.1, b=0.2, elevation=0.1, azimuth=np.arctan2(there[1], there[0]), speed=2.0
    )
    shot = predict(COMBINATION, stroke)
    array = table_display.shot_markers(shot, NOW)
    drawn(array)
    moving = {name: each for name, each in shot.run.balls.items() if each.duration > 0.0}
    assert len(moving) > 1
    paths = named(array, 'paths')
    assert len(paths) == len(named(array, 'starts')) == len(moving)
    assert len(named(array, 'ends')) == len(set(moving) - set(shot.run.pocketed))
    for path, trajectory in zip(paths, moving.values(), strict=True):
        points = corners(path)
        np.testing.assert_allclose(points[0], trajectory.at(0.0).position)
        np.testing.assert_allclose(points[-1], trajectory.final_position)
        seen = {(each.r, each.g, each.b) for each in path.colors}
        assert len(seen) == len(
            {
                segment.motion
                for segment in trajectory.segments
                if segment.motion is not Motion.REST  # until it is hit, or in the end
                and segment.start < trajectory.duration
            }
        )
    (cue,) = named(array, 'cue')
    ends = corners(cue)
    along = np.array(stroke.velocity) / stroke.speed
    length = COMBINATION.cue.length
    tip = np.array(COMBINATION.cue_ball) + COMBINATION.ball.radius * np.array(stroke.normal)
    np.testing.assert_allclose(np.ptp((ends - tip) @ along), length)
    aside = (ends - tip) - np.outer((ends - tip) @ along, along)
    assert np.linalg.norm(aside, axis=1).min() == pytest.approx(COMBINATION.cue.ferrule_radius)


def test_a_line_goes_where_the_ball_does():
    """Between two points of it the massé is no farther from its line than a millimetre."""
    shot = predict(Scene.load('paper'), PAPER_SHOTS['massé'])
    line = corners(named(table_display.shot_markers(shot, NOW), 'paths')[0])
    a, b = line[:-1], line[1:]
    for time in np.linspace(0.0, shot.trajectory.duration, 500):
        point = shot.trajectory.at(time).position
        t = ((point - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-30)
        nearest = a + np.clip(t, 0.0, 1.0)[:, np.newaxis] * (b - a)
        assert np.linalg.norm(nearest - point, axis=1).min() < 1e-3


def test_a_plan_shows_the_best_stroke_best():
    strokes = [
        Stroke.from_offsets(a=0.0, b=0.2, elevation=0.1, azimuth=azimuth, speed=2.0)
        for azimuth in (0.2, 0.21, 0.25)
    ]
    ranking = [
        SimpleNamespace(shot=predict(COMBINATION, stroke), kind='direct', chance=chance)
        for stroke, chance in zip(strokes, ('91 %', '80 %', '40 %'), strict=True)
    ]
    array = table_display.plan_markers(ranking, NOW)
    drawn(array)
    cues = named(array, 'cue')
    assert [cue.color.a for cue in cues] == pytest.approx([1.0, 0.3, 0.3])
    assert [label.text for label in named(array, 'labels')] == [
        'direct: 91 %',
        'direct: 80 %',
        'direct: 40 %',
    ]
    nothing = table_display.plan_markers([], NOW)
    assert drawn(nothing) == [], 'no plan: what was shown goes'


def test_every_motion_on_the_way_has_a_colour_of_its_own():
    ways = {
        motion
        for motion in Motion
        if motion not in (Motion.REST, Motion.POCKETED, Motion.OFF_TABLE, Motion.ABSENT)
    }
    assert set(MOTIONS) == ways
    assert len(set(MOTIONS.values())) == len(ways)


# --- over the middleware ------------------------------------------------------------------------


def arrives(node, topic, condition=bool):
    """Return the first message on a latched topic for which a condition is true."""
    fitting = []
    subscription = node.create_subscription(
        MarkerArray, topic, lambda message: condition(message) and fitting.append(message), LATCHED
    )
    arrived = spin_until(node, lambda: fitting)
    node.destroy_subscription(subscription)
    assert arrived, f'{topic}: nothing like that came'
    return fitting[0]


def test_latched_markers_have_the_sizes_of_the_scene(launch, node):
    launch('table_display', '-p', 'scene:=nine_ball', '-r', '__ns:=/shown')
    check_table(arrives(node, '/shown/table_display/table'), NINE)
    balls = named(arrives(node, '/shown/table_display/balls'), 'balls')
    assert len(balls) == 10
    np.testing.assert_allclose(
        sorted(centre(ball)[0] for ball in balls), sorted(x for x, _ in NINE.balls.values())
    )

    publisher = node.create_publisher(TableState, '/shown/table_state', LATCHED)
    publisher.publish(TableState(balls=[BallState(id='9', position=Point(x=0.25))]))
    moved = arrives(
        node, '/shown/table_display/balls', lambda message: len(named(message, 'balls')) == 1
    )
    assert centre(named(moved, 'balls')[0])[0] == 0.25
    node.destroy_publisher(publisher)


def test_another_scene_is_shown_once_it_is_set(launch, node):
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    launch('table_display', '-r', '__ns:=/other')
    client = PatientCaller(node, SetParameters, '/other/table_display/set_parameters')
    assert client.wait_for_service()

    def answer(scene):
        setting = Parameter('scene', value=scene).to_parameter_msg()
        request = SetParameters.Request(parameters=[setting])
        return client.call(request, repeatable=True).results[0]

    assert not answer('no_such_scene').successful
    assert answer('snooker').successful
    shown = arrives(node, '/other/table_display/table', lambda message: named(message, 'pockets'))
    check_table(shown, Scene.load('snooker'))


def test_rviz_listens_to_what_the_nodes_publish():
    """rviz/shot.rviz: classes that RViz has, topics as latched as their publishers."""
    config = yaml.safe_load((ROOT / 'rviz' / 'shot.rviz').read_text())['Visualization Manager']
    assert config['Global Options']['Fixed Frame'] == 'table'
    shown = {each['Topic']['Value']: each for each in config['Displays'] if 'Topic' in each}
    assert shown.pop('table_camera/outlines')['Class'] == 'rviz_default_plugins/Image'
    for each in shown.values():
        assert each['Topic']['Durability Policy'] == 'Transient Local'
        assert each['Topic']['Reliability Policy'] == 'Reliable'
    assert published() == set(shown)


def published():
    """Topics of markers and paths that the nodes publish, without their namespace."""
    nodes = (ROOT / 'billiard_shot' / 'ros').glob('*.py')
    return {
        f'{file.stem}/{topic}'
        for file in nodes
        for topic in re.findall(
            r"create_publisher\((?:MarkerArray|Path), '~/(\w+)', LATCHED\)", file.read_text()
        )
    }


def test_foxglove_shows_what_the_nodes_publish():
    """config/foxglove.json: panels that Foxglove has, each placed once, with topics that exist."""
    layout = json.loads((ROOT / 'config' / 'foxglove.json').read_text())
    panels = layout['configById']

    def placed(part):
        if isinstance(part, str):
            return [part]
        assert part['direction'] in ('row', 'column')
        assert 0 < part['splitPercentage'] < 100
        return placed(part['first']) + placed(part['second'])

    assert sorted(placed(layout['layout'])) == sorted(panels)
    kinds = {name.partition('!')[0]: panel for name, panel in panels.items()}
    assert set(kinds) == {'3D', 'StateTransitions', 'DiagnosticSummary', 'RosOut'}
    assert kinds['3D']['followTf'] == 'table'
    shown = {topic.removeprefix('/') for topic in kinds['3D']['topics']}
    assert shown == published() | {'robot_description'}
    sources = {'/cue_driver/state': CueState, '/estop': Bool, '/interlock': Bool}
    for path in kinds['StateTransitions']['paths']:
        topic, _, field = path['value'].partition('.')
        assert field in sources.pop(topic).get_fields_and_field_types()
    assert not sources
    assert kinds['DiagnosticSummary']['topicToRender'] == '/diagnostics'
    assert kinds['RosOut']['topicToRender'] == '/rosout'

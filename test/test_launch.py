"""The launch file starts what is there, with files that are there (ROS need not be)."""

from pathlib import Path
import re
import signal
import subprocess
import sys

import pytest
from recorded_launch import actions, FILE, ROOT, started, text
import yaml

from billiard_shot import Scene

PROGRAMS = {'player', 'predict_shot', 'robot', 'shot_recorder'}  # that people start
TRUTH = ('false', 'true')
OTHERS = {'rviz2', 'ros2_control_node', 'spawner'}
pytestmark = pytest.mark.skipif(not FILE.exists(), reason='needs a source checkout')


def nodes_of(setup):
    return set(re.findall(r'^            .(\w+) = billiard_shot\.ros', setup, re.MULTILINE))


def test_arguments_are_declared_and_described(launch_file):
    declared = {
        each.args[0]: each.fields
        for each in launch_file.generate_launch_description()
        if each.kind == 'DeclareLaunchArgument'
    }
    assert set(declared) == set(launch_file.ARGUMENTS)
    assert all(each['description'] for each in declared.values())


@pytest.mark.parametrize('page', ['README.md', 'docs/ros.md', 'docs/cue.md', 'docs/tutorial.md'])
def test_pages_use_arguments_that_are_there(launch_file, page):
    text = re.sub('--ros-args .*', '', (ROOT / page).read_text())
    assert set(re.findall(r'(?<![\w-])(\w+):=', text)) <= set(launch_file.ARGUMENTS)


def test_nodes_and_their_files_are_there(launch_file):
    nodes = started(launch_file, scene='paper', simulate='true', pictures='true', rviz='true')
    own = {name: node for name, node in nodes.items() if node.package == 'billiard_shot'}
    for name, node in own.items():
        file = yaml.safe_load(Path(node.files[0]).read_text())['/**']['ros__parameters']
        assert Path(node.files[0]).name == f'{name}.yaml'
        assert all(Path(each).is_file() for each in node.files)
        assert node.settings['scene'] == 'paper'
        allowed = {'scene', 'mechanism', 'frame', 'use_sim_time'}
        assert set(node.settings) - set(file) <= allowed
    executables = nodes_of((ROOT / 'setup.py').read_text())
    assert set(own) <= executables
    assert executables - set(own) <= PROGRAMS


@pytest.mark.parametrize('namespace', ['', 'cell1'])
def test_each_namespace_keeps_the_state_of_its_driver(launch_file, monkeypatch, namespace):
    monkeypatch.setenv('ROS_HOME', '/ros')
    kept = f'/ros/billiard_shot/{namespace}/cue_driver.state'
    for simulate, wanted in (('true', ''), ('false', kept)):
        nodes = started(launch_file, simulate=simulate, namespace=namespace)
        assert nodes['cue_driver'].settings['state_file'] == wanted


def test_nodes_use_the_profile_of_the_package_or_that_of_the_user(launch_file, monkeypatch):
    name = 'FASTDDS_DEFAULT_PROFILES_FILE'
    for own, wanted in ((None, str(ROOT / 'config' / 'fastdds.xml')), ('mine.xml', 'mine.xml')):
        monkeypatch.setenv(name, own) if own else monkeypatch.delenv(name, raising=False)
        listed, context = actions(launch_file, {})
        (variable,) = [each for each in listed if each.kind == 'SetEnvironmentVariable']
        assert [text(each, context) for each in variable.args] == [name, wanted]


@pytest.mark.parametrize(
    ('arguments', 'missing'),
    [
        ({}, {'cue_sim', 'table_sim', *OTHERS}),
        (
            {'cue': 'false', 'simulate': 'true', 'rviz': 'True'},
            {'cue_driver', 'ros2_control_node', 'spawner'},
        ),
        ({'cue': 'false'}, {'cue_driver', 'cue_sim', 'table_sim', 'cue_model', *OTHERS}),
        ({'model': 'false', 'simulate': '1'}, {'cue_model', *OTHERS}),
        ({'control': 'true', 'simulate': 'true'}, {'cue_sim', 'rviz2'}),
        ({'interface': 'follow_joint_trajectory', 'simulate': 'true'}, {'cue_sim', *OTHERS}),
    ],
)
def test_nodes_are_left_out(launch_file, arguments, missing):
    everything = {
        *started(launch_file, simulate='true', rviz='true'),
        *started(launch_file, control='true'),
    }
    assert everything - set(started(launch_file, **arguments)) == missing


def test_every_node_gets_what_the_arguments_say(launch_file):
    given = {'frame': 'cell1/table', 'mechanism': 'mine.yaml', 'scene': 'paper'}
    nodes = started(
        launch_file,
        simulate='true',
        rviz='true',
        namespace='cell1',
        use_sim_time='true',
        log_level='debug',
        **given,
    )
    for node in nodes.values():
        assert node.namespace == 'cell1'
        assert node.settings['use_sim_time'] is True
        assert node.arguments[-3:] == ['--ros-args', '--log-level', 'debug']
        if node.package == 'billiard_shot':
            assert given.items() <= node.settings.items()
    assert nodes['rviz2'].arguments[:4] == ['-d', f'{ROOT}/rviz/shot.rviz', '-f', 'cell1/table']


def test_a_camera_is_tracked(launch_file):
    """A simulated table publishes either table_state or the detections that it is made from."""
    without, tracked = (started(launch_file, simulate='true', camera=each) for each in TRUTH)
    assert 'table_tracker' not in without
    assert not without['table_sim'].settings['camera']
    assert 'table_tracker' in tracked
    assert tracked['table_sim'].settings['camera']
    seen = started(launch_file, simulate='true', camera='true', pictures='true')
    assert {'table_camera', 'table_tracker'} <= seen.keys()
    assert not seen['table_sim'].settings['camera']
    assert seen['table_sim'].remappings == {'table_state': 'simulated_table'}
    assert tracked['table_sim'].remappings == {'table_state': 'table_state'}


def test_a_player_serves_turns(launch_file):
    player = started(launch_file, player='true', scene='paper')['player']
    assert player.arguments[:3] == ['--serve', '--scene', 'paper']
    assert player.respawn


def test_shots_are_recorded_if_a_file_is_named(launch_file):
    assert 'shot_recorder' not in started(launch_file)
    recorder = started(launch_file, record='/tmp/shots.csv', scene='paper')['shot_recorder']
    assert recorder.settings['file'] == '/tmp/shots.csv'
    assert recorder.settings['scene'] == 'paper'


def test_the_launch_without_arguments_has_one_scene_with_a_guided_cue(launch_file):
    (scene,) = {node.settings['scene'] for node in started(launch_file).values()}
    assert Scene.load(scene).cue.guided


def test_the_driver_is_a_lifecycle_node_that_the_launch_starts(launch_file):
    for autostart in (True, False):
        driver = started(launch_file, autostart=str(autostart))['cue_driver']
        assert driver.kind == 'LifecycleNode'
        assert driver.settings['autostart'] is autostart


def test_a_controller_is_commanded_and_started(launch_file):
    assert started(launch_file)['cue_driver'].settings['interface'] == 'topic'
    others = started(launch_file, interface='follow_joint_trajectory')
    assert others['cue_driver'].settings['interface'] == 'follow_joint_trajectory'
    nodes = started(launch_file, control='true')
    assert nodes['cue_driver'].settings['interface'] == 'follow_joint_trajectory'
    (file,) = nodes['ros2_control_node'].files
    controllers = yaml.safe_load(Path(file).read_text())['/**/controller_manager']
    spawned = nodes['spawner'].arguments[:2]
    assert set(spawned) == set(controllers['ros__parameters']) - {'update_rate'}


def test_topics_of_the_view_are_relative_and_published(launch_file):
    """A topic that begins with / would not follow RViz into a namespace."""
    topics = re.findall(
        r'^\s+Value: (\S+/\S+|robot_description)$',
        (ROOT / 'rviz' / 'shot.rviz').read_text(),
        re.MULTILINE,
    )
    assert len(topics) > 5
    for topic in topics:
        assert not topic.startswith('/')
        nodes = started(launch_file, pictures='true')
        assert topic.partition('/')[0] in (*nodes, 'robot_description')


def test_a_node_that_ends_is_started_again(launch_file):
    """A window that a person closes stays closed, and controllers are loaded once."""
    nodes = {
        **started(launch_file, simulate='true', rviz='true'),
        **started(launch_file, control='true'),
    }
    assert {name for name, node in nodes.items() if not node.respawn} == {'rviz2', 'spawner'}


@pytest.mark.parametrize('scene', ['pool_table', 'snooker'])
def test_any_scene_without_the_mechanical_cue(launch_file, scene):
    assert 'cue_driver' not in started(launch_file, scene=scene, cue='false')


def test_nodes_end_even_if_the_launch_is_killed(launch_file):
    """A launch that is killed cannot stop its nodes; the kernel does."""
    if not launch_file.END_WITH_LAUNCH:
        pytest.skip('needs setpriv')
    command = [
        *launch_file.END_WITH_LAUNCH.split(),
        sys.executable,
        '-c',
        'import os, time; print(os.getpid(), flush=True); time.sleep(600)',
    ]
    starter = f'import subprocess, time; subprocess.Popen({command}); time.sleep(600)'
    with subprocess.Popen([sys.executable, '-c', starter], stdout=subprocess.PIPE) as launch:
        assert int(launch.stdout.readline()) != launch.pid
        launch.send_signal(signal.SIGKILL)
        # The node holds the other end of the pipe: it ends with the node.
        assert launch.stdout.read() == b''


@pytest.mark.parametrize('rviz', ['true', 'false'])
def test_every_process_ends_with_the_launch(launch_file, rviz):
    for name, node in started(launch_file, simulate='true', rviz=rviz).items():
        assert node.prefix == launch_file.END_WITH_LAUNCH
        assert node.name == name  # else all processes would have the name of the prefix


def test_a_simulation_is_patient_and_a_real_mechanism_is_not(launch_file):
    def has_long_time_outs(node):
        return any(each.endswith('simulation.yaml') for each in node.files)

    simulated = started(launch_file, simulate='true')
    assert all(has_long_time_outs(simulated[name]) for name in ('cue_driver', 'cue_sim'))
    assert not any(has_long_time_outs(node) for node in started(launch_file).values())

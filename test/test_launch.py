"""The launch file starts what is there, with files that are there (ROS need not be)."""

from pathlib import Path
import re
import signal
import subprocess
import sys

import pytest
from recorded_launch import DEFAULTS, FILE, ROOT, RSP, settings_of, started
import yaml

from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.urdf import urdf_of

PROGRAMS = {'player', 'predict_shot', 'robot', 'table_tracker'}  # that people start
pytestmark = pytest.mark.skipif(not FILE.exists(), reason='needs a source checkout')


def test_arguments_are_declared_and_described(launch_file):
    declared = {
        each.args[0]: each for each in launch_file.generate_launch_description() if each.args
    }
    assert {name: each.default_value for name, each in declared.items()} == {
        **DEFAULTS,
        'params_dir': 'share/billiard_shot/config',
    }
    for name, each in declared.items():
        assert each.description
        assert f'`{name}`: ' in launch_file.__doc__
        assert f'| `{name}` | ' in (ROOT / 'docs' / 'ros.md').read_text()


def test_nodes_and_their_files_are_there(launch_file, installed):
    scripts = (ROOT / 'setup.py').read_text()
    installed.remove(RSP)
    nodes = started(launch_file, scene='paper', simulate='true', rviz='true')
    own = {name: node for name, node in nodes.items() if node.package == 'billiard_shot'}
    for name, node in own.items():
        file = yaml.safe_load(Path(node.parameters[0]).read_text())['/**']['ros__parameters']
        assert Path(node.parameters[0]).name == f'{name}.yaml'
        assert settings_of(node)['scene'] == 'paper'
        assert set(settings_of(node)) - set(file) <= {'scene', 'use_sim_time'}
    executables = re.findall(r'^            .(\w+) = billiard_shot\.ros', scripts, re.MULTILINE)
    assert set(own) == set(executables) - PROGRAMS


@pytest.mark.parametrize(
    ('arguments', 'missing'),
    [
        ({}, {'cue_sim', 'table_sim', 'rviz2'}),
        ({'cue': 'false', 'simulate': 'true', 'rviz': 'True'}, {'cue_driver', RSP}),
        ({'model': 'false', 'simulate': 'true', 'rviz': '1'}, {RSP}),
    ],
)
def test_nodes_are_left_out(launch_file, arguments, missing):
    everything = set(started(launch_file, simulate='true', rviz='true'))
    assert everything - set(started(launch_file, **arguments)) == missing


def test_every_node_gets_what_the_arguments_say(launch_file, tmp_path):
    mechanism = tmp_path / 'mine.yaml'
    mechanism.write_text('reach: 0.25\n')
    nodes = started(
        launch_file,
        simulate='true',
        rviz='true',
        namespace='cell1',
        use_sim_time='true',
        log_level='debug',
        frame='cell1/table',
        mechanism=str(mechanism),
    )
    for node in nodes.values():
        assert node.namespace == 'cell1'
        assert settings_of(node)['use_sim_time'] is True
        assert node.arguments[-3:] == ['--ros-args', '--log-level', 'debug']
        if node.package == 'billiard_shot':
            assert settings_of(node)['frame'] == 'cell1/table'
            assert settings_of(node)['mechanism'] == str(mechanism)
    assert nodes['rviz2'].arguments[:4] == [
        '-d',
        'share/billiard_shot/rviz/shot.rviz',
        '-f',
        'cell1/table',
    ]


def test_without_arguments_the_files_decide(launch_file, tmp_path):
    for node in started(launch_file).values():
        assert set(settings_of(node)) <= {'use_sim_time', 'autostart', 'robot_description'}
        assert (node.namespace, node.arguments) == (None, [])
    for file in (ROOT / 'config').glob('*.yaml'):
        text = file.read_text().replace('frame: table', 'frame: cell2/table')
        (tmp_path / file.name).write_text(text)
    rviz = started(launch_file, rviz='true', params_dir=str(tmp_path))['rviz2']
    assert rviz.arguments[-2:] == ['-f', 'cell2/table']


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
        assert topic.partition('/')[0] in (*started(launch_file), 'robot_description')


def test_each_of_our_nodes_is_required(launch_file):
    nodes = started(launch_file, simulate='true', rviz='true')
    for name, node in nodes.items():
        ends_the_launch = getattr(getattr(node, 'on_exit', None), 'kind', '') == 'Shutdown'
        assert ends_the_launch == (name != 'rviz2'), name


def test_without_rviz_everything_else_starts(launch_file, installed):
    with_rviz = set(started(launch_file, simulate='true', rviz='true'))
    installed.remove('rviz2')
    actions = launch_file.nodes({**DEFAULTS, 'simulate': 'true', 'rviz': 'true'})
    (warning,) = (action.msg for action in actions if action.kind == 'LogInfo')
    assert warning.startswith('WARNING: RViz is not started: ')
    assert "package 'rviz2' not found" in warning
    assert {each.executable for each in actions if each.kind == 'Node'} == with_rviz - {'rviz2'}


def test_the_robot_model_has_one_publisher(launch_file, installed):
    """Two publishers of the same frame would contradict each other."""

    def publishers(**arguments):
        return {'cue_model', RSP} & set(started(launch_file, **arguments))

    assert publishers() == publishers(simulate='true') == {RSP}
    # It would never hear of the elevation, which cue_driver publishes.
    assert publishers(cue='false', simulate='true') == {'cue_model'}
    assert publishers(cue='false') == publishers(model='false') == set()
    installed.remove(RSP)
    assert publishers() == {'cue_model'}
    (warning,) = (each.msg for each in launch_file.nodes(DEFAULTS) if each.kind == 'LogInfo')
    assert 'replaces robot_state_publisher: "package \'robot_state' in warning


def test_the_robot_model_is_that_of_the_parameters(launch_file, tmp_path):
    def description(**arguments):
        return settings_of(started(launch_file, **arguments)[RSP])['robot_description']

    (tmp_path / 'mine.yaml').write_text('reach: 0.25\n')
    assert description() == urdf_of(Mechanism())
    assert description(mechanism=str(tmp_path / 'mine.yaml'), frame='cell1/table') == urdf_of(
        Mechanism(reach=0.25), 'cell1/table'
    )
    for file in (ROOT / 'config').glob('*.yaml'):
        (tmp_path / file.name).write_text(
            file.read_text()
            .replace("mechanism: ''", f'mechanism: {tmp_path / "mine.yaml"}')
            .replace('joint_names: [base_x', 'joint_names: [slide')
            .replace('incline_joint: incline_angle', 'incline_joint: tilt')
        )
    assert description(params_dir=str(tmp_path)) == urdf_of(
        Mechanism(reach=0.25), names=('slide', *JOINTS[1:]), incline_joint='tilt'
    )


@pytest.mark.parametrize(
    ('arguments', 'error', 'message'),
    [
        (
            {'scene': 'pool_table'},
            RuntimeError,
            "scene: 'pool_table' is not allowed with the mech",
        ),
        ({'scene': 'pool_table', 'cue': 'false', 'simulate': 'true'}, RuntimeError, 'scene: '),
        ({'scene': 'ghost'}, ValueError, "no bundled scene 'ghost'"),
        (
            {'params_dir': '/nowhere'},
            RuntimeError,
            r'params_dir: /nowhere/\w+\.yaml does not exist',
        ),
        ({'simulate': 'perhaps'}, KeyError, 'perhaps'),
    ],
)
def test_what_cannot_be_started_fails_before_anything_is(launch_file, arguments, error, message):
    """An exception between two actions would leave the processes of the first one behind."""
    with pytest.raises(error, match=message):
        launch_file.nodes({**DEFAULTS, **arguments})


def test_a_missing_installation_fails_before_anything_is_started(launch_file, installed):
    installed.remove('billiard_shot')
    with pytest.raises(KeyError, match='billiard_shot'):
        launch_file.nodes(DEFAULTS)


@pytest.mark.parametrize('scene', ['pool_table', 'snooker'])
def test_any_scene_without_the_mechanical_cue(launch_file, scene):
    assert 'cue_driver' not in started(launch_file, scene=scene, cue='false')


def test_the_table_for_the_mechanical_cue(launch_file):
    nodes = started(launch_file, scene='robot_table', simulate='true')
    assert {'cue_driver', 'table_sim'} <= set(nodes)


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
        assert node.prefix[0] == launch_file.END_WITH_LAUNCH
        assert node.exec_name == name  # else all processes would have the name of the prefix


def test_a_simulation_is_patient_and_a_real_mechanism_is_not(launch_file):
    def has_long_time_outs(node):
        return any(str(each).endswith('simulation.yaml') for each in node.parameters)

    simulated = started(launch_file, simulate='true')
    assert all(has_long_time_outs(simulated[name]) for name in ('cue_driver', 'cue_sim'))
    assert not any(has_long_time_outs(node) for node in started(launch_file).values())

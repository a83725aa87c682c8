"""The launch file starts what is there, with files that are there (ROS need not be)."""
import importlib.util
from pathlib import Path
import re
import sys
from types import ModuleType, SimpleNamespace

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / 'launch' / 'shot.launch.py'
pytestmark = pytest.mark.skipif(not FILE.exists(), reason='needs a source checkout')
DEFAULTS = {'params_dir': 'PARAMS', 'scene': '', 'cue': 'true', 'simulate': 'false',
            'rviz': 'false', 'autostart': 'true'}


class Configuration(str):
    """A launch configuration; what it performs is in the context."""

    __slots__ = ()

    def perform(self, context):
        return context[self]


def joined(parts):
    return '/'.join(str(part) for part in parts)


@pytest.fixture
def launch_file(monkeypatch):
    """Return the launch file as a module, with recorders in place of the package launch."""
    def record(*args, **fields):
        return SimpleNamespace(args=args, **fields)

    modules = {
        'launch': {'LaunchDescription': list},
        'launch.actions': {
            'DeclareLaunchArgument': record,
            'OpaqueFunction': lambda function: SimpleNamespace(args=(), function=function)},
        'launch.conditions': {'IfCondition': str},
        'launch.substitutions': {
            'LaunchConfiguration': Configuration, 'PathJoinSubstitution': joined},
        'launch_ros': {},
        'launch_ros.actions': {'Node': record},
        'launch_ros.substitutions': {'FindPackageShare': lambda name: f'share/{name}'},
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location('shot_launch', FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_arguments_are_declared_and_described(launch_file):
    declared = {each.args[0]: each for each in launch_file.generate_launch_description()
                if each.args}
    assert {name: each.default_value for name, each in declared.items()} == {
        **DEFAULTS, 'params_dir': 'share/billiard_shot/config'}
    for name, each in declared.items():
        assert each.description
        assert f'`{name}`: ' in launch_file.__doc__
        assert f'| `{name}` | ' in (ROOT / 'docs' / 'ros.md').read_text()


def test_nodes_and_their_files_are_there(launch_file):
    scripts = (ROOT / 'setup.py').read_text()
    nodes = launch_file.nodes({**DEFAULTS, 'scene': 'paper'})
    own = [node for node in nodes if node.package == 'billiard_shot']
    for node in own:
        assert f"'{node.executable} = " in scripts
        file, *settings = node.parameters
        declared = yaml.safe_load(
            (ROOT / 'config' / Path(file).name).read_text())['/**']['ros__parameters']
        assert all(name in declared for each in settings for name in each)
        if 'scene' in declared:
            assert {'scene': 'paper'} in settings
    started = re.findall(r'^            .(\w+) = billiard_shot\.ros', scripts, re.MULTILINE)
    assert {node.executable for node in own} == set(started)
    assert {node.condition for node in nodes if hasattr(node, 'condition')} == {
        'cue', 'simulate', 'rviz'}
    rviz, = (node for node in nodes if node.package == 'rviz2')
    assert rviz.arguments == ['-d', 'share/billiard_shot/rviz/shot.rviz']


def test_without_a_scene_the_files_say_which(launch_file):
    for node in launch_file.nodes(DEFAULTS):
        assert not any('scene' in each for each in getattr(node, 'parameters', ())[1:])

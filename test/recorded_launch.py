"""
Recorders in place of the package launch, of which PyPI has no wheel.

`launch_file` is the launch file as a module; `started` gives the nodes that it would start.
"""

import importlib.util
from pathlib import Path
import sys
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / 'launch' / 'shot.launch.py'
DEFAULTS = {
    'scene': '',
    'mechanism': '',
    'frame': '',
    'params_dir': str(ROOT / 'config'),
    'namespace': '',
    'use_sim_time': 'false',
    'log_level': '',
    'cue': 'true',
    'simulate': 'false',
    'model': 'true',
    'rviz': 'false',
    'autostart': 'true',
}
RSP = 'robot_state_publisher'
INSTALLED = {'billiard_shot', 'rviz2', RSP}


class Configuration(str):
    """A launch configuration; what it performs is in the context."""

    __slots__ = ()

    def __new__(cls, name, default=None):
        return super().__new__(cls, name)

    def perform(self, context):
        return context[self]


class Condition:
    """A condition on a configuration, as strict as that of launch."""

    def __init__(self, configuration):
        self.configuration = configuration

    def evaluate(self, context):
        return {'true': True, '1': True, 'false': False, '0': False}[
            self.configuration.perform(context).lower()
        ]


class SubstitutionFailureError(Exception):
    """An executable that its package does not have."""


def share(name):
    return SimpleNamespace(perform=lambda context: f'share/{name}')


def joined(parts):
    return '/'.join(str(getattr(part, 'perform', lambda _, part=part: part)({})) for part in parts)


@pytest.fixture
def installed():
    """Packages that ROS finds."""
    return set(INSTALLED)


@pytest.fixture
def launch_file(monkeypatch, installed):
    """Return the launch file as a module, with recorders in place of the package launch."""

    def recorder(kind):
        return lambda *args, **fields: SimpleNamespace(kind=kind, args=args, **fields)

    def executable(package, executable):
        def perform(_):
            if package not in installed:
                raise KeyError(f"package '{package}' not found")
            if package == 'billiard_shot' and f"'{executable} = " not in scripts:
                raise SubstitutionFailureError(executable)

        return SimpleNamespace(perform=perform)

    scripts = (ROOT / 'setup.py').read_text()
    modules = {
        'launch': {'LaunchDescription': list},
        'launch.actions': {
            **{kind: recorder(kind) for kind in ('DeclareLaunchArgument', 'LogInfo', 'Shutdown')},
            'OpaqueFunction': lambda function: SimpleNamespace(args=(), function=function),
        },
        'launch.conditions': {'IfCondition': Condition},
        'launch.substitutions': {
            'LaunchConfiguration': Configuration,
            'PathJoinSubstitution': joined,
            'SubstitutionFailure': SubstitutionFailureError,
        },
        'launch_ros': {},
        'launch_ros.actions': {'Node': recorder('Node')},
        'launch_ros.parameter_descriptions': {
            'ParameterValue': lambda value, value_type: value_type(value)
        },
        'launch_ros.substitutions': {'ExecutableInPackage': executable, 'FindPackageShare': share},
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location('shot_launch', FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def started(launch_file, **arguments):
    """Nodes that the launch file starts with these arguments, by executable."""
    return {
        action.executable: action
        for action in launch_file.nodes({**DEFAULTS, **arguments})
        if action.kind == 'Node'
    }


def settings_of(node):
    """Parameters that the launch file sets beside those of the node's file."""
    return {
        name: value
        for each in node.parameters
        if isinstance(each, dict)
        for name, value in each.items()
    }

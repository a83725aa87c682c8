"""
Recorders in place of the package launch, of which PyPI has no wheel.

`launch_file` is the launch file as a module; `started` gives the nodes that it would start.
"""

import importlib.util
import os
from pathlib import Path
import sys
from types import ModuleType, SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / 'launch' / 'shot.launch.py'
SHARE = str(ROOT)  # of this package: the folders config and rviz have the same places
TRUTH = {'true': True, '1': True, 'false': False, '0': False}


class Substitution:
    """What is known when the launch runs: `perform(context)` gives the text."""

    def __init__(self, perform):
        self.perform = perform


def text(value, context):
    """Text of a string, a substitution, or a list of them."""
    if isinstance(value, (list, tuple)):
        return ''.join(text(each, context) for each in value)
    return value if isinstance(value, str) else value.perform(context)


def is_true(value, context):
    return TRUTH[text(value, context).lower()]


def said(value):
    return 'true' if value else 'false'


SUBSTITUTIONS = {
    'LaunchConfiguration': lambda name, default='': Substitution(
        lambda context: context.get(name, default)
    ),
    'PathJoinSubstitution': lambda parts: Substitution(
        lambda context: '/'.join(text(part, context) for part in parts)
    ),
    'EnvironmentVariable': lambda name, default_value: Substitution(
        lambda context: os.environ.get(name) or text(default_value, context)
    ),
    'IfElseSubstitution': lambda condition, yes, no: Substitution(
        lambda context: text(yes if is_true(condition, context) else no, context)
    ),
    'EqualsSubstitution': lambda one, two: Substitution(
        lambda context: said(text(one, context) == text(two, context))
    ),
    'NotSubstitution': lambda one: Substitution(lambda context: said(not is_true(one, context))),
    'AndSubstitution': lambda one, two: Substitution(
        lambda context: said(is_true(one, context) and is_true(two, context))
    ),
    'OrSubstitution': lambda one, two: Substitution(
        lambda context: said(is_true(one, context) or is_true(two, context))
    ),
}


class ParameterValue:
    def __init__(self, value, value_type):
        self.value, self.value_type = value, value_type

    def perform(self, context):
        found = text(self.value, context)
        return TRUTH[found.lower()] if self.value_type is bool else self.value_type(found)


def recorder(kind):
    return lambda *args, **fields: SimpleNamespace(kind=kind, args=args, fields=fields)


@pytest.fixture
def launch_file(monkeypatch):
    """Return the launch file as a module, with recorders in place of the package launch."""
    modules = {
        'launch': {'LaunchDescription': list},
        'launch.actions': {
            kind: recorder(kind)
            for kind in ('DeclareLaunchArgument', 'GroupAction', 'SetEnvironmentVariable')
        },
        'launch.conditions': {
            'IfCondition': lambda value: lambda context: is_true(value, context)
        },
        'launch.substitutions': SUBSTITUTIONS,
        'launch_ros': {},
        'launch_ros.actions': {
            kind: recorder(kind) for kind in ('LifecycleNode', 'Node', 'PushROSNamespace')
        },
        'launch_ros.parameter_descriptions': {'ParameterValue': ParameterValue},
        'launch_ros.substitutions': {
            'FindPackageShare': lambda name: Substitution(lambda _: SHARE)
        },
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location('shot_launch', FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def actions(launch_file, arguments):
    """Actions of the launch whose conditions hold, and the context in which they run."""
    context = dict(arguments)

    def flat(listed):
        for each in listed:
            condition = each.fields.get('condition')
            if condition and not condition(context):
                continue
            if each.kind == 'DeclareLaunchArgument':
                (name,) = each.args
                context.setdefault(name, text(each.fields['default_value'], context))
            elif each.kind == 'GroupAction':
                yield from flat(each.args[0])
            else:
                yield each

    return list(flat(launch_file.generate_launch_description())), context


def started(launch_file, **arguments):
    """Nodes that the launch file starts with these arguments, by executable."""
    listed, context = actions(launch_file, arguments)
    (namespace,) = [
        text(each.args[0], context) for each in listed if each.kind == 'PushROSNamespace'
    ]
    context['ros_namespace'] = namespace
    nodes = {}
    for each in listed:
        if each.kind not in ('Node', 'LifecycleNode'):
            continue
        fields = each.fields
        parameters = fields.get('parameters', [])
        settings = {}
        for part in parameters:
            if isinstance(part, dict):
                settings.update({name: value.perform(context) for name, value in part.items()})
        nodes[fields['executable']] = SimpleNamespace(
            package=fields['package'],
            executable=fields['executable'],
            kind=each.kind,
            name=fields.get('exec_name'),
            namespace=namespace,
            prefix=text(fields.get('prefix', ''), context),
            arguments=[text(word, context) for word in fields['arguments']],
            files=[text(part, context) for part in parameters if not isinstance(part, dict)],
            settings=settings,
            remappings={
                name: text(other, context) for name, other in fields.get('remappings', [])
            },
            respawn=fields.get('respawn', False),
        )
    return nodes

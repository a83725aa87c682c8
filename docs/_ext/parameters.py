"""The page of all parameters, made from their declarations in the nodes."""

import ast
from collections.abc import Iterator
import dataclasses
from importlib import import_module
from pathlib import Path
from typing import Any

from sphinx.ext.autodoc.mock import _MockObject, mock

ROS = (
    'action_msgs',
    'billiard_shot_msgs',
    'builtin_interfaces',
    'control_msgs',
    'diagnostic_msgs',
    'geometry_msgs',
    'nav_msgs',
    'rcl_interfaces',
    'rclpy',
    'sensor_msgs',
    'std_msgs',
    'std_srvs',
    'tf2_msgs',
    'trajectory_msgs',
    'vision_msgs',
    'visualization_msgs',
)
_MockObject.__or__ = lambda mocked, other: mocked  # type: ignore[method-assign]  # `Time | None`


def page(root: Path) -> str:
    """The page, in Markdown: the parameters, then the arguments of the launch file."""
    lines = [
        '# Parameters of the nodes',
        '',
        'Defaults are also in `config/NODE.yaml`. Every parameter is checked when a node starts '
        'and when it is set; a refused value is answered with the reason. Parameters with a * can '
        'be given only when the node starts.',
        '',
    ]
    with mock(list(ROS)):  # ROS does not have to be installed
        for node, kinds in _declared(root / 'billiard_shot' / 'ros'):
            lines += [
                f'## {node}',
                '',
                '| parameter | default | unit, range | what |',
                '|---|---|---|---|',
                *(row for kind in kinds for row in _rows(kind)),
                '',
            ]
    lines += ['## Launch arguments', '', _launch_arguments(root / 'launch' / 'shot.launch.py')]
    return '\n'.join(lines) + '\n'


def _declared(folder: Path) -> Iterator[tuple[str, list[type]]]:
    """Yield each node and the dataclasses that it passes to `parameters.declare`."""
    for file in sorted(folder.glob('*.py')):
        for call in ast.walk(ast.parse(file.read_text())):
            if isinstance(call, ast.Call) and ast.unparse(call.func) == 'parameters.declare':
                module = import_module(f'billiard_shot.ros.{file.stem}')
                yield file.stem, [getattr(module, ast.unparse(each)) for each in call.args[1:]]


def _rows(kind: Any) -> Iterator[str]:
    """Yield a row for each field of a dataclass of parameters."""
    fields = import_module('billiard_shot.scene.fields')
    parameters = import_module('billiard_shot.ros.parameters')
    words, defaults = fields.descriptions(kind), kind()
    for each in dataclasses.fields(kind):
        star = '*' if parameters.is_read_only(kind, each.name) else ''
        bounds = each.metadata.get(fields.NUMBER) or each.metadata.get(fields.WHOLE)
        yield (
            f'| `{each.name}`{star} | {_value(getattr(defaults, each.name))} | '
            f'{_range(bounds) if bounds else ""} | {words[each.name].text} |'
        )


def _range(bounds: Any) -> str:
    """Unit and range of a number."""
    limits = (
        ('above', bounds.above),
        ('from', bounds.minimum),
        ('to' if bounds.minimum is not None else 'up to', bounds.maximum),
    )
    said = ' '.join(f'{word} {limit:g}' for word, limit in limits if limit is not None)
    return ', '.join(filter(None, (bounds.unit, said)))


def _launch_arguments(file: Path) -> str:
    """The docstring of a launch file, and its arguments as a list."""
    module = ast.parse(file.read_text())
    (arguments,) = (
        each.value
        for each in module.body
        if isinstance(each, ast.Assign) and ast.unparse(each.targets[0]) == 'ARGUMENTS'
    )
    rows = [
        f'- `{ast.literal_eval(name)}`: {ast.literal_eval(pair.elts[1])}'
        for name, pair in zip(arguments.keys, arguments.values, strict=True)
    ]
    return '\n'.join([ast.get_docstring(module) or '', '', *rows])


def _value(value: Any) -> str:
    if isinstance(value, list):
        return ', '.join(f'`{each}`' for each in value)
    if isinstance(value, bool):
        return f'`{str(value).lower()}`'
    return f'`{value:g}`' if isinstance(value, float) else f'`{value}`' if value != '' else 'empty'

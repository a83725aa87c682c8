"""The page of all parameters, made from their declarations in the nodes."""

import ast
from importlib import import_module
from pathlib import Path
import re
from typing import Any

from sphinx.ext.autodoc.mock import mock

ROS = ('rclpy', 'rcl_interfaces', 'billiard_shot_msgs', 'geometry_msgs', 'std_msgs')


def declared(folder: Path) -> dict[str, Any]:
    """Parameters of each node, by its name; ROS does not have to be installed."""
    found = {}
    with mock(list(ROS)):
        for file in sorted((folder / 'ros').glob('*parameters.py')):
            module = import_module(f'billiard_shot.ros.{file.stem}')
            found |= {
                name.lower(): value
                for name, value in vars(module).items()
                if name.isupper()
                and isinstance(value, tuple)
                and all(hasattr(each, 'default') for each in value)
            }
    return dict(sorted(found.items()))


def page(root: Path) -> str:
    """The page, in Markdown: the parameters, then the arguments of the launch file."""
    lines = [
        '# Parameters of the nodes',
        '',
        'Defaults are also in `config/NODE.yaml`. Every parameter is checked when a node starts '
        'and when it is set; a refused value is answered with the reason.',
        '',
    ]
    for node, parameters in declared(root / 'billiard_shot').items():
        lines += [
            f'## {node}',
            '',
            '| parameter | default | unit, range | what |',
            '|---|---|---|---|',
            *map(_row, parameters),
            '',
        ]
    lines += ['## Launch arguments', '', _launch_arguments(root / 'launch' / 'shot.launch.py')]
    return '\n'.join(lines) + '\n'


def _launch_arguments(file: Path) -> str:
    """The docstring of a launch file, with its arguments as a list."""
    said = ast.get_docstring(ast.parse(file.read_text())) or ''
    return re.sub('^    `', '- `', said, flags=re.MULTILINE)


def _row(parameter: Any) -> str:
    about = ', '.join(filter(None, (parameter.unit, _range(parameter))))
    return (
        f'| `{parameter.name}` | {_value(parameter.default)} | {about} | {parameter.description} |'
    )


def _range(parameter: Any) -> str:
    if not parameter.limits:
        return ''
    return ' to '.join(
        f'{limit:g}' if isinstance(limit, float) else str(limit) for limit in parameter.limits
    )


def _value(value: Any) -> str:
    if isinstance(value, list):
        return ', '.join(f'`{each}`' for each in value)
    if isinstance(value, bool):
        return f'`{str(value).lower()}`'
    return f'`{value:g}`' if isinstance(value, float) else f'`{value}`' if value != '' else 'empty'

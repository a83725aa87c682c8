"""The scene of a calibration as YAML, with a comment for each number that was sought."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from billiard_shot.calibration.estimate import Estimate
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import printable

KEPT = 'not identifiable from these shots: default kept'


def scene_text(scene: Scene, estimates: Sequence[Estimate], heading: Sequence[str]) -> str:
    """
    Return the content of a scene file.

    Parameters
    ----------
    scene : Scene
    estimates : sequence of Estimate
        Those of the scene get a comment beside their key, all others above the scene.
    heading : sequence of str
        Lines above the scene.

    """
    return yaml_text(scene.to_dict(), estimates, heading)


def yaml_text(
    content: Mapping[str, Any], estimates: Sequence[Estimate], heading: Sequence[str]
) -> str:
    """Return any such content as YAML, with the comments of a scene."""
    about = {each.name: comment_on(each) for each in estimates}
    lines = list(_lines(content, (), about))
    others = [f'{name} {text}' for name, text in about.items()]  # of frames
    comments = [f'# {printable(line)}' for line in (*heading, *others)]
    return '\n'.join([*comments, *lines]) + '\n'


def comment_on(estimate: Estimate) -> str:
    """Say what is known of a number: its interval, and the shots that decide it."""
    if estimate.interval is None:
        return KEPT
    low, high = estimate.interval
    unit = f' {estimate.unit}' if estimate.unit else ''
    shots = f'; decided by shots {", ".join(estimate.shots)}' if estimate.shots else ''
    return (
        f'{estimate.value:.4g}{unit}, 95 %: {low:.4g} to {high:.4g}, before: '
        f'{estimate.before:.4g}{shots}'
    )


def _lines(
    section: Mapping[str, Any], path: tuple[str, ...], about: dict[str, str]
) -> Iterator[str]:
    """Yield the lines of a section; comments that are used are taken from `about`."""
    indent = '  ' * len(path)
    for key, value in section.items():
        here = (*path, key)
        name = yaml.safe_dump(key, default_flow_style=True).split('\n')[0]
        if isinstance(value, Mapping) and value:
            yield f'{indent}{name}:'
            yield from _lines(value, here, about)
            continue
        if comment := about.pop('.'.join(here), None):
            yield f'{indent}# {printable(comment)}'
        text = yaml.safe_dump(value, default_flow_style=True, width=1000).split('\n')[0]
        yield f'{indent}{name}: {text}'

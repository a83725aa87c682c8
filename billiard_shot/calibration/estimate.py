"""The estimate of a number that a calibration seeks.

The scene of a calibration as YAML, with a comment for each number that was sought.

Films that would decide the numbers of a scene that the shots so far do not decide.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from billiard_shot.scene.errors import printable


@dataclass(frozen=True, slots=True)
class Estimate:
    """
    A number that was sought.

    Attributes
    ----------
    name, unit : str
    before : float
        The value with which the calibration began.
    published : (float, float), optional
        Range of published values.
    value : float
        The one before, if these shots do not decide the number.
    interval : (float, float), optional
        Holds the truth in 95 % of calibrations; None if these shots do not decide the number.
    shots : tuple of str
        Those that decide it, the most important one first.

    """

    name: str
    unit: str
    before: float
    published: tuple[float, float] | None
    value: float
    interval: tuple[float, float] | None
    shots: tuple[str, ...]


KEPT = 'not identifiable from these shots: default kept'


def write_yaml(
    path: str | Path,
    content: Mapping[str, Any],
    estimates: Sequence[Estimate],
    heading: Sequence[str],
) -> None:
    """
    Write a file such as that of a scene.

    Parameters
    ----------
    path : str or Path
    content : mapping
        Sections and their keys.
    estimates : sequence of Estimate
        Those of the content get a comment beside their key, all others above it.
    heading : sequence of str
        Lines above it.

    """
    about = {each.name: comment_on(each) for each in estimates}
    lines = list(_lines(content, (), about))
    others = [f'{name} {text}' for name, text in about.items()]  # of frames
    comments = [f'# {printable(line)}' for line in (*heading, *others)]
    Path(path).write_text('\n'.join([*comments, *lines]) + '\n', encoding='utf-8')


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


FILM = {
    'cloth.sliding_friction': 'straight shots with draw that meet nothing for a metre',
    'cloth.rolling_resistance': 'slow balls that roll to rest without meeting anything',
    'cloth.rolling_rise': 'balls that roll without meeting anything, slow ones and fast ones',
    'cloth.spin_deceleration': 'slow shots with much side that come back from a far cushion',
    'contacts.ball_ball.restitution': 'full hits on a ball, and how far both balls go',
    'contacts.ball_ball.friction_fast': 'fast cuts of 30 to 60 degrees without side',
    'contacts.ball_ball.friction_slow': 'slow cuts of 30 to 60 degrees without side',
    'table.cushion.restitution': 'rolling balls straight at a cushion, slow ones and fast ones',
    'table.cushion.early_fading': 'slow balls straight at a cushion, at 0.2 to 1 m/s',
    'table.cushion.fading': 'balls straight at a cushion at 2 m/s and more',
    'table.cushion.frequency_ratio': 'balls that still slide when they meet a cushion',
    'table.cushion.friction': 'rolling balls at 30 to 60 degrees at a cushion, and side',
    'table.length': 'balls that bounce off both short cushions',
    'table.width': 'balls that bounce off both long cushions',
}
ANYTHING = 'more shots that go over the whole table'


def advice(estimates: Iterable[Estimate]) -> list[tuple[str, str]]:
    """Return what to film for each number that is not known, by its name."""
    return [
        (each.name, FILM.get(each.name, ANYTHING)) for each in estimates if each.interval is None
    ]

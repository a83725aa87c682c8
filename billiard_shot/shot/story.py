"""
Describe a shot: one sentence, and a list of facts.

Everything that tells people about a shot uses these texts: `print(shot)`, the command line, the
messages of the nodes, pictures and pages.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from billiard_shot.shot.messages import message_of
from billiard_shot.table.words import ball_in_words, moment_in_words, place_in_words

if TYPE_CHECKING:
    from billiard_shot.shot.shot import Shot

WIDTH = 80  # characters of a line
LABEL = 16  # characters of the name of a fact


def sentence(shot: Shot) -> str:
    """Describe a shot in one line; for a refused stroke, give the reason."""
    if shot.discontinuity > 0.0:
        trouble = (
            'law: the energetic law is discontinuous here; within the accuracy of the strike '
            f'the ball may rest at either of two positions {shot.discontinuity:.2g} m apart'
        )
    else:
        trouble = message_of(shot.status, shot.scene, shot.stroke, shot.trajectory)
    if shot.status.refused:
        return trouble
    return '; '.join(filter(None, [trouble, *_happenings(shot)]))


def facts(shot: Shot) -> dict[str, str]:
    """List what people ask of a shot, by name, with units; empty for a refused stroke."""
    if shot.status.refused:
        return {}
    a, b, elevation, azimuth, speed = shot.stroke.offsets
    vx, vy, vz = shot.velocity
    listed = {
        'stroke': (
            f'a {_number(a, 2, "+")}, b {_number(b, 2, "+")} radii; {_degrees(elevation, 1)} '
            f'steep, azimuth {_degrees(azimuth, 2)}; {speed:.3g} m/s'
        ),
        'cue ball leaves': (
            f'at {math.hypot(vx, vy, vz):.3g} m/s, azimuth {_degrees(math.atan2(vy, vx), 2)}; '
            f'spin {_vector(shot.spin, 1)} rad/s'
        ),
        'first contact': ball_in_words(shot.first_contact) if shot.first_contact else 'none',
        'pocketed': _pocketed(shot) or 'none',
    }
    if shot.off_table:
        listed['off the table'] = ', '.join(map(ball_in_words, shot.off_table))
    for fact, at_rest in (('rests at', True), ('moves on from', False)):
        if places := tuple(_places(shot, at_rest)):
            listed[fact] = ', '.join(places) + ' m'
    listed['error at most'] = f'{1e3 * shot.error_estimate:.1g} mm'
    if shot.first_contact:
        until = ball_in_words(shot.first_contact)
        listed['error at most'] += f', until the cue ball meets {until}'
    if len(shot.run.names) == 1:
        del listed['first contact']
    if shot.scene.table is None or not shot.scene.table.pockets:
        del listed['pocketed']
    return listed


def as_text(shot: Shot) -> str:
    """Write status, sentence and facts, in lines of at most 80 characters."""
    lines = textwrap.wrap(f'{shot.status.name}: {sentence(shot)}', WIDTH, subsequent_indent='    ')
    return '\n'.join([*lines, *(wrapped_fact(*fact) for fact in facts(shot).items())])


def wrapped_fact(name: str, text: str) -> str:
    """Write a fact below its sentence, in lines of at most 80 characters."""
    return textwrap.fill(
        text,
        WIDTH,
        initial_indent=f'  {name:{LABEL}}',
        subsequent_indent=' ' * (2 + LABEL),
        break_on_hyphens=False,
    )


def as_html(shot: Shot) -> str:
    """Write status, sentence and facts as HTML, for notebooks."""
    rows = ''.join(
        f'<tr><th style="text-align: left">{escape(name)}</th>'
        f'<td style="text-align: left">{escape(text)}</td></tr>'
        for name, text in facts(shot).items()
    )
    return f'<p><b>{shot.status.name}</b>: {escape(sentence(shot))}</p><table>{rows}</table>'


def _happenings(shot: Shot) -> Iterator[str]:
    yield _pocketed(shot)
    for ball in shot.off_table:
        yield f'{ball_in_words(ball)} off the table'
    if shot.first_contact:
        yield f'first contact {shot.first_contact}'
    elif len(shot.run.names) > 1:
        yield 'no ball hit'
    if shot.double_hit:  # at 0, the tip met the ball again within the strike: that is one stroke
        yield f'a double hit: the cue hits the ball again {moment_in_words(shot.double_hit)}'
    if all(ball.comes_to_rest for ball in shot.run.balls.values()):
        yield f'at rest after {shot.run.duration:.3g} s'


def _pocketed(shot: Shot) -> str:
    """Say which balls fell where; the cue ball scratches."""
    falls = {ball: f'into {place_in_words(pocket)}' for ball, pocket in shot.pocketed.items()}
    return '; '.join(
        f'cue ball scratched {where}' if ball == 'cue' else f'{ball} {where}'
        for ball, where in falls.items()
    )


def _places(shot: Shot, at_rest: bool) -> Iterator[str]:
    """Tell where balls that moved, or were struck, rest on the table, or where they move on."""
    gone = {*shot.pocketed, *shot.off_table}
    for name, ball in shot.run.balls.items():
        moved = name == 'cue' or len(ball.rows) > 1
        if name not in gone and moved and ball.comes_to_rest == at_rest:
            yield f'{ball_in_words(name)} {_vector(ball.final_position[:2], 3)}'


def _vector(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], digits: int) -> str:
    return f'({", ".join(_number(value, digits) for value in values.tolist())})'


def _degrees(radians: float, digits: int) -> str:
    return f'{_number(math.degrees(radians), digits)}°'


def _number(value: float, digits: int, sign: str = '') -> str:
    return f'{round(value, digits) + 0.0:{sign}.{digits}f}'  # + 0.0 makes 0 of -0

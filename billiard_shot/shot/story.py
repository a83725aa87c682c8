"""
Describe a shot: one sentence, and a list of facts.

Everything that tells people about a shot uses these texts: `print(shot)`, the command line, the
messages of the nodes, pictures and pages.
"""

from __future__ import annotations

from collections.abc import Iterator
import math
import re
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.messages import message_of
from billiard_shot.table.words import ball_in_words, moment_in_words, place_in_words, rounded

if TYPE_CHECKING:
    from billiard_shot.shot.shot import Shot

STORY_WIDTH = 80  # characters of a line
NO_BREAK = '\xa0'
LABEL = 16  # characters of the name of a fact
FASTEST_CUE = 30.0  # m/s; no cue is as fast


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
            f'a {rounded(a, 2, "+")}, b {rounded(b, 2, "+")} radii; elevation '
            f'{_degrees(elevation, 1)}, azimuth {_degrees(azimuth, 2)}; {speed:.3g} m/s'
        ),
        'cue ball leaves': (
            f'at {math.hypot(vx, vy, vz):.3g} m/s, azimuth {_degrees(math.atan2(vy, vx), 2)}'
        ),
        'spin': f'{_spin_in_words(shot)} rad/s',
        'spin x, y, z': f'{_vector(shot.spin, 1)} rad/s',
    }
    if shot.tip_time > 0.0:
        chatter = ' (it chatters)' if shot.chatter else ''
        listed['touch'] = (
            f'tip {_milliseconds(shot.tip_time)}{chatter}, cloth {_milliseconds(shot.cloth_time)}'
        )
    if speed > FASTEST_CUE:
        listed['warning'] = f'no cue reaches {speed:.3g} m/s; breaks have up to 15 m/s'
    if len(shot.run.names) > 1:
        listed['first contact'] = (
            ball_in_words(shot.first_contact) if shot.first_contact else 'none'
        )
    for name in sorted(shot.run.names, key=_order):
        if outcome := _outcome(shot, name):
            listed['cue ball' if name == CUE_BALL else f'ball {name}'] = outcome
    listed['numerical error'] = f'at most {1e3 * shot.error_estimate:.1g} mm'
    if shot.first_contact:
        until = ball_in_words(shot.first_contact)
        listed['numerical error'] += f' until the cue ball meets {until}'
    elif not shot.trajectory.comes_to_rest:
        listed['numerical error'] += f' until {shot.trajectory.duration:.3g} s'
    return listed


def as_text(shot: Shot) -> str:
    """Write status, sentence and facts, in lines of at most 80 characters."""
    lines = textwrap.wrap(
        f'{shot.status.name}: {sentence(shot)}', STORY_WIDTH, subsequent_indent='    '
    )
    return '\n'.join([*lines, *(wrapped_fact(*fact) for fact in facts(shot).items())])


def wrapped_fact(name: str, text: str) -> str:
    """Write a fact below its sentence, in lines of at most 80 characters; units stay in place."""
    return textwrap.fill(
        re.sub(r'(?<=\d) (?=m/s)', NO_BREAK, text),
        STORY_WIDTH,
        initial_indent=f'  {name:{LABEL}}',
        subsequent_indent=' ' * (2 + LABEL),
        break_on_hyphens=False,
    ).replace(NO_BREAK, ' ')


def _happenings(shot: Shot) -> Iterator[str]:
    if shot.miscue:
        yield 'a miscue: the tip slid on the ball'
    yield _pocketed(shot)
    for ball in shot.off_table:
        yield f'{ball_in_words(ball)} off the table'
    if shot.first_contact:
        yield f'first contact {shot.first_contact}'
    elif len(shot.run.names) > 1:
        yield 'no ball hit'
    if shot.double_hit is not None:
        yield f'a double hit: the cue hits the ball again {moment_in_words(shot.double_hit)}'
    if all(ball.comes_to_rest for ball in shot.run.balls.values()):
        yield f'at rest after {shot.run.duration:.3g} s'


def _pocketed(shot: Shot) -> str:
    """Say which balls fell where; the cue ball scratches."""
    falls = {ball: f'into {place_in_words(pocket)}' for ball, pocket in shot.pocketed.items()}
    return '; '.join(
        f'cue ball scratched {where}' if ball == CUE_BALL else f'{ball} {where}'
        for ball, where in falls.items()
    )


def _outcome(shot: Shot, name: str) -> str:
    """Say where a ball that moved, or was struck, ends; '' for the others."""
    ball = shot.run.balls[name]
    if name in shot.pocketed:
        return f'falls into {place_in_words(shot.pocketed[name])}'
    if name in shot.off_table:
        return 'leaves the table'
    if name != CUE_BALL and len(ball.rows) == 1:
        return ''
    ends = 'rests at' if ball.comes_to_rest else 'moves on from'
    return f'{ends} {_vector(ball.final_position[:2], 3)} m'


def _order(name: str) -> tuple[bool, float, str]:
    """Sort the cue ball first, numbers by their values, and other names by the alphabet."""
    return name != CUE_BALL, float(name) if name.isdecimal() else math.inf, name


def _spin_in_words(shot: Shot) -> str:
    """
    State the spin [rad/s] about three axes, as seen along the horizontal motion of the ball.

    Top and back spin: about the level axis across the motion. Side spin: about the vertical, named
    by the side on which the cue hits. Massé spin: about the direction of motion, named by the side
    to which the cloth turns the ball.
    """
    _, _, _, azimuth, _ = shot.stroke.offsets
    vx, vy, _ = shot.velocity
    heading = math.atan2(vy, vx) if math.hypot(vx, vy) > 0.0 else azimuth
    cosine, sine = math.cos(heading), math.sin(heading)
    x, y, z = shot.spin.tolist()
    named = (
        (cosine * y - sine * x, 'top', 'back'),
        (z, 'right', 'left'),
        (cosine * x + sine * y, 'massé right', 'massé left'),
    )
    told = [
        f'{positive if value > 0.0 else negative} {abs(value):.1f}'
        for value, positive, negative in named
        if abs(value) >= 0.05  # else it is written as 0.0
    ]
    return ', '.join(told) or '0.0'


def _vector(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], digits: int) -> str:
    return f'({", ".join(rounded(value, digits) for value in values.tolist())})'


def _milliseconds(seconds: float) -> str:
    return f'{1e3 * seconds:.3g} ms'


def _degrees(radians: float, digits: int) -> str:
    return f'{rounded(math.degrees(radians), digits)}°'

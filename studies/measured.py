"""
Each published value beside the one that is computed here.

    python studies/measured.py [--json]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
import json
from pathlib import Path
import sys
import textwrap
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for `python studies/measured.py`
from collections.abc import Sequence

from billiard_shot.cli.output import OfFormat, print_csv, progress, table
from billiard_shot.cli.workers import mapped, OfWork
from billiard_shot.scene import BallBall, Scene
from billiard_shot.table.run.results import rounded
from studies import published
from studies import published_shots as shots
from studies.command import run_study

MEASURED_SPEED = 2.0  # m/s, of the cue ball in the 30 degree rule and in draw shots
REBOUND_SPEEDS = 20  # of the RMS deviation
SHOWN_REBOUNDS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5)  # m/s
ROLLING_SPEED = 1.0  # m/s, of roll-outs


@dataclass(frozen=True, slots=True)
class Comparison:
    """
    A published value beside the computed one, in the same unit.

    Attributes
    ----------
    case : str
        Heading that consecutive comparisons share; empty for no heading.
    quantity : str
    unit : str
    published : float, optional
        None if nothing was published.
    computed : float
    uncertainty : float, optional
        Of the published value, plus or minus; None if not stated.
    digits : int
        Behind the decimal point, as published.

    """

    case: str
    quantity: str
    unit: str
    published: float | None
    computed: float
    uncertainty: float | None = None
    digits: int = 1

    @property
    def deviation(self) -> float | None:
        """Computed minus published value."""
        return None if self.published is None else self.computed - self.published


@dataclass(frozen=True, slots=True)
class Group:
    """Comparisons of one kind, with a title and the keys of their sources."""

    title: str
    sources: tuple[str, ...]
    rows: tuple[Comparison, ...]


def comparisons() -> list[Callable[[], Group]]:
    """Return functions that compute a group each; processes can share them."""
    pool, snooker, carom = (Scene.load(name) for name in ('pool', 'snooker', 'carom'))
    pool_table = Scene.load('pool_table')
    cloths = {
        'Ideal balls (restitution 1, no friction)': shots.endless(pool, shots.IDEAL),
        'Scene pool': shots.endless(pool),
    }
    return [
        partial(_collisions, snooker),
        partial(_collision_errors, snooker),
        partial(_rebounds, snooker),
        partial(_carom_rebounds, carom),
        partial(_pool_cushions, pool_table),
        partial(_corner_five, pool_table),
        *(
            partial(group, name, scene)
            for name, scene in cloths.items()
            for group in (_deflections, _draw)
        ),
        partial(_throw, shots.endless(pool)),
        partial(_rolling, snooker, carom),
        partial(_ramp, pool),
    ]


def compare(function: Callable[[], Group]) -> Group:
    """Compute a group."""
    return function()


def collision_contacts(scene: Scene) -> dict[str, BallBall]:
    """Return the three contacts of balls with which the five collisions are computed."""
    ours = scene.contacts.ball_ball
    mixed = replace(ours, friction_fast=published.AUTHORS_FRICTION, friction_slow=0.0)
    return {
        'authors': replace(mixed, restitution=published.AUTHORS_RESTITUTION),
        'scene': ours,
        'mixed': mixed,
    }


def collision_results(scene: Scene, ball_ball: BallBall) -> list[tuple[float, float, float]]:
    """Return object ball speed, cue ball speed [m/s] and cue ball direction [degrees] of all."""
    cloth = shots.endless(scene, ball_ball)
    results = []
    for shot in published.PUBLISHED_COLLISIONS:
        run = shots.collide_two(cloth, shot.speed, shot.cut, 1.0)
        cue_speed, direction = shots.after_slip(run, 'cue')
        results.append((shots.after_slip(run, 'object')[0], cue_speed, -direction))
    return results


def rms_errors(results: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Return RMS deviations from the five collisions: two relative speeds, and degrees."""
    deviations = [
        (
            object_speed / shot.object_speed - 1.0,
            cue_speed / shot.cue_speed - 1.0,
            direction - shot.direction,
        )
        for shot, (object_speed, cue_speed, direction) in zip(
            published.PUBLISHED_COLLISIONS, results, strict=True
        )
    ]
    first, second, third = np.sqrt(np.mean(np.square(deviations), axis=0)).tolist()
    return first, second, third


def _collisions(scene: Scene) -> Group:
    mixed = collision_contacts(scene)['mixed']
    results = collision_results(scene, mixed)
    rows = []
    for shot, (object_speed, cue_speed, direction) in zip(
        published.PUBLISHED_COLLISIONS, results, strict=True
    ):
        case, accuracy = f'{shot.speed:.3f} m/s, {shot.cut:.2f} deg', published.SPEED_ACCURACY
        rows += [
            Comparison(case, 'cue ball', 'm/s', shot.cue_speed, cue_speed, accuracy, digits=3),
            Comparison(
                case, 'object ball', 'm/s', shot.object_speed, object_speed, accuracy, digits=3
            ),
            Comparison(
                case, 'cue ball direction', 'deg', shot.direction, direction, None, digits=2
            ),
        ]
    return Group(
        'A rolling snooker ball meets a resting ball (Table I): speeds, and direction from the '
        f'incoming line, after slip. Friction between balls {mixed.friction_fast} (the authors), '
        f'restitution {mixed.restitution} (scene snooker).',
        ('imaging',),
        tuple(rows),
    )


def _collision_errors(scene: Scene) -> Group:
    rows = []
    for key, ball_ball in collision_contacts(scene).items():
        pair = f'{ball_ball.friction_fast}, {ball_ball.restitution}'
        cases = {'authors': f'{pair} (authors)', 'scene': 'scene snooker', 'mixed': pair}
        errors = rms_errors(collision_results(scene, ball_ball))
        rows += [
            Comparison(cases[key], quantity, unit, scale * of_authors, scale * error)
            for quantity, unit, scale, of_authors, error in zip(
                ('object ball', 'cue ball', 'direction'),
                ('%', '%', 'deg'),
                (100.0, 100.0, 1.0),
                published.PREDICTED_RMS,
                errors,
                strict=True,
            )
        ]
    return Group(
        "RMS deviation from these five shots: of the authors' own prediction (published), and "
        'computed with three pairs of friction and restitution between balls.',
        ('prediction',),
        tuple(rows),
    )


def _rebounds(scene: Scene) -> Group:
    rows = [
        Comparison(
            '',
            f'at {speed} m/s',
            'm/s',
            published.rebound_speed(speed),
            shots.rebound(scene, speed),
            None,
            digits=3,
        )
        for speed in SHOWN_REBOUNDS
    ]
    low, high = published.REBOUND_RANGE
    deviations = [
        shots.rebound(scene, speed) - published.rebound_speed(speed)
        for speed in np.linspace(low, high, REBOUND_SPEEDS).tolist()
    ]
    rms = float(np.sqrt(np.mean(np.square(deviations))))
    rows.append(
        Comparison(
            '',
            f'RMS, {REBOUND_SPEEDS} speeds from {low} to {high}',
            'm/s',
            None,
            rms,
            None,
            digits=3,
        )
    )
    return Group(
        'A snooker ball rolls squarely at a cushion: speed just after, published as a fit to 31 '
        'shots. Scene snooker.',
        ('imaging',),
        tuple(rows),
    )


def _carom_rebounds(scene: Scene) -> Group:
    rows = []
    for each in published.CAROM_REBOUNDS:
        case = f'{each.speed:.2f} m/s, {each.angle:.0f} deg'
        away, along = shots.kept_speeds(scene, each.speed, each.angle, each.follow)
        if each.follow < 1.0:
            case += ', slides'
        rows.append(
            Comparison(case, 'away from it', '', each.away, away, each.away_error, digits=3)
        )
        if each.along is not None:
            rows.append(
                Comparison(case, 'along it', '', each.along, along, each.along_error, digits=3)
            )
    return Group(
        'A carom ball rolls or slides at a cushion, at an angle from its normal: speed after '
        'slip, relative to that before. Medians of 5 to 31 rebounds. Scene carom, whose cushion '
        'is a fit to all rebounds of this source.',
        ('carom',),
        tuple(rows),
    )


def _pool_cushions(scene: Scene) -> Group:
    low, high = published.POOL_RESTITUTION
    fewest, most = published.TABLE_LENGTHS
    least = replace(scene, cloth=replace(scene.cloth, rolling_resistance=published.LEAST_ROLLING))
    case = f'squarely, {MEASURED_SPEED:g} m/s'
    just_after = shots.rebound(scene, MEASURED_SPEED) / MEASURED_SPEED
    after_slip = shots.kept_speeds(scene, MEASURED_SPEED, 0.0)[0]
    rows = [
        Comparison(
            case, 'just after', '', 0.5 * (low + high), just_after, 0.5 * (high - low), digits=2
        ),
        Comparison(case, 'after slip', '', published.POOL_KEPT, after_slip, None, digits=2),
    ]
    rows += [
        Comparison(
            f'rolling resistance {cloth.cloth.rolling_resistance}',
            'lengths',
            '',
            0.5 * (fewest + most),
            shots.table_lengths(cloth, published.POWER_SHOT),
            0.5 * (most - fewest),
            digits=2,
        )
        for cloth in (scene, least)
    ]
    return Group(
        'Cushions of pool: speed over that before (coefficient of restitution; "about half"), and '
        'least table lengths of a ball that is shot firmly along the table, here at '
        f'{published.POWER_SHOT:.1f} m/s. Scene pool_table.',
        ('properties', 'efficiency', 'equipment', 'speeds'),
        tuple(rows),
    )


def _corner_five(scene: Scene) -> Group:
    side, thirds = shots.corner_five(scene, published.CORNER_FIVE)
    return Group(
        f'Corner-five system, {shots.CORNER_FIVE_SPEED:g} m/s: place at the third cushion. The '
        f"side spin, {side:.2f} of a rolling ball's spin, is chosen so that the largest deviation "
        'is smallest. Scene pool_table.',
        ('corner five', 'equipment'),
        tuple(
            Comparison(
                '',
                f'from {origin:g} to {first:g}',
                'diamonds',
                origin - first,
                third,
                None,
                digits=2,
            )
            for (origin, first), third in zip(published.CORNER_FIVE, thirds.tolist(), strict=True)
        ),
    )


def _deflections(name: str, scene: Scene) -> Group:
    fractions = np.linspace(0.25, 0.75, 51).tolist()
    angles = [shots.deflection(scene, MEASURED_SPEED, fraction, 1.0) for fraction in fractions]
    low, high = published.DEFLECTION_RANGE
    return Group(
        f'Deflection of a rolling cue ball by a resting ball, {MEASURED_SPEED:g} m/s. {name}.',
        ('30 degrees',),
        (
            Comparison('', 'half ball', 'deg', published.HALF_BALL_DEFLECTION, angles[25]),
            Comparison('', 'smallest from 1/4 to 3/4 ball', 'deg', low, min(angles), 0.5),
            Comparison('', 'largest from 1/4 to 3/4 ball', 'deg', high, max(angles), 0.5),
        ),
    )


def _draw(name: str, scene: Scene) -> Group:
    ratio = shots.draw_for_right_angle(scene, MEASURED_SPEED)
    return Group(
        f'Deflection of a cue ball with draw, {MEASURED_SPEED:g} m/s. Its backspin, {ratio:.3f} '
        f"of a rolling ball's spin, is chosen for 90 deg at half ball. {name}.",
        ('draw',),
        tuple(
            Comparison(
                '',
                f'{fraction:g} ball',
                'deg',
                angle,
                shots.deflection(scene, MEASURED_SPEED, fraction, -ratio),
            )
            for fraction, angle in published.DRAW_DEFLECTION.items()
        ),
    )


def _throw(scene: Scene) -> Group:
    size, place = shots.largest_throw(scene, published.SLOW)
    rows = []
    for case, (angle, cut) in (
        ('slow, measured', published.THROW_MAXIMUM),
        ('slow, formula', published.THROW_FORMULA_MAXIMUM),
    ):
        rows += [
            Comparison(case, 'largest throw', 'deg', angle, size),
            Comparison(case, 'cut angle of it', 'deg', cut, place),
        ]
    rows += [
        Comparison(
            f'{name}, measured',
            'throw at 10 deg',
            'deg',
            published.THROW_AT_10_DEGREES,
            shots.throw_angle(scene, speed, 10.0),
        )
        for name, speed in (('slow', published.SLOW), ('fast', published.FAST))
    ]
    return Group(
        f'Throw of stun shots, slow ({published.SLOW:.2f} m/s) and fast ({published.FAST:.2f} '
        'm/s). Scene pool.',
        ('throw', 'throw formula'),
        tuple(rows),
    )


def _rolling(snooker: Scene, carom: Scene) -> Group:
    low, high = published.SNOOKER_ROLLING
    measured = [
        ('snooker cloth', snooker, ROLLING_SPEED, 0.5 * (low + high), 0.5 * (high - low)),
        *((f'carom, {row[0]} m/s', carom, *row) for row in published.CAROM_ROLLING),
    ]
    return Group(
        'Deceleration of a rolling ball over gravity. The scenes snooker and carom take it from '
        'these sources.',
        ('imaging', 'carom'),
        tuple(
            Comparison('', name, '', value, resistance_at(scene, speed), error, digits=4)
            for name, scene, speed, value, error in measured
        ),
    )


def resistance_at(scene: Scene, speed: float) -> float:
    """Return the deceleration of a rolling ball over gravity at a speed [m/s]."""
    faster, slower = 1.05 * speed, 0.95 * speed
    way = shots.roll_out(scene, faster) - shots.roll_out(scene, slower)
    return (faster**2 - slower**2) / (2.0 * scene.cloth.gravity * way)


def ramp_scene(scene: Scene, coefficient: float) -> Scene:
    """Return a scene whose rolling resistance follows from force over weight, see `RAMP`."""
    share = 1.0 + scene.ball.inertia / (scene.ball.mass * scene.ball.radius**2)
    return replace(scene, cloth=replace(scene.cloth, rolling_resistance=coefficient / share))


def _ramp(scene: Scene) -> Group:
    cloth = ramp_scene(scene, published.RAMP_COEFFICIENT)
    return Group(
        f'Roll-out of a ball from a ramp. Published coefficient {published.RAMP_COEFFICIENT} '
        f'(force over weight): rolling resistance {cloth.cloth.rolling_resistance:.4f}. '
        'Ball of scene pool.',
        ('ramp',),
        tuple(
            Comparison(
                '',
                f'from {1e3 * height:g} mm',
                'mm',
                1e3 * distance,
                1e3 * shots.roll_out(cloth, shots.speed_from_ramp(cloth, height)),
                None,
                digits=0,
            )
            for height, distance in published.RAMP
        ),
    )


LINE_WIDTH = 80  # characters of a line
LABEL_WIDTH = 40  # characters of the name of a row


OPTIONS = OfFormat(), OfWork()


def run(options: argparse.Namespace) -> int:
    """Compute and print."""
    work = comparisons()
    groups = list(progress(mapped(options, compare, work), 'measured', len(work)))
    if options.json:
        print(json.dumps(_as_json(groups), allow_nan=False))
        return 0
    if options.csv:
        rows = [row for group in _as_json(groups)['groups'] for row in group['rows']]
        print_csv(rows, list(rows[0]))
        return 0
    keys = list(published.SOURCES)
    for group in groups:
        numbers = ' '.join(f'[{keys.index(key) + 1}]' for key in group.sources)
        print(textwrap.fill(f'{group.title} {numbers}', LINE_WIDTH))
        print(f'{_as_table(group)}\n')
    for number, text in enumerate(published.SOURCES.values(), 1):
        print(textwrap.fill(f'[{number}] {text}', LINE_WIDTH, subsequent_indent='    '))
    return 0


def _as_table(group: Group) -> str:
    rows = [('', 'published', '   +-', 'computed', 'deviation')]
    case = ''
    for row in group.rows:
        rows.append(
            (
                _label(row, row.case == case).ljust(LABEL_WIDTH),
                _number(row.published, row.digits, 9),
                _number(row.uncertainty, row.digits, 6),
                _number(row.computed, row.digits, 8),
                _number(row.deviation, row.digits, 9, '+'),
            )
        )
        case = row.case
    return table(rows)


def _label(row: Comparison, again: bool) -> str:
    """Name a row; its case only in the first row of that case."""
    case = '' if not row.case else '  ' if again else f'{row.case}: '
    return f'{case}{row.quantity}' + (f' ({row.unit})' if row.unit else '')


def _number(value: float | None, digits: int, width: int, sign: str = '') -> str:
    return ('' if value is None else rounded(value, digits, sign)).rjust(width)


def _as_json(groups: list[Group]) -> dict[str, Any]:
    return {
        'groups': [
            {
                'title': group.title,
                'sources': list(group.sources),
                'rows': [
                    {
                        'title': group.title,
                        'case': row.case,
                        'quantity': row.quantity,
                        'unit': row.unit,
                        'published': row.published,
                        'uncertainty': row.uncertainty,
                        'computed': row.computed,
                        'deviation': row.deviation,
                    }
                    for row in group.rows
                ],
            }
            for group in groups
        ],
        'sources': published.SOURCES,
    }


def main(words: Sequence[str] | None = None) -> int:
    """Run the study; return its exit code."""
    return run_study(__doc__, OPTIONS, run, words)


if __name__ == '__main__':
    sys.exit(main())

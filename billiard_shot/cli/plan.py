"""`billiard-shot plan`: the stroke most likely to reach a target."""

import argparse
from dataclasses import asdict, fields
import json
import math
from pathlib import Path
import sys
from typing import Any

import billiard_shot
from billiard_shot import PlanResult, RankedStroke, Scene, Status
from billiard_shot.cli.progress import reporting, wait_for_machine_code
from billiard_shot.cli.search import add_search_arguments, noise_of
from billiard_shot.cli.text_table import numbers, table
from billiard_shot.pictures.canvas import require_matplotlib
from billiard_shot.pictures.plan import draw_plan
from billiard_shot.planning.dispersion import sample_outcomes
from billiard_shot.planning.limits import BALLS
from billiard_shot.planning.search import NORMAL_BUDGET
from billiard_shot.scene import Robot
from billiard_shot.scene.fields import FORMER
from billiard_shot.table.run import POCKET_NAMES

HELP = 'find the stroke most likely to reach a target, given execution noise and limits'
PICTURE_TRIALS = 400  # noisy executions in a picture


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, target, limits, noise, budget and output."""
    parser.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    target = parser.add_argument_group('target: one of these')
    target.add_argument(
        '--pot', nargs='+', metavar='BALL', help='ball to be potted, several, or any'
    )
    target.add_argument('--hit', metavar='BALL', help='ball to be hit first')
    for name, text in (
        ('rest', 'point at which the cue ball has to rest (m)'),
        ('pass', 'point that the cue ball has to pass (m)'),
    ):
        target.add_argument(f'--{name}', type=float, nargs=2, metavar=('X', 'Y'), help=text)
    target.add_argument(
        '--gate',
        type=float,
        nargs=4,
        metavar=('X1', 'Y1', 'X2', 'Y2'),
        help='two points between which the cue ball has to pass (m)',
    )
    more = parser.add_argument_group('details of the target')
    more.add_argument(
        '--pocket',
        action='append',
        choices=['any', *POCKET_NAMES],
        help='pocket for --pot, may be repeated (default: any)',
    )
    for name, text in (
        ('leave', 'for --pot: point at which the cue ball has to rest'),
        ('at', 'for --hit: point at which the cue ball has to touch the ball'),
        ('direction', 'for --hit: direction in which the ball has to leave'),
    ):
        more.add_argument(f'--{name}', type=float, nargs=2, metavar=('X', 'Y'), help=text)
    more.add_argument(
        '--radius', type=float, metavar='M', help='largest distance from the point (m)'
    )
    more.add_argument(
        '--direction-tolerance-deg',
        '--within-deg',  # its former name
        type=float,
        metavar='DEG',
        help='largest deviation from --direction',
    )
    limits = parser.add_argument_group('limits that replace those of the scene')
    limits.add_argument(
        '--first-contact', nargs='+', metavar='BALL', help='balls of which one must be hit first'
    )
    limits.add_argument('--keep', nargs='+', metavar='BALL', help='balls that must not be potted')
    for field in fields(Robot):
        names = [field.name, *(field.metadata[key] for key in (FORMER,) if key in field.metadata)]
        options = (f'--{name.replace("_", "-")}' for name in names)
        limits.add_argument(*options, type=float, metavar='NUMBER')
    add_search_arguments(parser, NORMAL_BUDGET, '')
    parser.add_argument(
        '--time-limit', type=float, metavar='S', help='end the search after this time (s)'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object, in SI units')
    parser.add_argument(
        '--picture',
        type=Path,
        metavar='FILE.png',
        help='draw the plan and the outcomes of noisy executions',
    )


def run(options: argparse.Namespace) -> int:
    """Plan and print; 1 if there is no plan. ValueError for an invalid request."""
    wait_for_machine_code()
    if options.picture:
        require_matplotlib()  # before the work, not after it
    scene = Scene.load(options.scene)
    noise = noise_of(options, scene)
    with reporting('strokes', options.budget) as report:
        result = billiard_shot.plan(
            scene,
            _target(options),
            noise,
            options.budget,
            options.seed,
            _constraints(options),
            progress=lambda now: report(now.simulations),
            time_limit=options.time_limit,
        )
    if result.status == Status.INVALID_REQUEST:
        raise ValueError(result.message)
    print(json.dumps(_as_json(result), allow_nan=False) if options.json else _as_text(result))
    if result.best is None:
        print(f'{result.status.name}: {result.message}', file=sys.stderr)
        return 1
    if options.picture:
        outcomes = sample_outcomes(result.best, result.noise, PICTURE_TRIALS)
        draw_plan(result.best, outcomes, options.picture)
    return 0


def _target(options: argparse.Namespace) -> dict[str, Any]:
    """Collect the options of the target; `plan` checks them."""
    names = (
        'pot',
        'hit',
        'rest',
        'pass',
        'pocket',
        'leave',
        'at',
        'direction',
        'radius',
        'direction_tolerance_deg',
    )
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    if options.gate:
        given['gate'] = options.gate[:2], options.gate[2:]
    if given.get('pocket') and 'any' in given['pocket']:
        given['pocket'] = 'any'
    return given


def _constraints(options: argparse.Namespace) -> dict[str, Any]:
    names = (*BALLS, *asdict(Robot()))
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def _as_text(result: PlanResult) -> str:
    if not result.ranking:
        return f'{result.simulations} strokes simulated in {result.wall_time:.2f} s'
    rows = [
        (
            '',
            'kind',
            'success',
            '95 % CI',
            'a',
            'b',
            'elevation',
            'azimuth',
            'speed',
            'cue ball rests',
        ),
        ('', '', '(%)', '(%)', '(radii)', '(radii)', '(degrees)', '(degrees)', '(m/s)', 'x y (m)'),
    ]
    for place, each in enumerate(result.ranking, 1):
        a, b, elevation, azimuth, speed = each.stroke.offsets
        low, high = each.interval
        rows.append(
            (
                str(place),
                each.kind,
                f'{100.0 * each.success:5.1f}',
                f'{100.0 * low:.1f} to {100.0 * high:.1f}',
                f'{a:+.3f}',
                f'{b:+.3f}',
                f'{math.degrees(elevation):6.2f}',
                f'{math.degrees(azimuth):8.3f}',
                f'{speed:.3f}',
                numbers(each.shot.trajectory.final_position[:2], 3),
            )
        )
    rate = result.simulations / max(result.wall_time, 1e-9)
    return (
        f'{result.status.name}: {result.message}\n{table(rows)}\n{result.simulations} strokes '
        f'simulated in {result.wall_time:.2f} s, {rate:.0f} a second'
    )


def _as_json(result: PlanResult) -> dict[str, Any]:
    return {
        'status': result.status.name,
        'message': result.message,
        'simulations': result.simulations,
        'wall_time': result.wall_time,
        'noise': asdict(result.noise),
        'ranking': [_stroke(each) for each in result.ranking],
    }


def _stroke(each: RankedStroke) -> dict[str, Any]:
    a, b, elevation, azimuth, speed = each.stroke.offsets
    return {
        'kind': each.kind,
        'success': each.success,
        'interval': list(each.interval),
        'trials': each.trials,
        'a': a,
        'b': b,
        'elevation': elevation,
        'azimuth': azimuth,
        'speed': speed,
        'normal': list(each.stroke.normal),
        'velocity': list(each.stroke.velocity),
        'rest': each.shot.trajectory.final_position.tolist(),
    }

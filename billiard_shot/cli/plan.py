"""`billiard-shot plan`: which stroke reaches a target, and how surely."""

import argparse
from dataclasses import asdict
import json
import math
from pathlib import Path
import sys
from typing import Any

import billiard_shot
from billiard_shot import PlanResult, RankedStroke, Scene, Status
from billiard_shot.cli.layout import numbers, table
from billiard_shot.cli.progress import reporting, wait_for_machine_code
from billiard_shot.cli.search import add_search_arguments, noise_of
from billiard_shot.pictures.canvas import require_matplotlib
from billiard_shot.pictures.plan import draw_plan
from billiard_shot.planning.cloud import cloud_of
from billiard_shot.planning.search import NORMAL_BUDGET
from billiard_shot.scene import Robot
from billiard_shot.table.run import POCKET_NAMES

HELP = 'which stroke reaches a target, and how surely, under noise and limits'
CLOUD = 400  # strokes with noise in a picture


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Scene, target, noise, budget, limits, output."""
    parser.add_argument('scene', metavar='SCENE', help='bundled scene or YAML file')
    target = parser.add_argument_group('target: one of these')
    for name, text in (('pot', 'ball that is to fall'), ('hit', 'ball that is to be met first')):
        target.add_argument(f'--{name}', metavar='BALL', help=text)
    for name, text in (
        ('rest', 'where the cue ball is to rest (m)'),
        ('pass', 'where it is to pass (m)'),
    ):
        target.add_argument(f'--{name}', type=float, nargs=2, metavar=('X', 'Y'), help=text)
    target.add_argument(
        '--gate',
        type=float,
        nargs=4,
        metavar=('X1', 'Y1', 'X2', 'Y2'),
        help='two points between which it is to pass (m)',
    )
    more = parser.add_argument_group('more about it')
    more.add_argument(
        '--pocket',
        action='append',
        choices=['any', *POCKET_NAMES],
        help='of --pot, may be repeated (any)',
    )
    for name, text in (
        ('leave', 'of --pot: where the cue ball is to rest'),
        ('at', 'of --hit: where it is to touch the ball'),
        ('direction', 'of --hit: where the ball is to go'),
    ):
        more.add_argument(f'--{name}', type=float, nargs=2, metavar=('X', 'Y'), help=text)
    more.add_argument('--radius', type=float, metavar='M', help='how near is near enough (m)')
    more.add_argument('--within-deg', type=float, metavar='DEG', help='the same of --direction')
    limits = parser.add_argument_group('limits, instead of those of the scene')
    limits.add_argument('--first-contact', metavar='BALL', help='that has to be met first')
    for name in asdict(Robot()):
        limits.add_argument(f'--{name.replace("_", "-")}', type=float, metavar='NUMBER')
    add_search_arguments(parser, NORMAL_BUDGET, '')
    parser.add_argument('--json', action='store_true', help='one JSON object, in SI units')
    parser.add_argument(
        '--picture',
        type=Path,
        metavar='FILE.png',
        help='draw the plan, and what noise makes of it',
    )


def run(options: argparse.Namespace) -> int:
    """Plan and print; 1 if there is no plan, 2 if the target makes no sense."""
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
        )
    if result.status == Status.INVALID_REQUEST:
        raise ValueError(result.message)
    print(json.dumps(_as_json(result), allow_nan=False) if options.json else _as_text(result))
    if result.best is None:
        print(f'{result.status.name}: {result.message}', file=sys.stderr)
        return 1
    if options.picture:
        draw_plan(result.best, cloud_of(result.best, result.noise, CLOUD), options.picture)
    return 0


def _target(options: argparse.Namespace) -> dict[str, Any]:
    """Collect what was said of the target, whether it fits together or not."""
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
        'within_deg',
    )
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    if options.gate:
        given['gate'] = options.gate[:2], options.gate[2:]
    if given.get('pocket') and 'any' in given['pocket']:
        given['pocket'] = 'any'
    return given


def _constraints(options: argparse.Namespace) -> dict[str, Any]:
    names = ('first_contact', *asdict(Robot()))
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def _as_text(result: PlanResult) -> str:
    if not result.ranking:
        return f'{result.simulations} strokes simulated in {result.wall_time:.2f} s'
    rows = [
        (
            '',
            'kind',
            'succeeds',
            '95 % sure',
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
                numbers(each.shot.trajectory.rest[:2], 3),
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
        'rest': each.shot.trajectory.rest.tolist(),
    }

"""`billiard-shot plan`: the stroke most likely to reach a target."""

import argparse
from dataclasses import asdict, fields
import json
import math
from pathlib import Path
import sys
import textwrap
from typing import Any

import billiard_shot
from billiard_shot import PlanResult, RankedStroke, save_shot, Scene
from billiard_shot.cli.output import (
    add_format_arguments,
    Column,
    DONE,
    FAILED,
    INTERRUPTED,
    interruptible,
    print_rows,
    reporting,
    wants_text,
    WIDTH,
)
from billiard_shot.cli.shots import (
    add_scene_argument,
    add_search_arguments,
    scene_name,
    selected_noise,
)
from billiard_shot.cli.workers import add_work_arguments, working
from billiard_shot.pictures.plan import draw_plan
from billiard_shot.pictures.view import write_page
from billiard_shot.planning.plan import IN_HAND_PLACES, USUAL_SECONDS
from billiard_shot.planning.problem import BALL_CONSTRAINTS, limits_of
from billiard_shot.planning.result import sample_outcomes
from billiard_shot.planning.search import NORMAL_BUDGET
from billiard_shot.planning.statistics import percent
from billiard_shot.planning.targets import KINDS, target_of
from billiard_shot.scene import Noise, Robot
from billiard_shot.scene.fields import whole
from billiard_shot.scene.player import OFFSETS
from billiard_shot.status import Status
from billiard_shot.table.run.results import POCKET_NAMES

PICTURE_TRIALS = 400  # noisy executions in a picture
LIMITS = {
    'speed_min': 'smallest speed of the cue (m/s)',
    'speed_max': 'largest speed of the cue (m/s)',
    'elevation_min_deg': 'smallest downward angle of the cue (degrees)',
    'elevation_max_deg': 'largest downward angle of the cue (degrees)',
    'azimuth_deg': 'middle of the directions of the cue, counter-clockwise from +x (degrees)',
    'azimuth_half_range_deg': 'how far the directions reach to each side of the middle (degrees)',
    'offset_max': "largest distance of the tip from the ball's middle (ball radii)",
}
PLAN_COLUMNS = (
    Column('rank', ' '),
    Column('success', 'success', '(%)', lambda chance: f'{percent(chance):>5}'),
    Column('interval', '95 % CI', '(%)', lambda ends: ' to '.join(map(percent, ends))),
    Column('trials'),
    Column('a', 'a', '(radii)', '{:+.3f}'.format),
    Column('b', 'b', '(radii)', '{:+.3f}'.format),
    Column('elevation', 'elevation', '(°)', lambda angle: f'{math.degrees(angle) + 0.0:9.2f}'),
    Column('azimuth', 'azimuth', '(°)', lambda angle: f'{math.degrees(angle):8.3f}'),
    Column('speed', 'speed', '(m/s)', '{:.3f}'.format),
    Column('rest'),
    Column('kind', 'kind'),
    Column('warning'),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, target, limits, noise, budget and output."""
    add_scene_argument(parser)
    target = parser.add_argument_group('target: one of these')
    target.add_argument(
        '--pot', nargs='+', metavar='BALL', help='ball to be potted, several, or any'
    )
    target.add_argument('--hit', metavar='BALL', help='ball to be hit first')
    target.add_argument(
        '--safe',
        nargs='+',
        metavar='BALL',
        help='balls of which one is hit first, so that no good direct shot is left; or any',
    )
    target.add_argument(
        '--break',
        nargs='+',
        metavar='BALL',
        help='balls of which one is hit first, so that a ball falls; or any',
    )
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
        ('leave', 'for --pot: point at which the cue ball has to rest (m)'),
        ('at', 'for --hit: point at which the cue ball has to touch the ball (m)'),
        ('direction', 'for --hit: direction in which the ball has to leave, any length'),
    ):
        more.add_argument(f'--{name}', type=float, nargs=2, metavar=('X', 'Y'), help=text)
    more.add_argument(
        '--radius', type=float, metavar='M', help='largest distance from the point (m)'
    )
    more.add_argument(
        '--direction-tolerance-deg',
        type=float,
        metavar='DEG',
        help='largest deviation from --direction (degrees)',
    )
    more.add_argument(
        '--against',
        nargs='+',
        metavar='BALL',
        help='for --safe: balls that the other player may pot (default: any)',
    )
    more.add_argument(
        '--chance',
        type=float,
        metavar='P',
        help='for --safe: largest chance of a direct shot that is left (default: 0.2)',
    )
    more.add_argument(
        '--pots', type=int, metavar='N', help='for --break: how many balls fall (default: 1)'
    )
    more.add_argument(
        '--place',
        choices=IN_HAND_PLACES,
        help='for --pot and --break: the cue ball is in hand, and is put where it is best',
    )
    limits = parser.add_argument_group('limits that replace those of the scene')
    limits.add_argument(
        '--first-contact', nargs='+', metavar='BALL', help='balls of which one must be hit first'
    )
    limits.add_argument('--keep', nargs='+', metavar='BALL', help='balls that must not be potted')
    for field in fields(Robot):
        option = f'--{field.name.replace("_", "-")}'
        limits.add_argument(option, type=float, metavar='NUMBER', help=LIMITS[field.name])
    add_search_arguments(parser, NORMAL_BUDGET, '')
    parser.add_argument(
        '--seconds',
        type=float,
        metavar='S',
        help=f'end the search after this time (default: {USUAL_SECONDS:g}; none with --budget)',
    )
    parser.set_defaults(budget=None)  # to tell whether it is given
    add_format_arguments(parser)
    add_work_arguments(parser)
    files = parser.add_argument_group('files')
    files.add_argument(
        '--rank', type=int, default=1, metavar='N', help='which stroke to write (default: 1)'
    )
    files.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.json',
        help='write the shot of that stroke, as predict does',
    )
    files.add_argument(
        '--view', type=Path, metavar='FILE.html', help='write its page, as view does'
    )
    files.add_argument(
        '--picture',
        type=Path,
        metavar='FILE.png',
        help='draw it, with the outcomes of noisy executions',
    )


def run(options: argparse.Namespace) -> int:
    """Plan, write and print; 1: no plan, 130: after Ctrl+C. ValueError for an invalid request."""
    if options.rank < 1:
        raise ValueError(f'--rank must be at least 1, got {options.rank}')
    scene = Scene.load(scene_name(options))
    noise = selected_noise(options, scene)
    target = target_of(scene, _target(options))
    constraints = _constraints(options)
    limits_of(scene, constraints, noise)
    seconds, budget = options.seconds, options.budget
    if budget is None:
        seconds, budget = seconds or USUAL_SECONDS, NORMAL_BUDGET
    for name, value, least in (('budget', budget, 1), ('seed', options.seed, 0)):
        whole(f'--{name}', value, least)
    with (
        working(options.workers, options.dask) as executor,
        reporting('strokes', budget) as report,
        interruptible() as pressed,
    ):
        result = billiard_shot.plan(
            scene,
            target,
            noise,
            budget,
            options.seed,
            constraints,
            progress=lambda now: report(now.simulations),
            cancel=pressed,
            executor=executor,
            seconds=seconds,
            place=options.place,
        )
    chosen = result.ranking[options.rank - 1 : options.rank]
    for each in chosen:
        _write(each, result.noise, options)
    if options.json:
        print(json.dumps(as_json(result), allow_nan=False))
    elif options.csv or result.ranking:
        _print_ranking(result, options)
    else:
        print(_work(result))
    if result.best is None:
        print(f'{result.status.name}: {result.message}', file=sys.stderr)
        return FAILED
    if not chosen and any((options.output, options.view, options.picture)):
        raise ValueError(
            f'--rank must be at most {len(result.ranking)}, the strokes found, got {options.rank}'
        )
    return INTERRUPTED if result.status is Status.CANCELLED else DONE


def _write(chosen: RankedStroke, noise: Noise, options: argparse.Namespace) -> None:
    """Write the files of a stroke."""
    if options.output:
        save_shot(chosen.shot, options.output)
    if options.view:
        write_page(chosen.shot, options.view, chosen.kind)
    if options.picture:
        outcomes = sample_outcomes(chosen, noise, PICTURE_TRIALS)
        draw_plan(chosen, outcomes, options.picture)


def _target(options: argparse.Namespace) -> dict[str, Any]:
    """Collect the options of the target; `plan` checks them."""
    names = (
        'pot',
        'hit',
        'safe',
        'break',
        'against',
        'chance',
        'pots',
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
    if not given:
        raise ValueError(f'target is missing; give one of --{", --".join(KINDS)}')
    return given


def _constraints(options: argparse.Namespace) -> dict[str, Any]:
    names = (*BALL_CONSTRAINTS, *asdict(Robot()))
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def _print_ranking(result: PlanResult, options: argparse.Namespace) -> None:
    """Print the strokes, the best first, and what the best one does if it is played exactly."""
    if wants_text(options):
        print(textwrap.fill(f'{result.status.name}: {result.message}', WIDTH))
        if result.place:
            x, y = result.place
            print(f'cue ball at ({x:.3f}, {y:.3f}) m')
    rows = [{'rank': rank} | _stroke(each) for rank, each in enumerate(result.ranking, 1)]
    print_rows(PLAN_COLUMNS, rows, options)
    if wants_text(options) and result.best:
        print(textwrap.fill(f'1, played exactly: {result.best.shot.message}', WIDTH))
        if result.best.command != result.best.stroke:
            print(f'1, with the bias corrected: {result.best.command!r}')
        for rank, each in enumerate(result.ranking[1:], 2):
            if each.warning:
                print(textwrap.fill(f'{rank}, warning: {each.warning}', WIDTH))
        if len(result.ranking) > 1:
            print('order: strokes that may be as good as the best one by speed, then the others')
        print(_work(result))


def _work(result: PlanResult) -> str:
    rate = result.simulations / max(result.wall_time, 1e-9)
    return (
        f'{result.simulations} strokes simulated in {result.wall_time:.2f} s, {rate:.0f} a second'
    )


def as_json(result: PlanResult) -> dict[str, Any]:
    """Write a plan as data for JSON."""
    return {
        'status': result.status.name,
        'message': result.message,
        'simulations': result.simulations,
        'wall_time': result.wall_time,
        'noise': asdict(result.noise),
        'place': result.place,
        'ranking': [_stroke(each) for each in result.ranking],
    }


def _stroke(each: RankedStroke) -> dict[str, Any]:
    return {
        'kind': each.kind,
        'success': each.success,
        'interval': list(each.interval),
        'trials': each.trials,
        'warning': each.warning,
        **dict(zip(OFFSETS, each.stroke.offsets, strict=True)),
        'command': dict(zip(OFFSETS, each.command.offsets, strict=True)),
        'normal': list(each.stroke.normal),
        'velocity': list(each.stroke.velocity),
        'rest': each.shot.trajectory.final_position.tolist(),
        'message': each.shot.message,
    }

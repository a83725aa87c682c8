"""`billiard-shot plan`: the stroke most likely to reach a target."""

import argparse
from dataclasses import asdict, dataclass, fields
import json
import math
from pathlib import Path
import sys
import textwrap
from typing import Any, ClassVar

import billiard_shot
from billiard_shot import PlanResult, RankedStroke, save_shot
from billiard_shot.cli import output
from billiard_shot.cli.options import option
from billiard_shot.cli.shots import OfNoise, OfScene, scene_name, selected_noise
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.pictures.plan import draw_plan
from billiard_shot.pictures.view import write_page
from billiard_shot.planning.plan import IN_HAND_PLACES, USUAL_SECONDS
from billiard_shot.planning.problem import limits_of
from billiard_shot.planning.result import sample_outcomes
from billiard_shot.planning.search import NORMAL_BUDGET
from billiard_shot.planning.statistics import percent
from billiard_shot.planning.targets import KINDS, target_of
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.fields import whole_number
from billiard_shot.scene.player import OFFSETS
from billiard_shot.status import Status
from billiard_shot.table.run.results import POCKET_NAMES

PICTURE_TRIALS = 400  # noisy executions in a picture
PLAN_COLUMNS = (
    output.Column('rank', ' '),
    output.Column('success', 'success', '(%)', lambda chance: f'{percent(chance):>5}'),
    output.Column('interval', '95 % CI', '(%)', lambda ends: ' to '.join(map(percent, ends))),
    output.Column('trials'),
    output.Column('a', 'a', '(radii)', '{:+.3f}'.format),
    output.Column('b', 'b', '(radii)', '{:+.3f}'.format),
    output.Column(
        'elevation', 'elevation', '(°)', lambda angle: f'{math.degrees(angle) + 0.0:9.2f}'
    ),
    output.Column('azimuth', 'azimuth', '(°)', lambda angle: f'{math.degrees(angle):8.3f}'),
    output.Column('speed', 'speed', '(m/s)', '{:.3f}'.format),
    output.Column('rest'),
    output.Column('kind', 'kind'),
    output.Column('warning'),
)


@dataclass(frozen=True)
class OfTarget:
    """
    The target.

    Parameters
    ----------
    pot : BALL
        Ball to be potted, several, or any.
    hit : BALL
        Ball to be hit first.
    safe : BALL
        Balls of which one is hit first, so that no good direct shot is left; or any.
    break_ : BALL
        Balls of which one is hit first, so that a ball falls; or any.
    rest : X Y
        Point at which the cue ball has to rest (m).
    pass_ : X Y
        Point that the cue ball has to pass (m).
    gate : X1 Y1 X2 Y2
        Two points between which the cue ball has to pass (m).

    """

    TITLE: ClassVar = 'target: one of these'
    pot: list[str] | None = None
    hit: str | None = None
    safe: list[str] | None = None
    break_: list[str] | None = None
    rest: tuple[float, float] | None = None
    pass_: tuple[float, float] | None = None
    gate: tuple[float, float, float, float] | None = None


@dataclass(frozen=True)
class OfDetails:
    """
    Details of the target.

    Parameters
    ----------
    pocket : str
        Pocket for --pot, may be repeated (default: any).
    leave : X Y
        For --pot: point at which the cue ball has to rest (m).
    at : X Y
        For --hit: point at which the cue ball has to touch the ball (m).
    direction : X Y
        For --hit: direction in which the ball has to leave, any length.
    radius : M
        Largest distance from the point (m).
    direction_tolerance_deg : DEG
        Largest deviation from --direction (degrees).
    against : BALL
        For --safe: balls that the other player may pot (default: any).
    chance : P
        For --safe: largest chance of a direct shot that is left (default: 0.2).
    pots : N
        For --break: how many balls fall (default: 1).
    place : str
        For --pot and --break: the cue ball is in hand, and is put where it is best.

    """

    TITLE: ClassVar = 'details of the target'
    pocket: list[str] | None = option(action='append', nargs=None, choices=['any', *POCKET_NAMES])
    leave: tuple[float, float] | None = None
    at: tuple[float, float] | None = None
    direction: tuple[float, float] | None = None
    radius: float | None = None
    direction_tolerance_deg: float | None = None
    against: list[str] | None = None
    chance: float | None = None
    pots: int | None = None
    place: str | None = option(choices=IN_HAND_PLACES)


@dataclass(frozen=True)
class OfConstraints:
    """
    Limits of the stroke, of the table and of the player.

    Parameters
    ----------
    first_contact : BALL
        Balls of which one must be hit first.
    keep : BALL
        Balls that must not be potted.
    speed_min : NUMBER
        Smallest speed of the cue (m/s).
    speed_max : NUMBER
        Largest speed of the cue (m/s).
    elevation_min_deg : NUMBER
        Smallest downward angle of the cue (degrees).
    elevation_max_deg : NUMBER
        Largest downward angle of the cue (degrees).
    azimuth_deg : NUMBER
        Middle of the directions of the cue, counter-clockwise from +x (degrees).
    azimuth_half_range_deg : NUMBER
        How far the directions reach to each side of the middle (degrees).
    offset_max : NUMBER
        Largest distance of the tip from the ball's middle (ball radii).

    """

    TITLE: ClassVar = 'limits that replace those of the scene'
    first_contact: list[str] | None = None
    keep: list[str] | None = None
    speed_min: float | None = None
    speed_max: float | None = None
    elevation_min_deg: float | None = None
    elevation_max_deg: float | None = None
    azimuth_deg: float | None = None
    azimuth_half_range_deg: float | None = None
    offset_max: float | None = None


@dataclass(frozen=True)
class OfLimitedSearch(OfNoise):
    """
    How long to search.

    Parameters
    ----------
    budget : N
        Largest number of simulated strokes (default: %(BUDGET)d).
    seconds : S
        End the search after this time (default: %(SECONDS)g; none with --budget).

    """

    TITLE: ClassVar = 'search'
    BUDGET: ClassVar = NORMAL_BUDGET
    SECONDS: ClassVar = USUAL_SECONDS
    budget: int | None = whole_number(minimum=1, default=None)
    seconds: float | None = None


@dataclass(frozen=True)
class OfPlanFiles:
    """
    The files.

    Parameters
    ----------
    rank : N
        Which stroke to write (default: %(default)d).
    output : FILE.json
        Write the shot of that stroke, as predict does.
    view : FILE.html
        Write its page, as view does.
    picture : FILE.png
        Draw it, with the outcomes of noisy executions.

    """

    TITLE: ClassVar = 'files'
    rank: int = whole_number(minimum=1, default=1)
    output: Path | None = option('-o')
    view: Path | None = None
    picture: Path | None = None


SEARCH_OPTIONS = OfLimitedSearch(), output.OfFormat(), OfWork()
OPTIONS = OfScene(), OfTarget(), OfDetails(), OfConstraints(), *SEARCH_OPTIONS, OfPlanFiles()


def run(options: argparse.Namespace) -> int:
    """Plan, write and print; 1: no plan, 130: after Ctrl+C. ValueError for an invalid request."""
    scene = Scene.load(scene_name(options))
    noise = selected_noise(options, scene)
    target = target_of(scene, _target(options))
    constraints = _constraints(options)
    limits_of(scene, constraints, noise)
    seconds, budget = options.seconds, options.budget
    if budget is None:
        seconds, budget = seconds or USUAL_SECONDS, NORMAL_BUDGET
    with (
        working(options.workers, options.dask) as executor,
        output.reporting('strokes', budget) as report,
        output.interruptible() as pressed,
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
        return output.FAILED
    if not chosen and any((options.output, options.view, options.picture)):
        raise ValueError(
            f'--rank must be at most {len(result.ranking)}, the strokes found, got {options.rank}'
        )
    return output.INTERRUPTED if result.status is Status.CANCELLED else output.DONE


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
    names = [each.name.rstrip('_') for kind in (OfTarget, OfDetails) for each in fields(kind)]
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    given.pop('place', None)
    if 'gate' in given:
        given['gate'] = options.gate[:2], options.gate[2:]
    if not given:
        raise ValueError(f'target is missing; give one of --{", --".join(KINDS)}')
    return given


def _constraints(options: argparse.Namespace) -> dict[str, Any]:
    names = (each.name for each in fields(OfConstraints))
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def _print_ranking(result: PlanResult, options: argparse.Namespace) -> None:
    """Print the strokes, the best first, and what the best one does if it is played exactly."""
    if output.wants_text(options):
        print(textwrap.fill(f'{result.status.name}: {result.message}', output.WIDTH))
        if result.place:
            x, y = result.place
            print(f'cue ball at ({x:.3f}, {y:.3f}) m')
    rows = [{'rank': rank} | _stroke(each) for rank, each in enumerate(result.ranking, 1)]
    output.print_rows(PLAN_COLUMNS, rows, options)
    if output.wants_text(options) and result.best:
        print(textwrap.fill(f'1, played exactly: {result.best.shot.message}', output.WIDTH))
        if result.best.command != result.best.stroke:
            print(f'1, with the bias corrected: {result.best.command!r}')
        for rank, each in enumerate(result.ranking[1:], 2):
            if each.warning:
                print(textwrap.fill(f'{rank}, warning: {each.warning}', output.WIDTH))
        if len(result.ranking) > 1:
            print('order: the slowest of the best strokes, then the others by their least success')
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

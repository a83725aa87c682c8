"""`billiard-shot rate`: how strong players are, beside people."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
import json
import os
from pathlib import Path
from typing import Any, ClassVar

from billiard_shot import Scene
from billiard_shot.cli.options import positional
from billiard_shot.cli.output import DONE, progress, table
from billiard_shot.cli.shots import OfNoise
from billiard_shot.cli.tournament import append_rack, find_own_modules, read_racks, scene_from
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.game.rack import (
    agent_names,
    check_pairing,
    Pairing,
    play,
    play_racks,
    RackRecord,
)
from billiard_shot.game.rating import ratings, tally
from billiard_shot.game.state import find_game
from billiard_shot.planning.statistics import percent, wilson_interval
from billiard_shot.scene.fields import whole_number

GHOSTS = 'eight_ball_ghost', 'nine_ball_ghost', 'ten_ball_ghost'
TEST, RUNS = 'ten_ball_ghost', 'straight_pool_ghost'
LADDER = 'nine_ball'
RUNGS = tuple(f'player:effort=0.25,plies=1@fargo_{level}' for level in range(400, 900, 100))
TEN_RACKS = 10  # of the test, which has 100 balls
PEOPLE = {  # figures with their sources
    'ghost': 'top professional about 80 %, lower professional 70 %, shortstop 50 to 60 % '
    '(nine-ball; AzBilliards forum, thread 4282109)',
    'ten racks of ten-ball': 'professional from 71, A+ 61 to 65, B+ 51 to 55, C+ 41 to 45, '
    'D+ 30 to 35 balls (D. Alciatore, billiards.colostate.edu, ratings)',
    'TPA': 'world class from .900, professional from .850 '
    '(Accu-Stats; D. Alciatore, billiards.colostate.edu, FAQ on TPA)',
    'rating': 'world class 800; 500 runs out from the first visit in 10 %, 400 in 1 % '
    '(fargorate.com)',
    'straight pool': 'longest run 832, of a player whose mean is about 111 '
    '(azbilliards.com on J. Shaw, January 2025)',
}


@dataclass(frozen=True)
class OfRating:
    """
    The player and the racks.

    Parameters
    ----------
    agent : AGENT
        One of %(AGENTS)s, with options, or a module: it plays against the ghost.
    scene : SCENE
        Table, noise and limits (default: %(default)s).
    racks : N
        Number of racks of each game (default: %(default)d).
    match : FILE.jsonl
        In place of AGENT: racks that `tournament -o` wrote, or `play --state`. All their players
        are rated.
    ladder : FILE.jsonl
        In place of the ghost, AGENT plays the games of nine-ball against players of the levels
        400 to 800 in turn. They are appended to this file, and those in it are not played again.
    json : bool
        Print the numbers as JSON.

    """

    AGENTS: ClassVar = ', '.join(agent_names())
    agent: str | None = positional('?')
    scene: str = 'pool_table'
    racks: int = whole_number(minimum=1, default=20)
    match: list[Path] | None = None
    ladder: Path | None = None
    json: bool = False


OPTIONS = OfRating(), OfNoise(), OfWork(os.cpu_count() or 1)


def run(options: argparse.Namespace) -> int:
    """Play and print. ValueError for an invalid request."""
    if bool(options.agent) == bool(options.match):
        raise ValueError('rate needs either AGENT or --match')
    if options.match and options.ladder:
        raise ValueError('--ladder needs AGENT, not --match')
    if options.match:
        rows = _of_matches(
            [rack for path in options.match for rack in read_racks(path, '--match')]
        )
        print(json.dumps(rows) if options.json else _matches_as_text(rows))
        return DONE
    find_own_modules()
    count, scene = options.racks, scene_from(options)
    if options.ladder:
        rows = _of_matches(_on_ladder(options, scene))
        print(json.dumps(rows) if options.json else _matches_as_text(rows))
        return DONE
    pairings = [Pairing(game, scene, (options.agent,), options.seed) for game in (*GHOSTS, RUNS)]
    for pairing in pairings:
        check_pairing(pairing)
    rows = []
    with working(options.workers, options.dask) as executor:
        for pairing in pairings:
            label = f'racks of {pairing.game}'
            played = progress(play_racks(pairing, range(count), executor), label, count)
            rows.append(_row(str(pairing.game), list(played)))
    print(json.dumps(rows) if options.json else _as_text(rows))
    return DONE


def _on_ladder(options: argparse.Namespace, scene: Scene) -> list[RackRecord]:
    """Play the games of a ladder that its file does not have; return those of the file."""
    path, seed = options.ladder, options.seed
    racks = read_racks(path, '--ladder') if path.exists() else []
    there = {(rack.game, rack.seed, rack.players, rack.number) for rack in racks}
    pairings = [Pairing(LADDER, scene, (options.agent, rung), seed) for rung in RUNGS]
    check_pairing(pairings[0])
    games = [
        (pairings[number % len(RUNGS)], number // len(RUNGS)) for number in range(options.racks)
    ]
    games = [each for each in games if (LADDER, seed, each[0].players, each[1]) not in there]
    with working(options.workers, options.dask) as executor:
        run = map if executor is None else executor.map
        played = run(play, [pairing for pairing, _ in games], [number for _, number in games])
        for rack in progress(played, 'games', len(games)):
            racks.append(rack)
            append_rack(path, rack)
    return racks


def run_outs(racks: Sequence[RackRecord]) -> tuple[int, int]:
    """Count the racks against the ghost that were run out, and the balls of all."""
    wins = sum(rack.winner is not None for rack in racks)
    return wins, sum(rack.state['scores'][0] for rack in racks)


def _row(game: str, racks: Sequence[RackRecord]) -> dict[str, Any]:
    """
    Count the racks that were run out, and the balls.

    The interval of `balls`, the mean of a rack, holds for any distribution: no number from 0 to 1
    has a larger variance than one that is 0 or 1 with the same mean. `run` has the mean run of
    straight pool, with its interval.
    """
    wins, balls = run_outs(racks)
    rules, counted = find_game(game), tally(racks, racks[0].players[0])
    most = rules.goal or len(rules.balls)
    low, high = wilson_interval(balls / most / len(racks), len(racks))
    alone = counted._replace(balls=balls) if game == RUNS and counted.ends else None
    return {
        'game': game,
        'racks': len(racks),
        'wins': wins,
        'interval': wilson_interval(wins, len(racks)),
        'balls': balls / len(racks),
        'balls_interval': (most * low, most * high),
        'tpa': counted.tpa if counted.balls + counted.errors else None,
        'run': alone.mean_run if alone else None,
        'longest': counted.longest,
    }


def _as_text(rows: Sequence[dict[str, Any]]) -> str:
    lines: list[tuple[str, ...]] = [
        ('ghost of', 'run out', 'share (95 % CI)', 'balls a rack', 'TPA (95 % CI)')
    ]
    for row in rows:
        share, low, high = map(percent, (row['wins'] / row['racks'], *row['interval']))
        lines.append(
            (
                row['game'].removesuffix('_ghost').replace('_', '-'),
                f'{row["wins"]} of {row["racks"]}',
                f'{share} % ({low} to {high} %)',
                f'{row["balls"]:.1f}',
                _tpa_in_words(row),
            )
        )
    test, runs = (next(row for row in rows if row['game'] == game) for game in (TEST, RUNS))
    low, high = (TEN_RACKS * each for each in test['balls_interval'])
    balls = TEN_RACKS * test['balls']
    lines += [
        (f'ten racks of ten-ball: {balls:.0f} of 100 balls (95 % CI {low:.0f} to {high:.0f})',),
        (f'runs in straight pool: {_runs_in_words(runs)}',),
    ]
    return table([*lines, *_people('ghost', 'ten racks of ten-ball', 'straight pool', 'TPA')])


def _tpa_in_words(row: dict[str, Any]) -> str:
    return '{:.3f} ({:.3f} to {:.3f})'.format(*row['tpa']) if row['tpa'] else '-'


def _runs_in_words(row: dict[str, Any]) -> str:
    if not row['run']:
        return '-'
    mean, low, high = row['run']
    return f'mean {mean:.1f} ({low:.1f} to {high:.1f}), longest {row["longest"]}'


def _people(*measures: str) -> list[tuple[str]]:
    return [('people',), *((f'{measure}: {PEOPLE[measure]}',) for measure in measures)]


def _of_matches(racks: Sequence[RackRecord]) -> list[dict[str, Any]]:
    """Rate all players of racks; the runs are those of straight pool, None without it."""
    rated, rows = ratings(racks), []
    for name in dict.fromkeys(name for rack in racks for name in rack.players):
        own = [rack for rack in racks if name in rack.players]
        straight = tally([rack for rack in own if rack.game == 'straight_pool'], name)
        rating, whole = rated.get(name), tally(own, name)
        rows.append(
            {
                'player': name,
                'racks': len(own),
                'wins': sum(rack.winner == name for rack in own),
                'balls': whole.balls,
                'errors': whole.errors,
                'tpa': whole.tpa if whole.balls + whole.errors else None,
                'rating': rating.points if rating else None,
                'reach': rating.reach if rating else None,
                'run': straight.mean_run if straight.ends else None,
                'longest': straight.longest,
            }
        )
    return rows


def _matches_as_text(rows: Sequence[dict[str, Any]]) -> str:
    lines: list[tuple[str, ...]] = [('player', 'won', 'TPA (95 % CI)', 'rating (95 % CI)', 'runs')]
    for row in rows:
        rating = '-'
        if row['rating'] is not None:
            rating = f'{row["rating"]:.0f} (± {row["reach"]:.0f})'
        won = f'{row["wins"]} of {row["racks"]}'
        lines.append((row['player'], won, _tpa_in_words(row), rating, _runs_in_words(row)))
    people = 'TPA', 'rating', *(['straight pool'] if any(row['run'] for row in rows) else [])
    return table([*lines, *_people(*people)])

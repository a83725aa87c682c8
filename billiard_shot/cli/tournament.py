"""`billiard-shot tournament`: many racks of a game between two players."""

import argparse
from dataclasses import dataclass, replace
import json
import os
from pathlib import Path
import sys
from typing import Any, ClassVar

from billiard_shot import Scene
from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import DONE, INTERRUPTED, progress
from billiard_shot.cli.shots import OfNoise, selected_noise
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.game.rack import (
    agent_names,
    check_pairing,
    Pairing,
    play_racks,
    RackRecord,
    summary,
)
from billiard_shot.game.state import find_game, game_names
from billiard_shot.planning.statistics import interval_in_words
from billiard_shot.scene.errors import must_be, reason
from billiard_shot.scene.fields import whole_number


@dataclass(frozen=True)
class OfGame:
    """
    The game and the table.

    Parameters
    ----------
    game : GAME
        One of %(GAMES)s.
    scene : SCENE
        Table, noise and limits (default: %(default)s).
    balls : N
        How many balls are racked.

    """

    GAMES: ClassVar = ', '.join(game_names())
    game: str = positional()
    scene: str = 'pool_table'
    balls: int | None = None


def scene_from(options: argparse.Namespace) -> Scene:
    """Load the scene of a game, with the selected noise."""
    scene = Scene.load(options.scene)
    return replace(scene, noise=selected_noise(options, scene))


def find_own_modules() -> None:
    """Let `package.module` name a module in the current folder, too, as in `python -m`."""
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())


@dataclass(frozen=True)
class OfTournament:
    """
    The players, the number of racks, and the output.

    Parameters
    ----------
    players : NAME
        Two of %(AGENTS)s, or modules; one for a game of one player.
    racks : N
        Number of racks (default: %(default)d).
    output : FILE.jsonl
        Append each rack to this file; racks that are in it are not played again.
    json : bool
        Print the summary as JSON.

    """

    AGENTS: ClassVar = ', '.join(agent_names())
    players: list[str] = option(default=('player', 'greedy'))
    racks: int = whole_number(minimum=1, default=100)
    output: Path | None = option('-o')
    json: bool = False


OPTIONS = OfGame(), OfTournament(), OfNoise(), OfWork(os.cpu_count() or 1)


def run(options: argparse.Namespace) -> int:
    """Play and print; after Ctrl+C, the racks so far. ValueError for an invalid request."""
    find_own_modules()
    players = tuple(options.players[: find_game(options.game).players])
    pairing = Pairing(options.game, scene_from(options), players, options.seed, options.balls)
    check_pairing(pairing)
    count, racks = options.racks, _known(options.output, pairing, options.racks)
    numbers = [number for number in range(count) if number not in racks]
    code = DONE
    try:
        with working(options.workers, options.dask) as executor:
            for rack in progress(play_racks(pairing, numbers, executor), 'racks', len(numbers)):
                racks[rack.number] = rack
                if options.output:
                    append_rack(options.output, rack)
    except KeyboardInterrupt:
        if not racks:
            raise
        print(f'interrupted: {len(racks)} of {count} racks are played', file=sys.stderr)
        code = INTERRUPTED
    result = summary(players, [racks[number] for number in sorted(racks)])
    print(json.dumps(result) if options.json else _as_text(result))
    return code


def _known(path: Path | None, pairing: Pairing, count: int) -> dict[int, RackRecord]:
    """Read the racks that a file has; ValueError if they are of another tournament."""
    if path is None or not path.exists():
        return {}
    found = {}
    for rack in read_racks(path, '--output'):
        theirs, ours = ((each.game, tuple(each.players), each.seed) for each in (rack, pairing))
        if theirs != ours:
            raise ValueError(
                f'--output: {path} has racks of game, players and seed {theirs}, not of {ours}'
            )
        if rack.number < count:
            found[rack.number] = rack
    return found


def append_rack(path: Path, rack: RackRecord) -> None:
    """Append a rack to a file, as a line."""
    with path.open('a', encoding='utf-8') as file:
        file.write(json.dumps(rack.to_dict(), allow_nan=False) + '\n')


def read_racks(path: Path, option: str) -> list[RackRecord]:
    """Read the racks that a file has, one a line; ValueError names the option and the line."""
    found = []
    try:
        lines = path.read_text(encoding='utf-8').splitlines()
    except OSError as error:
        raise ValueError(f'{option}: {path}: {reason(error)}') from None
    for number, line in enumerate(lines, 1):
        try:
            found.append(RackRecord.from_dict(json.loads(line)))
        except (KeyError, TypeError, ValueError):
            text = must_be('the record of a rack', line)
            raise ValueError(f'{option}: {path}: line {number} {text}') from None
    return found


def _as_text(result: dict[str, Any]) -> str:
    lines = [f'{result["racks"]} racks, {result["without_winner"]} without a winner']
    for each in result['players']:
        ends = ', '.join(f'{end} {count}' for end, count in each['ends'].items())
        cpu = ' '.join(f'{seconds:.2f}' for seconds in each['cpu'])
        wall = ' '.join(f'{seconds:.2f}' for seconds in each['wall'])
        lines += [
            f'{each["name"]}: {each["wins"]} wins ({interval_in_words(each["interval"])})',
            f'  break and run: {each["break_and_run"]} of {each["broken"]} breaks '
            f'({interval_in_words(each["break_and_run_interval"])})',
            f'  {each["shots"]} shots; visits ended by: {ends}',
            f'  CPU time of a decision, median, 95 %, longest: {cpu} s; by the clock: {wall} s',
        ]
    return '\n'.join(lines)

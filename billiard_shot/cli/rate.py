"""`billiard-shot rate`: how strong a player is, beside people, by racks against the ghost."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
import json
import os
from typing import Any, ClassVar

from billiard_shot import Scene
from billiard_shot.cli.options import positional
from billiard_shot.cli.output import DONE, progress, table
from billiard_shot.cli.tournament import find_own_modules
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.game.rack import agent_names, check_pairing, Pairing, play_racks, RackRecord
from billiard_shot.game.state import find_game
from billiard_shot.planning.statistics import percent, wilson_interval
from billiard_shot.scene.fields import number, whole_number

GHOSTS = 'eight_ball_ghost', 'nine_ball_ghost', 'ten_ball_ghost'
TEST = 'ten_ball_ghost'
TEN_RACKS = 10  # of the test, which has 100 balls
PEOPLE = (  # with the sources of the figures
    (
        'ghost',
        'top professional about 80 %, lower professional 70 %, shortstop 50 to 60 %',
        'AzBilliards forum, thread 4282109',
    ),
    (
        'ten racks of ten-ball',
        'professional from 71, A+ 61 to 65, B+ 51 to 55, C+ 41 to 45, D+ 30 to 35 balls',
        'D. Alciatore, billiards.colostate.edu, ratings',
    ),
)


@dataclass(frozen=True)
class OfRating:
    """
    The player, the table, its noise, and the number of racks.

    Parameters
    ----------
    agent : AGENT
        One of %(AGENTS)s, with options, or a module.
    scene : SCENE
        Table, noise and limits (default: %(default)s).
    noise_scale : K
        Multiplies the noise of the scene (default: %(default)g).
    racks : N
        Number of racks of each game (default: %(default)d).
    seed : S
        Of racks and errors (default: %(default)d).
    json : bool
        Print the numbers as JSON.

    """

    AGENTS: ClassVar = ', '.join(agent_names())
    agent: str = positional()
    scene: str = 'pool_table'
    noise_scale: float = number('', above=0.0, default=1.0)
    racks: int = whole_number(minimum=1, default=20)
    seed: int = whole_number(minimum=0, default=1)
    json: bool = False


OPTIONS = OfRating(), OfWork(os.cpu_count() or 1)


def run(options: argparse.Namespace) -> int:
    """Play and print. ValueError for an invalid request."""
    find_own_modules()
    count, scene = options.racks, Scene.load(options.scene)
    scene = replace(scene, noise=scene.noise.times(options.noise_scale))
    pairings = [Pairing(game, scene, (options.agent,), options.seed) for game in GHOSTS]
    for pairing in pairings:
        check_pairing(pairing)
    rows = []
    with working(options.workers, options.dask) as executor:
        for pairing in pairings:
            label = f'racks of {pairing.game}'
            played = progress(play_racks(pairing, range(count), executor), label, count)
            rows.append(_row(pairing.game, list(played)))
    print(json.dumps(rows) if options.json else _as_text(rows))
    return DONE


def _row(game: str, racks: Sequence[RackRecord]) -> dict[str, Any]:
    """
    Count the racks that were run out, and the balls.

    The interval of `balls`, the mean of a rack, holds for any distribution: no number from 0 to 1
    has a larger variance than one that is 0 or 1 with the same mean.
    """
    wins = sum(rack.winner is not None for rack in racks)
    balls = sum(rack.state['scores'][0] for rack in racks)
    most = len(find_game(game).balls)
    low, high = wilson_interval(balls / most, len(racks))
    return {
        'game': game,
        'racks': len(racks),
        'wins': wins,
        'interval': wilson_interval(wins, len(racks)),
        'balls': balls / len(racks),
        'balls_interval': (most * low, most * high),
    }


def _as_text(rows: Sequence[dict[str, Any]]) -> str:
    lines: list[tuple[str, ...]] = [('ghost of', 'run out', 'share', '95 % CI', 'balls a rack')]
    for row in rows:
        low, high = map(percent, row['interval'])
        lines.append(
            (
                row['game'].removesuffix('_ghost').replace('_', '-'),
                f'{row["wins"]} of {row["racks"]}',
                f'{percent(row["wins"] / row["racks"])} %',
                f'{low} to {high} %',
                f'{row["balls"]:.1f}',
            )
        )
    test = next(row for row in rows if row['game'] == TEST)
    low, high = (TEN_RACKS * each for each in test['balls_interval'])
    balls = TEN_RACKS * test['balls']
    lines += [
        (f'ten racks of ten-ball: {balls:.0f} of 100 balls (95 % CI {low:.0f} to {high:.0f})',),
        ('people',),
        *((f'{measure}: {figures} ({source})',) for measure, figures, source in PEOPLE),
    ]
    return table(lines)

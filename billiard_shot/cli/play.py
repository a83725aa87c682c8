"""`billiard-shot play`: one rack, between players or against a person in the terminal."""

import argparse
import json
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.progress import wait_for_machine_code
from billiard_shot.cli.tournament import add_game_arguments
from billiard_shot.game.game import find_game
from billiard_shot.game.tournament import agent_names, check_pairing, Pairing, play
from billiard_shot.pictures.rack import write_rack
from billiard_shot.scene.values import whole

PERSON = 'person'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for game, players and output."""
    add_game_arguments(parser)
    parser.add_argument(
        '--players',
        nargs='+',
        default=[PERSON, 'player'],
        metavar='NAME',
        help=f'two of {PERSON}, {", ".join(agent_names())}, or modules (default: {PERSON} player)',
    )
    parser.add_argument(
        '--rack', type=int, default=0, metavar='N', help='number of the rack, as of tournaments'
    )
    parser.add_argument(
        '--pages', type=Path, metavar='FOLDER', help='write a page for each shot into this folder'
    )
    parser.add_argument('--json', action='store_true', help='print the record of the rack as JSON')


def run(options: argparse.Namespace) -> int:
    """Play and print; ValueError for an invalid request."""
    number, seed = whole('--rack', options.rack, 0), whole('--seed', options.seed, 0)
    scene = Scene.load(options.scene)
    players = tuple(
        'billiard_shot.cli.person' if name == PERSON else name
        for name in options.players[: find_game(options.game).players]
    )
    pairing = Pairing(options.game, scene, players, seed, options.balls)
    check_pairing(pairing)
    wait_for_machine_code()
    record = play(pairing, number)
    if options.json:
        print(json.dumps(record.to_dict(), allow_nan=False))
    else:
        for shot in record.shots:
            name = record.players[shot.state['player']].rpartition('.')[2]
            why = f' ({shot.reason})' if shot.reason else ''
            print(f'{name}{why}: {shot.text}')
        winner = record.winner.rpartition('.')[2] if record.winner else 'nobody'
        print(f'{winner} wins')
    if options.pages:
        print(write_rack(record, scene, options.pages))
    return 0

"""`billiard-shot play`: a rack between players or persons, or ten racks against the ghost."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
import io
import json
import os
from pathlib import Path
import sys
import tempfile
from typing import ClassVar

from billiard_shot import Scene
from billiard_shot.cli.output import DONE, interruptible
from billiard_shot.cli.person import Quit
from billiard_shot.cli.rate import PEOPLE, run_outs, TEN_RACKS, TEST
from billiard_shot.cli.shots import OfNoise
from billiard_shot.cli.tournament import find_own_modules, OfGame, scene_from
from billiard_shot.game.rack import (
    agent_names,
    agents_of,
    check_pairing,
    find_agent,
    first_record,
    MAX_SHOTS,
    Pairing,
    play_on,
    RackRecord,
    replayed,
)
from billiard_shot.game.state import find_game
from billiard_shot.pictures.rack import write_rack
from billiard_shot.pictures.view import open_page
from billiard_shot.scene.errors import refused
from billiard_shot.scene.fields import whole_number
from billiard_shot.table.run.results import plural

PERSON = 'person'


@dataclass(frozen=True)
class OfPlay:
    """
    The players, the rack, and the output.

    Parameters
    ----------
    players : NAME
        Two of %(PERSON)s, %(AGENTS)s, or modules (default: %(PERSON)s player).
    rack : N
        Number of the rack, as of tournaments.
    state : FILE
        File of the game, written after each shot; if it exists, the game goes on from it.
    pages : FOLDER
        Write a page for each shot into this folder. With GAME %(GHOST)s, ten racks of ten-ball
        against the ghost, it has the racks, and pages of each shot that lost one with the shot
        that `player` would have chosen; by default it is in the user's data.
    browser : bool
        Show the page of each shot in the browser.
    json : bool
        Print the record of the rack as JSON.

    """

    PERSON: ClassVar = PERSON
    GHOST: ClassVar = 'ghost'
    AGENTS: ClassVar = ', '.join(agent_names())
    players: list[str] | None = None
    rack: int = whole_number(minimum=0, default=0)
    state: Path | None = None
    pages: Path | None = None
    browser: bool = False
    json: bool = False


OPTIONS = OfGame(), OfPlay(), OfNoise()


def run(options: argparse.Namespace) -> int:
    """Play and print; ValueError for an invalid request."""
    find_own_modules()
    scene = scene_from(options)
    try:
        if options.game == OfPlay.GHOST:
            _against_the_ghost(scene, options)
        else:
            _play_rack(scene, options)
    except Quit:
        pass
    return DONE


def _play_rack(scene: Scene, options: argparse.Namespace, hint: bool = True) -> RackRecord:
    """
    Play a rack, or go on with it; print, write what is asked for, and return its record.

    A `hint` says how to go on with a game that was interrupted.
    """
    needed = find_game(options.game).players
    given = options.players or [PERSON, 'player'][:needed]
    if len(given) > needed:
        raise refused(given, f'{plural(needed, "name")} for {options.game}', '--players')
    names = tuple(given)
    modules = tuple('billiard_shot.cli.person' if name == PERSON else name for name in names)
    _check_streams(options, talks_to_a_person=PERSON in names)
    pairing = Pairing(options.game, scene, modules, options.seed, options.balls)
    check_pairing(pairing)
    record = replace(first_record(pairing, options.rack), players=names)
    if options.state and options.state.exists():
        record = _continued(options.state, record)
    talks = PERSON in names or not options.json
    if talks:
        _tell(record)
    try:
        for latest in play_on(record, scene, agents_of(pairing, record.number)):
            record = latest
            if options.state:
                record.save(options.state)
            if talks:
                _tell(record)
            if options.browser:
                _show_last_shot(record, scene)
    except KeyboardInterrupt:
        if hint:
            _keep(record, options.state)
        _finish(record, scene, options)
        raise
    _finish(record, scene, options)
    return record


def _against_the_ghost(scene: Scene, options: argparse.Namespace) -> None:
    """Go on with ten racks that are kept in a folder; show a better shot for each that lost."""
    own = options.pages or _data() / '-'.join(
        [Path(options.scene).stem, options.noise or 'noise', f'{options.noise_scale:g}']
    )
    own.mkdir(parents=True, exist_ok=True)
    racks = [RackRecord.load(path) for path in sorted(own.glob('rack-*.json'))]
    racks = [rack for rack in racks if rack.state['over']]
    end = TEN_RACKS * (len(racks) // TEN_RACKS + 1)
    while len(racks) < end:
        if racks:
            print(_score(racks))
        name = f'rack-{len(racks) + 1:04d}'
        new = {'game': TEST, 'rack': len(racks), 'state': own / f'{name}.json', 'pages': None}
        rack = _play_rack(scene, argparse.Namespace(**{**vars(options), **new}), hint=False)
        racks.append(rack)
        if rack.winner is None:
            print(_show_better(rack, scene, own / name))
    print(_score(racks))


def _data() -> Path:
    """Return the folder of the user's data."""
    root = os.environ.get('XDG_DATA_HOME') or '~/.local/share'
    return Path(root).expanduser() / 'billiard_shot'


def _show_better(rack: RackRecord, scene: Scene, folder: Path) -> str:
    """Write pages of the last shot and of the shot of `player`, with the same errors."""
    last = rack.shots[-1]
    there = replace(rack, shots=(), state=last.state)
    (better,) = next(play_on(there, scene, [find_agent('player')(scene, rack.seed)])).shots
    better = replace(better, reason=f'better: {better.reason}')
    page = write_rack(replace(rack, shots=(last, better)), scene, folder)
    return f'{better.reason} ({better.text}); pages: {page}'


def _score(racks: Sequence[RackRecord]) -> str:
    """Write a line for each ten racks against the ghost, and one with the figures of people."""
    lines = []
    for first in range(0, len(racks), TEN_RACKS):
        ten = racks[first : first + TEN_RACKS]
        won, balls = run_outs(ten)
        lines.append(
            f'racks {first + 1} to {first + len(ten)}: {won} run out, '
            f'{balls} of {len(ten) * len(find_game(TEST).balls)} balls'
        )
    return '\n'.join([*lines, PEOPLE['ten racks of ten-ball']])


def _check_streams(options: argparse.Namespace, *, talks_to_a_person: bool) -> None:
    """Raise ValueError if a game could not be asked for, read, or written."""
    if options.pages and options.pages.exists() and not options.pages.is_dir():
        raise ValueError(f'--pages must be a folder, got the file {options.pages}')
    if options.state and options.state.exists() and not options.state.is_file():
        raise ValueError(f'--state must be a file, got {options.state}')
    if talks_to_a_person:
        if sys.stdin is None:
            raise ValueError('--players: person needs the standard input, which is closed')
        if isinstance(sys.stdin, io.TextIOWrapper):
            sys.stdin.reconfigure(errors='replace')  # a stray byte is a wrong line, not the end


def _continued(path: Path, new: RackRecord) -> RackRecord:
    """Load the record of a game; ValueError if it is not one that the command asks for."""
    record = RackRecord.load(path)
    for what, asked, found in (
        ('game', new.game, record.game),
        ('players', new.players, record.players),
        *((size, new.state[size], record.state[size]) for size in ('length', 'width', 'radius')),
    ):
        if asked != found:
            raise ValueError(f'--state: {path} is a game with {what} {found}, not {asked}')
    return record


def _tell(record: RackRecord) -> None:
    """Print the last shot; and, between persons, who is next."""
    names = _names(record)
    if record.shots:
        shot = record.shots[-1]
        why = f' ({shot.reason})' if shot.reason else ''
        print(f'{names[shot.state["player"]]}{why}: {shot.text}')
    if record.players.count(PERSON) > 1 and not record.state['over']:
        print(f'{names[record.state["player"]]} is next')


def _names(record: RackRecord) -> list[str]:
    """Name the players; a person who is the only one is `you`."""
    names = [
        'you' if name == PERSON else name.partition(':')[0].rpartition('.')[2]
        for name in record.players
    ]
    alike = len({*names}) < len(names)
    return [f'player {number}' for number in range(len(names))] if alike else names


def _wins(name: str) -> str:
    return f'{name} win{"" if name == "you" else "s"}'


def _show_last_shot(record: RackRecord, scene: Scene) -> None:
    """Open the page of the last shot in the browser, if the cue ball was struck."""
    for _, shot in replayed(replace(record, shots=record.shots[-1:]), scene):
        if not shot.status.refused:
            open_page(shot)


def _keep(record: RackRecord, path: Path | None) -> None:
    """Keep an interrupted game in a file, and say how to go on."""
    if not record.shots:
        return
    if path is None:
        path = Path(tempfile.mkdtemp(prefix='billiard_shot-')) / f'{record.game}.json'
        record.save(path)
    print(f'\nto go on with this game: the same command with --state {path}', file=sys.stderr)


def _finish(record: RackRecord, scene: Scene, options: argparse.Namespace) -> None:
    """Print who has won, or the record; write the pages."""
    if options.json:
        print(json.dumps(record.to_dict(), allow_nan=False))
    elif record.state['over'] or len(record.shots) >= MAX_SHOTS:
        winner = record.state.get('winner')
        print('nobody wins' if winner is None else _wins(_names(record)[winner]))
    if options.pages and record.shots:
        # Python drops errors in callbacks of `weakref`. Matplotlib has many: Ctrl+C could be lost.
        with interruptible() as pressed:
            page = write_rack(record, scene, options.pages, pressed)
        if pressed():
            raise KeyboardInterrupt
        print(page)

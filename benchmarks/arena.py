"""
Games in the simulator of others: eight-ball in pooltool 0.6.0, with the scene that a fit makes.

    python benchmarks/arena.py FOLDER [--count N] [--seconds S] [--write] [--no-play]

Needs the extra `pooltool`. FOLDER keeps the fitted scene and the racks, which are not made again;
no rack begins after S seconds. `--write` writes the section of docs/games.md.
"""

import argparse
from dataclasses import replace
import json
from pathlib import Path
from time import process_time

from levels import DOCS, known
import numpy as np
from tools.processes import results_of
from tools.timing import Report

from billiard_shot import calibrate, predict, Scene, Stroke
from billiard_shot.game import Call, find_game, judge, Pairing, State
from billiard_shot.game.pooltool import Pooltool
from billiard_shot.game.rack import agents_of, first_record, play_rack, scene_of
from billiard_shot.planning.statistics import percent, wilson_interval
from billiard_shot.scene.player import NOISES

HEADING = '## Another simulator\n'
RULES = str(DOCS / 'examples' / 'restored.py')
TABLE, PLAYERS = 'seven_foot', ('player:effort=0.5', 'greedy')
RACKS = 'racks.jsonl'
AGAIN = 5  # new errors with which strokes are played again
GOAL, MOST = 95.0, 2.0  # wins [%]; difference of stated and kept chances [points]


def fitted(folder):
    """Return the scene that fits pooltool, and the description of its fit."""
    path, facts = folder / 'scene.yaml', folder / 'fit.json'
    if not facts.exists():
        began = process_time()
        found = calibrate(Pooltool().recorded, replace(Scene.load(TABLE), balls={}))
        found.save(path)
        fit = {'state': found.state, 'notes': found.notes, 'cpu': process_time() - began}
        facts.write_text(json.dumps(fit))
    return Scene.load(path), json.loads(facts.read_text())


def play_one(folder, number):
    """
    Play a rack; then play the strokes of the first player again.

    Returns
    -------
    dict
        `rack`, and `shots`: for each stroke in play that was to pot a ball, its stated chance, how
        often it kept the turn with new errors, and how far the cue ball rests from its forecast
        without errors [m], or None if it falls.

    """
    table, game, (scene, _) = Pooltool(), find_game(RULES), fitted(folder)
    theirs = replace(table.scene, noise=scene.noise, robot=scene.robot)
    pairing = Pairing(RULES, scene, PLAYERS)
    agents = [agents_of(pairing, number)[0], agents_of(replace(pairing, scene=theirs), number)[1]]
    record = first_record(pairing, number)
    rack = play_rack(record, scene, agents, table.foreign, game)
    draw, shots = np.random.default_rng([3, number]), []
    for shot in rack.shots:
        state = State.from_dict(shot.state, game)
        if state.player or state.phase == 'break' or not shot.call['ball']:
            continue
        there, stroke = scene_of(scene, state), Stroke.from_offsets(*shot.offsets)
        kept = 0
        for _ in range(AGAIN):
            ruling = judge(state, Call(**shot.call), table.foreign(there, stroke, draw))
            after = ruling.state
            kept += after.winner == 0 if after.over else ruling.legal and after.player == 0
        exact = table.foreign(replace(there, noise=NOISES['none']), stroke, draw).places
        foreseen = predict(there, stroke).run.places_left
        off = np.inf
        if 'cue' in exact and 'cue' in foreseen:
            off = float(np.hypot(*np.subtract(exact['cue'], foreseen['cue'])))
        shots.append((shot.success, kept, off if np.isfinite(off) else None))
    return {'rack': rack.to_dict(), 'shots': shots}


def play_missing(folder, count, seconds):
    """Play the racks that are not in the folder."""
    path = folder / RACKS
    there = {each['rack']['number'] for each in known(path)}
    missing = [(folder, number) for number in range(count) if number not in there]
    for _, played in results_of(play_one, missing, seconds):
        with path.open('a') as file:
            file.write(json.dumps(played) + '\n')


def measured(played):
    """Return wins, racks, shots, stated minus kept with its reach [points], places missed [m]."""
    wins = sum(each['rack']['state']['winner'] == 0 for each in played)
    shots = [shot for each in played for shot in each['shots']]
    over = np.array([100.0 * (stated - kept / AGAIN) for stated, kept, _ in shots])
    reach = 1.96 * over.std(ddof=1) / np.sqrt(len(over))
    off = np.quantile([off for *_, off in shots if off is not None], [0.5, 0.9])
    return wins, len(played), len(shots), over.mean(), reach, off


def with_section(page, fit, cushion, found):
    """Write the section of docs/games.md anew."""
    wins, racks, shots, over, reach, off = found
    middle, most = 100.0 * off
    low, high = map(percent, wilson_interval(wins, racks))
    before, _, rest = page.partition(HEADING)
    return f"""{before}{HEADING}
Written by `benchmarks/arena.py --write`: eight-ball in pooltool 0.6.0, with its cue, cushions and
balls. A foul [restores the table](examples/restored.py), groups are given, and nothing is called.
`{PLAYERS[0]}` plans with the scene that `calibrate` fitted to pooltool in
{fit['cpu']:.0f} CPU s ({fit['state']}; the cushion `{cushion}` won). `{PLAYERS[1]}` plans with
pooltool's own numbers. Both have the noise and the limits of `{TABLE}`.

| quantity | measured (95 %) |
|---|---|
| racks won | {wins} of {racks} ({low}–{high} %) |
| stated minus kept, {shots} pots, {AGAIN} new errors each | {over:.1f} ± {reach:.1f} points |
| cue ball at rest from its forecast without errors, median, 90 % | {middle:.1f}, {most:.0f} cm |

## {rest.partition('## ')[2]}"""


def main():
    """Fit, play, print, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('folder', type=Path)
    parser.add_argument('--count', type=int, default=2)
    parser.add_argument('--seconds', type=float, default=1e9)
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--no-play', action='store_true')
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    report = Report('Arena')
    scene, fit = fitted(folder)
    if not options.no_play:
        play_missing(folder, options.count, options.seconds)
    found = measured(known(folder / RACKS))
    wins, racks, shots, over, reach, (middle, most) = found
    most_wins = 100.0 * wilson_interval(wins, racks)[1]
    report.row(f'won: {wins} of {racks}, upper end of 95 %', most_wins, '%', -GOAL)
    report.row(f'stated minus kept, {shots} pots, lower end', over - reach, 'points', MOST)
    report.row('the cue ball at rest from its forecast, median', 100.0 * middle, 'cm')
    report.row('the same, 90 %', 100.0 * most, 'cm')
    if options.write:
        page, cushion = DOCS / 'games.md', scene.table.cushion.model
        text = with_section(page.read_text('utf-8'), fit, cushion, found)
        page.write_text(text, encoding='utf-8')
    report.end()


if __name__ == '__main__':
    main()

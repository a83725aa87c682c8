"""
Games: how often players clear tables and win racks, and how surely they state their chances.

    python benchmarks/games.py [--racks FOLDER] [--count N] [--full] [--write] [--no-play]

Racks are appended to files in FOLDER, and are not played again. `--count` is the largest number of
racks of each series, `--full` plays them all, which takes hours. `--write` writes docs/games.md
and its picture from the racks in FOLDER.
"""

import argparse
import json
from pathlib import Path
from tempfile import mkdtemp
from typing import NamedTuple

import numpy as np
from tools.processes import results_of
from tools.timing import machine, Report

from billiard_shot import predict_batch, Scene
from billiard_shot.game import Call, Pairing, play, State, summary
from billiard_shot.game.rack import (
    RackRecord,
    replayed,
    scene_of,
)
from billiard_shot.game.valuation import rule_on
from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.rack import draw_panel, PANEL_SIZE
from billiard_shot.planning.statistics import percent, wilson_interval

DOCS = Path(__file__).resolve().parent.parent / 'docs'
NINE_FOOT, SEVEN_FOOT = 'pool_table', 'seven_foot'
MEDIAN, MOST = 1.0, 3.0  # s of CPU time of a decision: median, and 95 %
AGAIN = 200  # new errors with which strokes are played again
PANELS_PER_ROW = 4  # of the picture of a rack
FEW = 30  # shots of a bin of stated chances: with fewer its interval is too wide to say anything


class Series(NamedTuple):
    """Racks of one kind: game, table, players, balls; how many are played; the share to reach."""

    game: str
    scene: str
    players: tuple[str, ...]
    balls: int | None
    full: int
    goal: float = 0.0


PRACTICE = {
    f'practice-{balls}': Series('practice', NINE_FOOT, ('player',), balls, 60, goal)
    for balls, goal in ((1, 0.97), (3, 0.97), (5, 0.95), (8, 0.92), (15, 0.85))
}
GAMES = {
    f'{game}-greedy': Series(game, SEVEN_FOOT, ('player', 'greedy'), None, 200, 0.85)
    for game in ('eight_ball', 'nine_ball')
}
GHOST = {
    game: Series(game, SEVEN_FOOT, ('player',), None, 100, 0.8)
    for game in ('eight_ball_ghost', 'nine_ball_ghost', 'ten_ball_ghost')
}
ABLATION = {
    f'practice-8-{name}': Series('practice', NINE_FOOT, (player,), 8, 60)
    for name, player in (
        ('double', 'player:effort=2'),
        ('half', 'player:effort=0.5'),
        ('one-ply', 'player:plies=1'),
        ('no-leave', 'player:plies=0'),
    )
}
# What stands between them on the page is not written here: trials by hand, and the arena.
KEPT, STATED = '## Trials\n', '## Stated and measured chances'
SERIES = PRACTICE | GAMES | GHOST | ABLATION


def play_one(key, number):
    """Play a rack of a series."""
    game, scene, players, balls, *_ = SERIES[key]
    return play(Pairing(game, Scene.load(scene), players, balls=balls), number)


def known(folder):
    """Read the racks of all series that are in a folder."""
    found = {}
    for key in SERIES:
        path = folder / f'{key}.jsonl'
        lines = path.read_text().splitlines() if path.exists() else []
        racks = [RackRecord.from_dict(json.loads(line)) for line in lines]
        found[key] = sorted(racks, key=lambda rack: rack.number)
    return found


def play_missing(folder, count):
    """Play the racks that are not in the folder, a rack of each series in turn."""
    there = {key: {rack.number for rack in racks} for key, racks in known(folder).items()}
    missing = [
        (key, number)
        for number in range(max(series.full for series in SERIES.values()))
        for key, series in SERIES.items()
        if number < min(count, series.full) and number not in there[key]
    ]
    for (key, _), rack in results_of(play_one, missing):
        with (folder / f'{key}.jsonl').open('a') as file:
            file.write(json.dumps(rack.to_dict()) + '\n')


def first_player(racks):
    """Summarize the racks of the first player, and check that no move was illegal."""
    players = summary(racks[0].players, racks)['players']
    for player in players:
        assert 'illegal' not in player['ends'], player
    return players[0]


def breaks(racks, player):
    """Count the breaks of a player, and those that kept the turn."""
    first = [rack.shots[0] for rack in racks if rack.shots]
    own = [
        shot
        for shot, rack in zip(first, racks, strict=True)
        if rack.players[shot.state['player']] == player
    ]
    return len(own), sum(shot.kept or shot.end == 'won' for shot in own)


def calibration(racks):
    """Yield deciles of the stated chances: mean, shots with a scene, which kept the turn."""
    shots = [
        (shot, SERIES[key].scene)
        for key in racks
        for rack in racks[key]
        for shot in rack.shots
        if shot.success is not None and rack.players[shot.state['player']].startswith('player')
    ]
    stated = np.array([shot.success for shot, _ in shots])
    decile = np.minimum((10.0 * stated).astype(int), 9)
    for each in np.unique(decile).tolist():
        inside = [shots[i] for i in np.flatnonzero(decile == each)]
        came = sum(shot.kept or shot.end == 'won' for shot, _ in inside)
        yield float(stated[decile == each].mean()), inside, came


def again(shot, scene):
    """Return how often a stroke keeps the turn with new errors, by exact predictions."""
    state, errors = State.from_dict(shot.state), np.random.default_rng(1)
    there = scene_of(Scene.load(scene), state)
    offsets = there.noise.sample(shot.offsets, AGAIN, errors, there.ball.radius)
    played = predict_batch(there, offsets=offsets)
    calls = [Call(**shot.call)] * AGAIN
    return rule_on(state, calls, played).keeps(state.player).mean()


def report_on(racks):
    """Print the numbers, and whether they reach the goals."""
    report = Report('Games')
    decisions = []
    for key, series in SERIES.items():
        if not racks[key]:
            continue
        player = first_player(racks[key])
        won, count = player['wins'], len(racks[key])
        high = wilson_interval(won, count)[1]
        report.row(
            f'{key}: {won} of {count}, upper end of the 95 % interval',
            100.0 * high,
            '%',
            -100.0 * series.goal if series.goal else None,
        )
        if key not in ABLATION:
            decisions += [
                shot.cpu
                for rack in racks[key]
                for shot in rack.shots
                if rack.players[shot.state['player']] == 'player' and shot.success is not None
            ]
    median, most = np.quantile(decisions, [0.5, 0.95])
    report.row('CPU time of a decision, median', median, 's', MEDIAN)
    report.row('the same, 95 %', most, 's', MOST)
    report.end()


def share(count, total):
    """Write a share with its interval."""
    low, high = (percent(end) for end in wilson_interval(count, total))
    return f'{count} of {total} ({low}–{high} %)'


def as_page(racks):
    """Write docs/games.md."""
    lines = [
        '# Games, measured',
        '',
        'Written by `benchmarks/games.py --write`, from racks on',
        f'{machine()}.',
        'The noise is that of the computer pool tournaments. Intervals are Wilson intervals of',
        '95 %; CPU times those of decisions, median and 95 %. [Levels](levels.md) are those of',
        'people.',
        '',
        '## Practice',
        '',
        '`player`, cue ball in hand on a nine-foot table with random balls, until a stroke pots',
        'nothing.',
        '',
        '| balls | cleared | goal | CPU time (s) |',
        '|---|---|---|---|',
    ]
    for key, series in PRACTICE.items():
        if racks[key]:
            player = first_player(racks[key])
            lines.append(
                f'| {series.balls} | {share(player["wins"], len(racks[key]))} | '
                f'{percent(series.goal)} % | {times(player)} |'
            )
    lines += [
        '',
        '## Racks',
        '',
        'On a seven-foot table. A break keeps the turn if it pots a ball without a foul. Run-outs',
        'and breaks are those of all players with the first name. The rows of one player are',
        'racks against the [ghost](playing.md).',
        '',
        '| series | won | broken and run out | break kept the turn |',
        '|---|---|---|---|',
    ]
    for key, series in GAMES.items():
        if racks[key]:
            player, count = first_player(racks[key]), len(racks[key])
            own = [
                each
                for each in summary(series.players, racks[key])['players']
                if each['name'] == series.players[0]
            ]
            runs, broken = (sum(each[k] for each in own) for k in ('break_and_run', 'broken'))
            made, kept = breaks(racks[key], series.players[0])
            name = f'`{series.game}`: `{series.players[0]}`, `{series.players[1]}`'
            lines.append(
                f'| {name} | {share(player["wins"], count)} | {share(runs, broken)} | '
                f'{share(kept, made)} |'
            )
    for key, series in GHOST.items():
        if racks[key]:
            player = first_player(racks[key])
            lines.append(
                f'| `{series.game}`: `{series.players[0]}` | '
                f'{share(player["wins"], len(racks[key]))} | | |'
            )
    lines += [
        '',
        '## What the parts contribute',
        '',
        'Practice with 8 balls: the same tables and errors for each row.',
        '',
        '| player | cleared | CPU time (s) |',
        '|---|---|---|',
    ]
    for key in ('practice-8', *ABLATION):
        if racks[key]:
            player = first_player(racks[key])
            lines.append(
                f'| `{SERIES[key].players[0]}` | {share(player["wins"], len(racks[key]))} | '
                f'{times(player)} |'
            )
    kept = (DOCS / 'games.md').read_text('utf-8').partition(KEPT)[2].partition(STATED)[0]
    lines += [
        '',
        KEPT + kept + STATED,
        '',
        'Shots of these racks, by deciles of the stated chance to keep the turn, if a decile',
        f'has {FEW} shots or more. The last column: the same strokes with {AGAIN} new errors',
        'each, by exact predictions.',
        '',
        '| stated | kept the turn | with new errors |',
        '|---|---|---|',
    ]
    for stated, shots, came in calibration(racks):
        if len(shots) < FEW:
            continue
        new = ''
        if stated < 0.9:  # above that nearly all shots are the same, and there are thousands
            new = f'{percent(np.mean([again(*each) for each in shots]))} %'
        lines.append(f'| {percent(stated)} % | {share(came, len(shots))} | {new} |')
    return '\n'.join([*lines, *drawn(racks), ''])


def draw_rack(record, scene, path):
    """Draw the strokes of a rack from above, one panel for each."""
    shots = list(replayed(record, scene))
    rows = -(-len(shots) // PANELS_PER_ROW)
    figure = new_figure(PANEL_SIZE[0] * PANELS_PER_ROW, PANEL_SIZE[1] * rows)
    panels = figure.subplots(rows, PANELS_PER_ROW, squeeze=False).ravel()
    for number, (axes, (played, shot)) in enumerate(zip(panels, shots, strict=False), 1):
        draw_panel(axes, shot)
        ball = played.call.get('ball')
        what = f'ball {ball}' if ball else played.reason.partition(':')[0]
        axes.set_title(f'{number}. {what}', fontsize='small', loc='left')
    for axes in panels[len(shots) :]:
        axes.set_axis_off()
    save(figure, path)


def drawn(racks):
    """Draw a rack of eight-ball: the first one that the breaker ran out, or any."""
    candidates = racks['eight_ball-greedy']
    if not candidates:
        return []
    rack = max(candidates, key=lambda rack: all(shot.state['player'] == 0 for shot in rack.shots))
    draw_rack(rack, Scene.load(SEVEN_FOOT), DOCS / 'figures' / 'games-rack.png')
    return [
        '',
        '## A rack',
        '',
        f'Rack {rack.number} of eight-ball, `{rack.players[0]}` against `{rack.players[1]}`:',
        f'{rack.winner} wins.',
        '',
        '![The strokes of the rack from above](figures/games-rack.png)',
    ]


def times(player):
    """Write the CPU time of decisions: median and 95 %."""
    return f'{player["cpu"][0]:.2f}, {player["cpu"][1]:.2f}'


def main():
    """Play, print, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--racks', type=Path)
    parser.add_argument('--count', type=int, default=2)
    parser.add_argument('--full', action='store_true')
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--no-play', action='store_true')
    options = parser.parse_args()
    folder = options.racks or Path(mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    if not options.no_play:
        play_missing(folder, 10**9 if options.full else options.count)
    racks = known(folder)
    if options.write:
        (DOCS / 'games.md').write_text(as_page(racks), encoding='utf-8')
    report_on(racks)


if __name__ == '__main__':
    main()

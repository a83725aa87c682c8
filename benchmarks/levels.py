"""
Noise levels: how often a player runs out by the size of its errors, and the levels that follow.

    python benchmarks/levels.py [--racks FILE] [--count N] [--seconds S] [--write] [--no-play]
        [--matches FILE ...]

Racks are appended to FILE, and are not played again. `--count` is the number of racks of each
point, and no rack is begun after S seconds. `--write` writes docs/levels.md from the racks, with
the ratings of the games that `billiard-shot tournament -o` wrote to the FILEs of `--matches`.

A rack is not played once. Each stroke is played with many new errors. The share that keeps the
turn is a factor of the chance of the rack, which goes on after one of the strokes that kept it.
The mean of these products is the probability to run out, without a bias; of a small probability,
such a rack says more than one that is won or lost.
"""

import argparse
from dataclasses import replace
import json
from pathlib import Path
from tempfile import mkdtemp
from time import process_time
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from tools.processes import results_of
from tools.timing import machine, Report

from billiard_shot import predict, predict_batch, Scene, Stroke
from billiard_shot.game.rack import (
    agents_of,
    decision_of,
    first_record,
    Pairing,
    RackRecord,
    scene_of,
    simulated,
)
from billiard_shot.game.rating import ratings, tally
from billiard_shot.game.referee import choose, judge
from billiard_shot.game.state import State
from billiard_shot.game.valuation import rule_on
from billiard_shot.planning.statistics import percent, wilson_interval
from billiard_shot.scene.player import LEVELS, NOISES

DOCS = Path(__file__).resolve().parent.parent / 'docs'
TABLE, PLAYER = 'seven_foot', 'player:effort=0.5'
ERRORS = 40  # new errors of each stroke
RARE = 0.003  # a rack whose chance falls below goes on with the probability chance / RARE
RESAMPLES = 1000  # of the racks, for intervals
RATINGS = 400, 500, 600, 700, 800
IN_WORDS = {'eight_ball': 'first visit', 'nine_ball_ghost': 'ghost'}


class Measure(NamedTuple):
    """How often a level runs out, of people: rating, game, share, source."""

    rating: int
    game: str
    share: float
    source: str


FARGO = 'fargorate.com, the scale'
PEOPLE = (
    Measure(400, 'eight_ball', 0.01, FARGO),
    Measure(500, 'eight_ball', 0.10, FARGO),
    Measure(800, 'nine_ball_ghost', 0.80, 'AzBilliards forum, thread 4282109'),
)
SCALES = {'eight_ball': (2.0, 2.5, 3.0, 4.5), 'nine_ball_ghost': (0.35, 0.7)}


def chance_of_rack(game: str, scale: float, number: int) -> dict[str, float | str | None]:
    """
    Estimate the chance that the first visit after the break runs out.

    Parameters
    ----------
    game : str
        Between equal players, or against the ghost.
    scale : float
        Factor on the noise of tournaments.
    number : int
        Of the rack.

    Returns
    -------
    dict
        `game`, `scale`, `number`, `chance`, and `cpu`, the time that it took [s]. The chance is
        None if the break decides the rack.

    """
    began = process_time()
    scene = Scene.load(TABLE)
    scene = replace(scene, noise=scene.noise.times(scale))
    players = (PLAYER,) if game.endswith('_ghost') else (PLAYER, PLAYER)
    pairing = Pairing(game, scene, players)
    agents, draw = agents_of(pairing, number), np.random.default_rng([2, number])
    state = State.from_dict(first_record(pairing, number).state)
    chance, shooter = 1.0, None
    while not state.over and chance > 0.0:
        seen, decision, refusal = decision_of(agents[state.player], state)
        assert not refusal, refusal
        there = scene_of(scene, seen)
        if decision.choice:
            state = choose(seen, decision.choice)
        elif seen.phase == 'break':
            assert decision.stroke
            state = judge(seen, decision.call, simulated(there, decision.stroke, draw)).state
        elif decision.stroke is None:
            chance = 0.0
        else:
            shooter = seen.player if shooter is None else shooter
            offsets = scene.noise.sample(decision.stroke, ERRORS, draw, scene.ball.radius)
            calls = [decision.call] * ERRORS
            ruled = rule_on(seen, calls, predict_batch(there, offsets=offsets))
            kept = np.flatnonzero(ruled.keeps(shooter))
            chance *= len(kept) / ERRORS
            if chance > 0.0:
                shot = predict(there, Stroke.from_offsets(*offsets[kept[0]].tolist()))
                state = judge(seen, decision.call, shot).state
                if not (state.player == shooter and (not state.over or state.winner == shooter)):
                    chance = 0.0  # the referee sees more than rulings of batches
            if 0.0 < chance < RARE:
                chance = RARE if draw.random() < chance / RARE else 0.0
    if shooter is None:  # the break won, or was a foul that ended the rack
        chance = None
    elif state.winner != shooter:
        chance = 0.0
    took = process_time() - began
    return {'game': game, 'scale': scale, 'number': number, 'chance': chance, 'cpu': took}


def known(path):
    """Read the racks in a file."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def play_missing(path, count, seconds):
    """Play the racks that are not in the file, a rack of each point in turn."""
    there = {(rack['game'], rack['scale'], rack['number']) for rack in known(path)}
    points = [(game, scale) for game, scales in SCALES.items() for scale in scales]
    missing = [
        (*point, number)
        for number in range(count)
        for point in points
        if (*point, number) not in there
    ]
    for _, rack in results_of(chance_of_rack, missing, seconds):
        with path.open('a') as file:
            file.write(json.dumps(rack) + '\n')


def points_of(racks, game):
    """Return the logarithms of the scales, and the chances, of the racks of a game."""
    rows = [
        (np.log(rack['scale']), rack['chance'])
        for rack in racks
        if rack['game'] == game and rack['chance'] is not None
    ]
    return np.array(rows).reshape(-1, 2)


def logistic(points):
    """Fit logit(chance) = a + b ln(scale) by the largest likelihood; return a and b."""

    def loss(line):
        fitted = line[0] + line[1] * points[:, 0]
        return np.sum(np.logaddexp(0.0, fitted) - points[:, 1] * fitted) + 1e-4 * line[1] ** 2

    return minimize(loss, (0.0, -2.0)).x


def scale_at(points, share):
    """Return the scale at which a share of racks is run out."""
    a, b = logistic(points)
    return np.exp((np.log(share / (1.0 - share)) - a) / b)


def resampled(points, draw):
    """Draw as many racks of each scale, with repetitions."""
    parts = [points[points[:, 0] == scale] for scale in np.unique(points[:, 0])]
    return np.concatenate([part[draw.integers(len(part), size=len(part))] for part in parts])


def fitted_levels(racks):
    """
    Fit the scale of each rating.

    Returns
    -------
    dict
        By rating: the scale, and its 95 % interval from resampled racks. Between measures of
        people, the logarithm of the scale is linear in the rating.

    """
    draw = np.random.default_rng(1)
    games = {game: points_of(racks, game) for game in SCALES}

    def levels(drawn):
        known = [np.log(scale_at(drawn[each.game], each.share)) for each in PEOPLE]
        return np.exp(np.interp(RATINGS, [each.rating for each in PEOPLE], known))

    many = [
        levels({game: resampled(points, draw) for game, points in games.items()})
        for _ in range(RESAMPLES)
    ]
    low, high = interval_of(many)
    return dict(zip(RATINGS, zip(levels(games), low, high, strict=True), strict=True))


def interval_of(many):
    """Return the 95 % interval of values (resamples, ...)."""
    return np.quantile(many, (0.025, 0.975), axis=0)


def as_page(racks, matches):
    """Write docs/levels.md."""
    lines = [
        '# Noise levels of people',
        '',
        'Written by `benchmarks/levels.py --write`, from racks on',
        f'{machine()}.',
        '',
        'With the noise `fargo_500`, the agent `player` runs out as often as people whom',
        'FargoRate rates 500. Levels are multiples of the noise of the computer pool tournaments:',
        '',
        '| level | times the noise | fit (95 %) | azimuth (°) | people | source |',
        '|---|---|---|---|---|---|',
    ]
    people = {each.rating: each for each in PEOPLE}
    for rating, (scale, low, high) in fitted_levels(racks).items():
        noise, words, source = NOISES[f'fargo_{rating}'], 'between its neighbours', ''
        if rating in people:
            measure = people[rating]
            words = f'{IN_WORDS[measure.game]} in {percent(measure.share)} %'
            source = measure.source
        lines.append(
            f'| `fargo_{rating}` | {LEVELS[rating]:g} | {scale:.2f} ({low:.2f}–{high:.2f}) | '
            f'{noise.azimuth_deg:.3f} | {words} | {source} |'
        )
    lines += [
        '',
        '## The fit',
        '',
        f'Racks of `{PLAYER}` on `{TABLE}`. *First visit*: eight-ball between equals; the player',
        'at the table after the break runs out. *Ghost*: nine-ball; the cue ball is in hand after',
        'the break. Racks that the break decides do not count.',
        '',
        '| runs out | times the noise | racks | share (95 %) | model |',
        '|---|---|---|---|---|',
    ]
    for game in SCALES:
        points = points_of(racks, game)
        a, b = logistic(points)
        for scale in np.unique(points[:, 0]):
            chances = points[points[:, 0] == scale, 1]
            low, high = wilson_interval(chances.sum(), len(chances))
            model = 1.0 / (1.0 + np.exp(-a - b * scale))
            lines.append(
                f'| {IN_WORDS[game]} | {np.exp(scale):g} | {len(chances)} | '
                f'{100 * chances.mean():.1f} % ({100 * low:.1f}–{100 * high:.1f} %) | '
                f'{100 * model:.1f} % |'
            )
    lines += [
        '',
        f'Each stroke is played with {ERRORS} new errors, and the shares that keep the turn are',
        'multiplied. The model is logistic in the logarithm of the noise. Intervals of shares are',
        'Wilson intervals, those of levels from resampled racks. The levels 600 and 700 are',
        'interpolated: the logarithm of the noise is linear in the rating.',
        '',
        'The levels are errors of this agent, not of people: who aims and plans worse needs',
        'smaller errors to run out as often.',
    ]
    if matches:
        lines += [
            '',
            '## Ratings',
            '',
            f'From {len(matches)} games of {", ".join({rack.game: "" for rack in matches})}, as',
            '`rate --match` states them. The mean of the ratings is that of the levels.',
            '',
            '| player | won | rating (95 %) | TPA (95 %) |',
            '|---|---|---|---|',
        ]
        rated = ratings(matches)
        for name in sorted(rated, key=lambda name: -rated[name].points):
            own = [rack for rack in matches if name in rack.players]
            won = sum(rack.winner == name for rack in own)
            lines.append(
                f'| `{name}` | {won} of {len(own)} | {rated[name].points:.0f} ± '
                f'{rated[name].reach:.0f} | '
                + '{:.3f} ({:.3f}–{:.3f}) |'.format(*tally(own, name).tpa)
            )
    return '\n'.join([*lines, ''])


def main():
    """Play, fit, print, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--racks', type=Path)
    parser.add_argument('--matches', type=Path, nargs='+', default=[])
    parser.add_argument('--count', type=int, default=2)
    parser.add_argument('--seconds', type=float, default=1e9)
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--no-play', action='store_true')
    options = parser.parse_args()
    path = options.racks or Path(mkdtemp()) / 'racks.jsonl'
    if not options.no_play:
        play_missing(path, options.count, options.seconds)
    racks = known(path)
    matches = [RackRecord.from_dict(rack) for each in options.matches for rack in known(each)]
    if options.write:
        (DOCS / 'levels.md').write_text(as_page(racks, matches), encoding='utf-8')
    report = Report('Noise levels')
    for rating, (scale, low, high) in fitted_levels(racks).items():
        report.row(f'fargo_{rating}: {low:.2f} to {high:.2f} times the noise', scale, '')
    report.end()


if __name__ == '__main__':
    main()

"""
Strength on the scales of people, from racks that were recorded: TPA, runs, and ratings.

Sources: Accu-Stats, Total Performance Average (D. Alciatore, billiards.colostate.edu, FAQ on TPA);
FargoRate, fargorate.com: a player who is rated 100 points higher wins 2 games of 3.
"""

from collections.abc import Iterator, Sequence
import math
import re
from typing import NamedTuple

import numpy as np

from billiard_shot.game.rack import LEVEL, PlayedShot, RackRecord
from billiard_shot.planning.statistics import wilson_interval, Z95
from billiard_shot.scene.placement import CUE_BALL

POINTS = 100.0 / math.log(2.0)  # of a rating, for a factor e of the odds to win a game
ALWAYS_ERRORS = 'miss', 'scratch', 'foul', 'no shot', 'illegal'  # of `ENDS`
ANCHOR = re.compile(rf'player(?::.*)?{LEVEL}fargo_(\d+)')  # whose levels are those of people
NEWTON_STEPS = 30


class Tally(NamedTuple):
    """What a player did in racks."""

    balls: int  # that fell in shots that kept the turn or won
    errors: int
    ends: int  # visits that ended without a win
    longest: int  # run of balls in one visit

    @property
    def tpa(self) -> tuple[float, float, float]:
        """The share of balls among balls and errors, and its 95 % interval; NaN without any."""
        count = self.balls + self.errors
        return self.balls / count if count else math.nan, *wilson_interval(self.balls, count)

    @property
    def mean_run(self) -> tuple[float, float, float]:
        """
        The balls of a visit, and the 95 % interval; infinite if no visit ended.

        As for a player who makes each ball with the same chance p: the mean is p / (1 - p), also
        if wins cut runs short.
        """
        count = self.balls + self.ends
        chances = self.balls / count if count else 0.0, *wilson_interval(self.balls, count)
        mean, low, high = (p / (1.0 - p) if p < 1.0 else math.inf for p in chances)
        return mean, low, high


def tally(racks: Sequence[RackRecord], name: str) -> Tally:
    """
    Count the balls and the errors of a player, as TPA does, and its runs.

    An error is a visit that ends with a miss (a shot that the player gave an even chance or more,
    or whose chance it did not state), a foul or a scratch; with a miss of a worse shot that its
    own shot before left; or with a safety after which the other player keeps the turn. Accu-Stats
    counts some shots twice, and a safety after a bad leave: no record tells these.
    """
    balls = errors = ends = longest = run = 0
    for rack in racks:
        for fallen, ended, error in _strokes(rack, name):
            balls, errors, ends = balls + fallen, errors + error, ends + ended
            run += fallen
            longest = max(longest, run)
            run *= not ended
        run = 0
    return Tally(balls, errors, ends, longest)


def _strokes(rack: RackRecord, name: str) -> Iterator[tuple[int, bool, bool]]:
    """For each stroke of a player: balls that count, whether its visit ended, and by an error."""
    states = [*(shot.state for shot in rack.shots[1:]), rack.state]
    strokes = [pair for pair in zip(rack.shots, states, strict=True) if not pair[0].choice]
    for i, (shot, after) in enumerate(strokes):
        if rack.players[shot.state['player']] != name:
            continue
        before, follower = strokes[i - 1][0] if i else None, strokes[i + 1 : i + 2]
        left = [len({*state['balls']} - {CUE_BALL}) for state in (shot.state, after)]
        fallen = left[0] - left[1] if left[1] <= left[0] else 1  # then balls were racked again
        own_leave = before is not None and before.kept
        error = (
            shot.end in ALWAYS_ERRORS
            or (shot.end == 'leave' and own_leave)
            or (shot.end == 'safety' and any(_made(each) for each, _ in follower))
        )
        yield (fallen if _made(shot) else 0), not _made(shot), error


def _made(shot: PlayedShot) -> bool:
    """Whether a shot kept the turn or won."""
    return shot.kept or shot.end == 'won'


class Rating(NamedTuple):
    """A rating, and half of its 95 % interval; both in points."""

    points: float
    reach: float


def ratings(racks: Sequence[RackRecord]) -> dict[str, Rating]:
    """
    Rate players by the games that they won against each other.

    The probability to win is 1 / (1 + 2**(-d / 100)), with the difference d of the ratings, and
    the ratings are those of maximum likelihood (R. A. Bradley, M. E. Terry, Biometrika 39, 1952).
    Each pair that met has half a game more for either player, so that who won all has a finite
    rating. The mean of the agents `player` whose names state a level, such as `player@fargo_500`,
    is that of their levels; without them the mean of all players is 0. The intervals are those of
    differences from that mean.

    Parameters
    ----------
    racks : sequence of RackRecord
        Those without a winner, of one player, or of two with the same name do not count.

    Returns
    -------
    dict
        A `Rating` for each player; empty if no rack counts.

    Raises
    ------
    ValueError
        If players have no games with each other, nor with others that link them.

    """
    games = [
        (rack.players[winner], rack.players[1 - winner])
        for rack in racks
        for winner in [rack.state.get('winner')]
        if winner is not None and len({*rack.players}) > 1
    ]
    names = sorted({name for pair in games for name in pair})
    if not names:
        return {}
    won = np.zeros((len(names), len(names)))
    for pair in games:
        won[*map(names.index, pair)] += 1.0
    won += 0.5 * (won + won.T > 0.0)
    total, points = won + won.T, np.zeros(len(names))
    linked = np.linalg.matrix_power(np.eye(len(names)) + (total > 0.0), len(names))[0] > 0.0
    if not linked.all():
        other = names[int(np.argmin(linked))]
        raise ValueError(f'no games link {names[0]} with {other}, which must be to compare them')
    for _ in range(NEWTON_STEPS):
        chance = 1.0 / (1.0 + np.exp(np.subtract.outer(-points, -points)))
        weight = total * chance * (1.0 - chance)
        information = np.diag(weight.sum(axis=1)) - weight
        covariance = np.linalg.pinv(information, hermitian=True)
        points += covariance @ (won - total * chance).sum(axis=1)
    levels = [anchor[1] if (anchor := ANCHOR.fullmatch(name)) else '' for name in names]
    known = np.array([bool(level) for level in levels])
    if not known.any():
        known[:] = True
    nominal = np.array([float(level or 0.0) for level in levels])
    mean = known / known.sum()
    relative = np.eye(len(names)) - mean
    spread = np.sqrt(np.diag(relative @ covariance @ relative.T).clip(0.0))
    points = POINTS * (relative @ points) + mean @ nominal
    reach = Z95 * POINTS * spread
    return dict(zip(names, map(Rating, points.tolist(), reach.tolist()), strict=True))

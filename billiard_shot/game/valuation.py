"""The value of states: an estimate of the probability to win the rack, one or two shots deep."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.next_rack import LEAST, run_goes_on
from billiard_shot.game.referee import settled
from billiard_shot.game.state import Call, Game, Outcome, Ruling, State
from billiard_shot.planning.plan import cue_ball_all_over
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.planning.within_noise import play_within_noise
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, head_string, Place
from billiard_shot.scene.player import B, ELEVATION, SPEED
from billiard_shot.shot.play import StrokeBatch
from billiard_shot.table.model.motion import NOTHING
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates


class RuledBatch(NamedTuple):
    """Strokes that were played in a simulation, with their rulings."""

    # The different ones. Their states tell which balls are left, not where these rest.
    kinds: tuple[Ruling, ...]
    kind: NDArray[np.int64]  # (n,) the ruling of each stroke
    states: TableStates  # the balls as they rest, or back where a ruling puts them

    @property
    def after(self) -> list[State]:
        """The states that the different rulings lead to."""
        return [ruling.state for ruling in self.kinds]

    def take(self, which: NDArray[np.int64]) -> 'RuledBatch':
        """Select some of the strokes."""
        return RuledBatch(self.kinds, self.kind[which], self.states.take(which))

    def keeps(self, player: int) -> NDArray[np.bool_]:
        """Whether each stroke (n,) of a player keeps the turn, or wins, and is no miscue."""
        kept = [
            not ruling.miscue
            and (after.winner == player if after.over else ruling.legal and after.player == player)
            for ruling in self.kinds
            for after in [ruling.state]
        ]
        return np.array(kept, np.bool_)[self.kind]


def rule_on(state: State, calls: Sequence[Call], run: StrokeBatch) -> RuledBatch:
    """
    Rule on a batch of strokes.

    Parameters
    ----------
    state : State
        Before the strokes, with the cue ball placed.
    calls : sequence of Call
        (n,)
    run : StrokeBatch
        (n,) on tables with the balls of the state.

    """
    cue = run.names.index(CUE_BALL)
    to_cushion = run.to_cushion.copy()
    if state.phase != 'break':  # rules ask whether any ball was driven to a cushion, not which
        to_cushion[:, cue] = to_cushion.any(axis=1)
        to_cushion[:, [i for i in range(len(run.names)) if i != cue]] = False
    balls = *run.pocket.T, *run.off_table.T, *to_cushion.T
    columns = [run.refused, run.miscue, run.double_hit, run.first_met[:, cue], *balls]
    different, number = np.unique(np.array(columns, np.int64), axis=1, return_inverse=True)
    outcomes = [_outcome(state, run.names, row) for row in different.T.tolist()]
    pairs = zip(calls, number.ravel().tolist(), strict=True)
    numbers: dict[tuple[Call, int], int] = {}
    kind = np.array([numbers.setdefault(pair, len(numbers)) for pair in pairs], np.int64)
    rule = state.game.rule
    kinds = tuple(settled(rule(state, call, outcomes[i]), outcomes[i]) for call, i in numbers)
    return RuledBatch(kinds, kind, _restored(run.states, kinds, kind, state.radius))


def _restored(
    states: TableStates, kinds: Sequence[Ruling], kind: NDArray[np.int64], radius: float
) -> TableStates:
    """Put the balls of a table back if its ruling restores it."""
    position, present = states.position.copy(), states.present
    for number, ruling in enumerate(kinds):
        if ruling.restore:
            rows, balls = kind == number, ruling.state.balls
            present[rows] = [name in balls for name in states.names]
            for i, name in enumerate(states.names):
                if name in balls:
                    position[rows, i] = (*balls[name], radius)
    return TableStates(states.names, position, present=present)


def _outcome(state: State, names: tuple[str, ...], row: list[int]) -> Outcome:
    """Read an outcome; its places are those before the shot, of the balls that are left."""
    count, (refused, miscue, double_hit, first), balls = len(names), row[:4], row[4:]
    if refused:
        return Outcome(refused='it is refused')
    pockets, off, cushion = (balls[i : i + count] for i in range(0, 3 * count, count))
    met = None if first == NOTHING else names[first]
    outcome = Outcome(
        first_contact=met,
        pocketed=tuple(
            (name, POCKET_NAMES[pocket])
            for name, pocket in zip(names, pockets, strict=True)
            if pocket != NOTHING
        ),
        off_table=tuple(name for name, gone in zip(names, off, strict=True) if gone),
        to_cushion=frozenset(name for name, met in zip(names, cushion, strict=True) if met),
        # A batch does not tell whether the cue ball crossed the head string before: assume not.
        from_kitchen=met is not None and state.balls[met][0] < head_string(state),
        double_hit=bool(double_hit),
        miscue=bool(miscue),
    )
    places = {ball: at for ball, at in state.balls.items() if ball not in outcome.gone}
    return replace(outcome, places=places)


SHOT = 0.9  # probability that a shot of the rest of the rack pots and leaves the next one
# Shots that a ball costs beside its own if it is hard to pot, by the mean of its best chances from
# places of the cue ball all over the table. In 36 racks of eight-ball each such ball made run-outs
# rarer by a factor of .6 and .8.
HARD = ((0.03, 4), (0.15, 2))
PLACES = 32  # of the cue ball
MOST_SHOTS = 15 * (1 + HARD[0][1])  # that a player needs
AFTER_SAFETY = 0.5  # probability of the other player's shot after a safety
IN_HAND_CHANCE, IN_KITCHEN = 0.97, 0.85  # chance of the first shot with the cue ball in hand


class Skills(NamedTuple):
    """Probability that a shot of the rest of the rack pots and leaves the next one."""

    own: float  # of the player for whom states are valued
    other: float

    @property
    def swapped(self) -> 'Skills':
        """Those that the other player sees."""
        return Skills(self.other, self.own)


EQUAL = Skills(SHOT, SHOT)


@cache
def win_probabilities(shared: bool, skills: Skills) -> Array:
    """
    Tabulate the probability that the player at the table wins.

    Parameters
    ----------
    shared : bool
        Whether both players pot the same balls.
    skills : Skills
        Of the player at the table, and of the other one.

    Returns
    -------
    (MOST_SHOTS + 1, MOST_SHOTS + 1) float array
        By the shots that the player at the table has to make, and the other one.

    """
    won = np.zeros((2, MOST_SHOTS + 1, MOST_SHOTS + 1))  # by who is at the table
    won[:, 0] = 1.0
    for mine, others in sorted(np.ndindex(won.shape[1:]), key=sum):
        if mine and others and (mine == others or not shared):
            for i, (s, t) in enumerate((skills, skills.swapped)):
                # w = s up + (1 - s) (1 - v),  v = t down + (1 - t) (1 - w), v of the other player
                up = won[i, mine - 1, others - shared]
                down = won[1 - i, others - 1, mine - shared]
                gained = s * up + (1.0 - s) * t * (1.0 - down)
                won[i, mine, others] = gained / (1.0 - (1.0 - s) * (1.0 - t))
    return won[0]


def shots_left(
    after: Sequence[State],
    kind: NDArray[np.int64],
    states: TableStates,
    extra: NDArray[np.int64],
) -> NDArray[np.int64]:
    """
    Count the shots that the players need.

    Parameters
    ----------
    after : sequence of State
        States of the game.
    kind : (n,) int array
        Which of these belongs to each table; -1: none.
    states : TableStates
        (n,) where the balls lie.
    extra : (n, balls) int array
        As of `extra_shots`.

    Returns
    -------
    (n, 2) int array
        Of the player at the table, and of the other one.

    """
    needed = np.zeros((2, *states.present.shape), np.bool_)
    for number, state in enumerate(after):
        for who, balls in enumerate(_needs(state)):
            needed[who, kind == number] = [name in balls for name in states.names]
    return (needed * states.present * (1 + extra)).sum(axis=2).T


def _needs(state: State) -> list[tuple[str, ...]]:
    """List the balls that the player at the table needs, and those of the other one."""
    if state.over:
        return []
    players = (state.player, state.other)[: state.game.players]
    return [state.game.needs(state, player) for player in players]


def extra_shots(
    scene: Scene, after: Sequence[State], kind: NDArray[np.int64], states: TableStates
) -> NDArray[np.int64]:
    """
    Count the shots (n, balls) that balls cost beside their own, see `shots_left`.

    A ball that was moved by more than its diameter counts as easy: so driving balls apart pays.
    """
    extra = np.zeros(states.present.shape, np.int64)
    anywhere = _without_balls(scene)
    for number, state in enumerate(after):
        lying = tuple((name, state.balls[name]) for name in state.object_balls)
        wanted = tuple(sorted({name for balls in _needs(state) for name in balls}))
        for name, more in zip(wanted, _extra_of(anywhere, lying, wanted), strict=True):
            rows, i = np.flatnonzero(kind == number), states.names.index(name)
            away = states.position[rows, i, :2] - state.balls[name]
            extra[rows, i] = more * (np.hypot(*away.T) <= 2.0 * state.radius)
    return extra


@lru_cache(maxsize=64)
def _without_balls(scene: Scene) -> Scene:
    return replace(scene, balls={})


@lru_cache(maxsize=1024)
def _extra_of(
    scene: Scene, lying: tuple[tuple[str, Place], ...], wanted: tuple[str, ...]
) -> list[int]:
    """Count the shots that some of the balls on a table cost beside their own."""
    if not wanted:
        return []
    tables = cue_ball_all_over(scene.table, dict(lying), scene.ball.radius, PLACES)
    direct = shots(scene, tables, wanted)
    chance = np.zeros((len(direct.names), direct.tables))
    np.maximum.at(chance, (direct.ball, direct.table), direct.chance)
    mean = chance.mean(axis=1)[[direct.names.index(name) for name in wanted]].tolist()
    return [next((more for most, more in HARD if each < most), 0) for each in mean]


def best_next(
    direct: DirectShots,
    left: NDArray[np.int64],
    extra: NDArray[np.int64],
    then: Array | float = 1.0,
) -> tuple[Array, NDArray[np.int64]]:
    """
    Choose the next shot of each table: a hard ball that can be potted costs no more than others.

    Parameters
    ----------
    direct : DirectShots
        Of the tables.
    left, extra
        As of `shots_left`.
    then : (n,) float array, optional
        Chances that are multiplied with those of the shots.

    Returns
    -------
    chance : (tables,) float array
        Of the chosen shot; 0 if no shot is possible.
    left : (tables, 2) int array
        With its ball as one of those that are easy.

    """
    saved = extra[direct.table, direct.ball]
    # The last one of a table stays.
    order = np.lexsort((worth(direct, extra) * then, direct.table))
    chance, less = np.zeros(len(left)), np.zeros(len(left), np.int64)
    chance[direct.table[order]] = (direct.chance * then)[order]
    less[direct.table[order]] = saved[order]
    return chance, left - np.column_stack([less, np.zeros_like(less)])


def worth(direct: DirectShots, extra: NDArray[np.int64]) -> Array:
    """Rank direct shots by their chances, and by the shots that they save."""
    return direct.chance / SHOT ** extra[direct.table, direct.ball]


def at_table(chance: Array, game: Game, left: NDArray[np.int64], skills: Skills) -> Array:
    """
    Value states for the player at the table.

    Parameters
    ----------
    chance : (n,) float array
        Of the next shot.
    game : Game
    left : (n, 2) int array
        As of `shots_left`.
    skills : Skills
        Of the player at the table, and of the other one.

    """
    mine, others = left.T
    rest = np.maximum(mine - 1, 0)
    cleared = LEAST if game.reracked else 1.0  # no ball is left that breaks the next rack
    if game.players == 1:
        return np.where(mine > 0, chance * skills.own**rest, cleared)
    won, lost = (win_probabilities(game.shared, each) for each in (skills, skills.swapped))
    theirs = lost[np.maximum(others - 1, 0), rest if game.shared else mine]
    potted = AFTER_SAFETY * skills.other / SHOT
    safety = potted * (1.0 - theirs) + (1.0 - potted) * won[mine, others]
    pot = chance * won[rest, rest if game.shared else others]
    played = np.maximum(pot + (1.0 - chance) * miss_value(game, left, skills), safety)
    return np.where(mine > 0, played, cleared)


def miss_value(game: Game, left: NDArray[np.int64], skills: Skills) -> Array:
    """Value a miss for the player at the table: the other one plays from an average place."""
    mine, others = left.T
    if game.players == 1:
        return np.zeros(len(left))
    return 1.0 - win_probabilities(game.shared, skills.swapped)[others, mine]


def values(scene: Scene, player: int, batch: RuledBatch, skills: Skills) -> Array:
    """
    Value each row of a batch for a player.

    Parameters
    ----------
    scene : Scene
        Table and noise.
    player : int
    batch : RuledBatch
        (n,)
    skills : Skills
        Of this player and the other one.

    Returns
    -------
    (n,) float array
        Estimated probabilities to win. As plans do, a player counts a miscue as lost, although it
        is legal: where the ball goes then is chance, and robots refuse to play it.

    """
    goes_on = [not after.over and not after.in_hand for after in batch.after]
    extra = extra_shots(scene, batch.after, batch.kind, batch.states)
    left = shots_left(batch.after, batch.kind, batch.states, extra)
    direct = next_shots(scene, batch, goes_on)
    then = run_goes_on(_without_balls(scene), batch.after[0], direct, batch.states)
    chance, left = best_next(direct, left, extra, then)
    found = np.zeros(len(batch.kind))
    for number, ruling in enumerate(batch.kinds):
        rows = batch.kind == number
        if not ruling.miscue:
            found[rows] = value(ruling.state, player, chance[rows], left[rows], skills)
    return found


def next_shots(scene: Scene, batch: RuledBatch, kinds: Sequence[bool]) -> DirectShots:
    """Find the direct shots that follow a batch, of the rulings that `kinds` tells."""
    masks = np.zeros(batch.states.present.shape, np.bool_)
    for number, after in enumerate(batch.after):
        if kinds[number] and after.object_balls:
            masks[batch.kind == number] = may_pot(after, batch.states.names)
    return shots(scene, batch.states, masks)


def may_pot(state: State, names: tuple[str, ...]) -> list[bool]:
    """Which balls the player at the table may pot."""
    targets = state.game.targets(state)
    return [name in targets for name in names]


def value(
    state: State, player: int, chance: Array, left: NDArray[np.int64], skills: Skills
) -> Array:
    """
    Value a state for a player.

    Parameters
    ----------
    state : State
    player : int
    chance : (n,) float array
        Of the next shot, if the player plays it; those of the other one are by its skill.
    left : (n, 2) int array
        As of `shots_left`.
    skills : Skills
        Of this player and the other one.

    """
    if state.over:
        return np.full(len(chance), float(state.winner == player))
    if state.in_hand:
        chance = np.full(
            len(chance), IN_HAND_CHANCE if state.in_hand == 'anywhere' else IN_KITCHEN
        )
    if state.player != player:
        skills = skills.swapped
        chance = np.minimum(chance * skills.own / SHOT, 1.0)
    own = at_table(chance, state.game, left, skills)
    if 'pass' in state.choices:  # after a push-out the other player takes the better part
        own = np.maximum(own, 1.0 - own)
    return own if state.player == player else 1.0 - own


FOLLOWED_SHOTS = 2  # direct shots of each end state that are followed
# b [ball radii] and the speed relative to that of the direct shot. Side spin changes the throw: of
# strokes with a = 0.25 four in five missed.
STROKES = np.array([(b, speed) for b in (0.0, 0.3, -0.3) for speed in (1.0, 1.6)])
# A low tip needs a steeper cue: by so much for each ball radius, relative to the elevation of the
# direct shot. With less, most draw strokes have no room for the cue.
DRAW_RAISES = 1.5


def second_ply(
    scene: Scene, player: int, batch: RuledBatch, first: Array, skills: Skills
) -> Array:
    """
    Value end states in which a player goes on by its next two shots.

    Parameters
    ----------
    scene : Scene
    player : int
    batch : RuledBatch
        (n,) of strokes that kept the turn.
    first : (n,) float array
        Their values by the next shot alone, see `values`.
    skills : Skills
        Of this player and the other one.

    Returns
    -------
    (n,) float array
        The largest value of the strokes that follow, without errors but with the chance of their
        shots; `first` where there is no direct shot. If none of the strokes pots, there is no
        chance: often the cue ball lies too near to a ball. A stroke without room for the cue is
        refused; one whose tip slides, or whose cue hits the cue ball again, does not count.

    """
    names = batch.states.names
    goes_on = [
        not after.over
        and not after.in_hand
        and after.player == player
        and len(after.object_balls) > after.game.reracked
        for after in batch.after
    ]
    direct = next_shots(scene, batch, goes_on)
    if not len(direct):
        return first
    extra = extra_shots(scene, batch.after, batch.kind, batch.states)
    left = shots_left(batch.after, batch.kind, batch.states, extra)
    shot, strokes = _followed(scene, direct, extra)
    row, ball = direct.table[shot], direct.ball[shot]
    sigmas = scene.noise.sigmas(scene.ball.radius)
    played = play_within_noise(scene, strokes, sigmas, batch.states.take(row))
    cue = names.index(CUE_BALL)
    potted = np.flatnonzero(
        (played.pocket[np.arange(len(ball)), ball] == direct.pocket[shot])
        & (played.first_met[:, cue] == ball)
        & played.states.present[:, cue]
        & ~played.double_hit
        & ~played.miscue
    )
    row, ball, p = row[potted], ball[potted], direct.chance[shot[potted]]
    game = batch.after[0].game
    found = first.copy()
    found[direct.table] = at_table(np.zeros(len(first)), game, left, skills)[direct.table]
    if not len(row):
        return found
    then = values(scene, player, _after(batch, row, ball, played.states.take(potted)), skills)
    np.maximum.at(found, row, p * then + (1.0 - p) * miss_value(game, left, skills)[row])
    return found


def _after(
    batch: RuledBatch, row: NDArray[np.int64], ball: NDArray[np.int64], ends: TableStates
) -> RuledBatch:
    """Rule on strokes after rows (n,) of a batch, each of which pots one ball (n,) as called."""
    ways, kind = np.unique(np.column_stack([batch.kind[row], ball]), axis=0, return_inverse=True)
    kinds = (Ruling(batch.after[i].without(ends.names[fallen])) for i, fallen in ways.tolist())
    return RuledBatch(tuple(kinds), kind.ravel(), ends)


def _followed(
    scene: Scene, direct: DirectShots, extra: NDArray[np.int64]
) -> tuple[NDArray[np.int64], Array]:
    """Return numbers (n,) of the best direct shots of each table, and strokes (n, 5) of these."""
    order = np.lexsort((-worth(direct, extra), direct.table))
    rank = np.arange(len(order)) - np.searchsorted(direct.table[order], direct.table[order])
    chosen = order[rank < FOLLOWED_SHOTS]
    shot = np.repeat(chosen, len(STROKES))
    strokes = direct.offsets[shot]
    strokes[:, B], faster = np.tile(STROKES, (len(chosen), 1)).T
    strokes[:, ELEVATION] *= 1.0 - DRAW_RAISES * np.minimum(strokes[:, B], 0.0)
    strokes[:, SPEED] = np.minimum(strokes[:, SPEED] * faster, scene.robot.speed_max)
    return shot, strokes

"""What rules ask of a shot: contacts, pots, cushions; from a prediction or from anything else."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused, suggestion
from billiard_shot.scene.placement import CUE_BALL, head_string
from billiard_shot.shot.shot import Shot
from billiard_shot.table.run import NOSE_NAMES, POCKET_NAMES, TableEvent, TableRun
from billiard_shot.table.trajectory import EventKind

# A ball that lay within this distance of a nose was frozen to it [m]: its first contact with that
# nose counts only if the ball has left the nose by more than this (WPA 8.4, driven to a rail).
FROZEN = 1e-3
NOSE_SAMPLES = 33  # times at which the distance from such a nose is looked at


@dataclass(frozen=True, slots=True)
class Outcome:
    """
    What a shot did, as far as rules ask.

    Equal outcomes have the same ruling; miscues and the places of the balls do not count for that.

    Parameters
    ----------
    first_contact : str, optional
        The ball that the cue ball met first; None if it met none.
    pocketed : tuple of (str, str)
        Ball and pocket, in the order of time, with the cue ball. The pocket is '' if
        nobody saw it.
    off_table : tuple of str
        Balls that left the table, with the cue ball.
    to_cushion : frozenset of str
        Balls that were driven to a cushion after the first contact (WPA 8.4), with the cue ball.
    from_kitchen : bool
        The first ball met was behind the head string, and the cue ball had not crossed it before
        (WPA 6.11).
    double_hit : bool
        The cue hit the cue ball again.
    refused : str
        Why the stroke could not be played; '' if it was played.
    met : tuple of str
        The balls that the cue ball met, each once, in the order of time.
    cushions_before : tuple of int
        For each ball in `met`, how often the cue ball had met a cushion before.
    miscue : bool
        The tip slid on the cue ball; that is legal (WPA 8.18).
    places : mapping of str to (x, y)
        Where the balls that are left rest [m].

    Raises
    ------
    ValueError
        If a ball fell into a pocket that does not exist.

    """

    first_contact: str | None = None
    pocketed: tuple[tuple[str, str], ...] = ()
    off_table: tuple[str, ...] = ()
    to_cushion: frozenset[str] = frozenset()
    from_kitchen: bool = False
    double_hit: bool = False
    refused: str = ''
    met: tuple[str, ...] = ()
    cushions_before: tuple[int, ...] = ()
    miscue: bool = field(default=False, compare=False)
    places: Mapping[str, tuple[float, float]] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        for pair in self.pocketed:
            if isinstance(pair, str) or len(pair) != 2:
                raise refused(pair, 'a ball and a pocket', 'pocketed')
            if pair[1] not in (*POCKET_NAMES, ''):
                near = suggestion(POCKET_NAMES, pair[1])
                allowed = f'a pocket, one of {", ".join(POCKET_NAMES)}'
                raise refused(pair[1], allowed, 'pocketed', hint=near)

    @property
    def gone(self) -> frozenset[str]:
        """The balls that are no longer on the table."""
        return frozenset(ball for ball, _ in self.pocketed) | frozenset(self.off_table)

    @property
    def scratched(self) -> bool:
        """Whether the cue ball fell into a pocket or left the table."""
        return CUE_BALL in self.gone

    @property
    def fallen(self) -> tuple[str, ...]:
        """The object balls that fell into pockets, in the order of time."""
        return tuple(ball for ball, _ in self.pocketed if ball != CUE_BALL)


ShotLike: TypeAlias = Shot | Outcome
"""A predicted shot; or its outcome, as another simulator or an observer tells it."""


def outcome_of(shot: ShotLike) -> Outcome:
    """Read the outcome of a prediction; an outcome is returned as it is."""
    if isinstance(shot, Outcome):
        return shot
    if shot.status.refused:
        places = {CUE_BALL: shot.scene.cue_ball[:2], **shot.scene.balls}
        return Outcome(refused=shot.message, places=places)
    outcome = outcome_of_run(shot.run, shot.scene, double_hit=shot.double_hit is not None)
    return replace(outcome, miscue=shot.miscue)


def outcome_of_run(run: TableRun, scene: Scene, *, double_hit: bool = False) -> Outcome:
    """Read the outcome of a simulated table whose cue ball is called `cue`."""
    kitchen_end = head_string(scene.table) if scene.table else -np.inf
    first = run.first_met.get(CUE_BALL)
    met: dict[str, int] = {}
    to_cushion: set[str] = set()
    from_kitchen = crossed = False
    cushions = 0
    for event in run.events:
        if event.kind in (EventKind.BALL, EventKind.CLUSTER) and CUE_BALL in event.balls:
            if not met and first is not None:
                x = run.balls[first].at(event.time).position[0]
                from_kitchen = bool(x < kitchen_end) and not crossed
                met[first] = cushions  # several balls may be met at once
            met |= {ball: cushions for ball in event.balls if ball not in {CUE_BALL, *met}}
        elif event.kind == EventKind.CUSHION:
            ball = event.balls[0]
            cushions += ball == CUE_BALL
            crossed |= ball == CUE_BALL and bool(event.position[0] >= kitchen_end)
            if met and _was_driven(run, event, scene):
                to_cushion.add(ball)
    return Outcome(
        first_contact=first,
        pocketed=tuple(run.pocketed.items()),
        off_table=run.off_table,
        to_cushion=frozenset(to_cushion),
        from_kitchen=from_kitchen,
        double_hit=double_hit,
        met=tuple(met),
        cushions_before=tuple(met.values()),
        places=run.places_left,
    )


def _was_driven(run: TableRun, event: TableEvent, scene: Scene) -> bool:
    """Whether a ball that meets a cushion was not frozen to it from the beginning."""
    if event.place not in NOSE_NAMES or scene.table is None:
        return True
    ball = run.balls[event.balls[0]]
    axis = 0 if event.place in ('foot', 'head') else 1
    half = 0.5 * (scene.table.length, scene.table.width)[axis]
    sign = 1.0 if event.place in ('foot', 'left') else -1.0
    # The nose is above the middle of the ball: a frozen ball is nearer to it than its radius.
    nearest = half - sign * float(event.position[axis])
    start = half - sign * float(ball.at(0.0).position[axis])
    if start > nearest + FROZEN:
        return True
    times = np.linspace(0.0, event.time, NOSE_SAMPLES)
    away = half - sign * ball.at(times).position[:, axis]
    return bool((away > nearest + FROZEN).any())

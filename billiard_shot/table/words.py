"""Balls, pockets and events in plain English: the same words in texts, pictures and pages."""

from collections import Counter
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from billiard_shot.status import Status
from billiard_shot.table.trajectory import EventKind

HAPPENS = {
    EventKind.BOUNCE: 'bounces',
    EventKind.LAND: 'lands',
    EventKind.ROLL: 'begins to roll',
    EventKind.SPIN: 'stands and spins',
    EventKind.SPIN_END: 'side spin is used up',
    EventKind.REST: 'rests',
    EventKind.BALL: 'meets',
    EventKind.CUSHION: 'meets a cushion',
    EventKind.CLUSTER: 'meets',
    EventKind.POCKET: 'falls into a pocket',
    EventKind.OFF: 'leaves the table',
    EventKind.CUE: 'is hit by the cue again',
}


def ball_in_words(name: str) -> str:
    """Name a ball: `cue` is the cue ball."""
    return 'cue ball' if name == 'cue' else name


def place_in_words(place: str) -> str:
    """Name a pocket or cushion, such as `foot left`."""
    return place.replace('_', ' ')


def event_in_words(kind: EventKind, balls: Iterable[str], place: str = '') -> str:
    """Say what happened, such as `cue ball meets 8` or `8 falls into a pocket: foot left`."""
    first, *others = map(ball_in_words, balls)
    text = f'{first} {HAPPENS[kind]}'
    if others:
        text += f' {", ".join(others)}'
    return f'{text}: {place_in_words(place)}' if place else text


def moment_in_words(time: float) -> str:
    """Say when a double hit happened [s], 0: during the strike."""
    return f'at {time:.3g} s' if time > 0.0 else 'during the strike'


def rounded(value: float, digits: int, sign: str = '') -> str:
    """Write a number with `digits` digits after the point; `sign` is `+` or empty."""
    return f'{round(value, digits) + 0.0:{sign}.{digits}f}'  # + 0.0 makes 0 of -0


def plural(number: int, thing: str) -> str:
    """Count things, as in `1 ball` or `3 balls`."""
    return f'{number} {thing}{"s" * (number != 1)}'


def count_in_words(statuses: NDArray[np.uint16], thing: str, miscues: NDArray[np.bool_]) -> str:
    """Count things by their status (n,): `2000 strokes: 1998 OK, 2 OFF_TABLE; 1 miscue`."""
    counts = Counter(statuses.tolist()).most_common()
    listed = ', '.join(f'{count} {Status(status).name}' for status, count in counts)
    told = f'; {plural(int(miscues.sum()), "miscue")}' if miscues.any() else ''
    return plural(len(statuses), thing) + (f': {listed}' if listed else '') + told

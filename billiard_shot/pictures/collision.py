"""Any collision of `billiard_shot.impact.collide`: impulses and energies over its time."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.impact import Body, collide, Contact
from billiard_shot.pictures.canvas import new_figure, save
from billiard_shot.pictures.trace import trace_of_collision
from billiard_shot.table.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

CONTACT_COLOURS = BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK


def draw_collision(
    bodies: Sequence[Body],
    contacts: Sequence[Contact],
    path: Path,
    *,
    law: str = 'bistiffness',
    exponent: float = 1.0,
) -> None:
    """
    Write a picture: the impulse of each contact, and its elastic energy, over time.

    A drop of an energy is a loss. Bands tell states apart; the title names the contacts that are
    active in each state.

    Parameters
    ----------
    bodies, contacts, law, exponent
        As for `collide`.
    path : Path
        Of a picture file, such as `.png`.

    Raises
    ------
    ValueError
        If nothing approaches, if matplotlib is missing, or if the file cannot be written.

    """
    save(collision_figure(bodies, contacts, law, exponent), path)


def collision_figure(
    bodies: Sequence[Body], contacts: Sequence[Contact], law: str, exponent: float = 1.0
) -> Any:
    """Draw a collision; return the matplotlib figure."""
    result = collide(bodies, contacts, law, exponent, 1e-10)
    if not result.phases:
        raise ValueError('contacts: one must approach, but no two bodies collide')
    trace = trace_of_collision(bodies, contacts, law, exponent)
    time = trace.time / trace.time[-1]
    figure = new_figure(8.0, 6.0)
    impulses, energies = figure.subplots(2, 1, sharex=True)
    for j, (contact, colour) in enumerate(zip(contacts, cycle(CONTACT_COLOURS), strict=False)):
        touching = np.where(trace.active[:, j], 1.0, np.nan)
        name = f'contact {j}: body {contact.a} on body {contact.b}'
        lost = result.dissipated[j]
        losses = f'lost {lost[0]:.3g} J' + (f', {lost[1]:.3g} J by friction' if lost[1] else '')
        impulses.plot(time, trace.impulses[:, 3 * j], color=colour, label=name)
        energies.plot(time, trace.energies[:, j] * touching, color=colour, label=losses)
    for number, part in enumerate(trace.phases()):
        if number % 2:
            for axes in (impulses, energies):
                axes.axvspan(*time[part][[0, -1]], color=GREEN, alpha=0.08, linewidth=0)
    impulses.set(ylabel='normal impulse (N s)', xlim=(0.0, 1.0))
    energies.set(
        ylabel='elastic energy (J)', xlabel='time / length of the collision', ylim=(0.0, None)
    )
    for axes in (impulses, energies):
        axes.grid(alpha=0.3)
        axes.legend(loc='upper left', bbox_to_anchor=(1.0, 1.0), fontsize='small', frameon=False)
    states = ', '.join('+'.join(map(str, phase.active)) for phase in result.phases)
    figure.suptitle(
        f'{result.status.name}, law {law}: active contacts {states}', fontsize='medium', wrap=True
    )
    return figure

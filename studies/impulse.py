"""The paper's Figs. 3, 4 and 5: impulses and energies of two balls on a table, and ping-pong."""

from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.pictures.canvas import (
    BLUE,
    GREEN,
    GREY,
    new_figure,
    PURPLE,
    save,
    SKY,
    VERMILION,
)
from billiard_shot.pictures.history import CollisionTrace
from studies.two_balls import ImpactState, normal_impulses, PING_PONG, TwoBalls

STATE_COLOURS = {'S1': BLUE, 'S2': VERMILION, 'S3': GREEN}
NUMBER_OFFSETS = {'S1': (9, -11), 'S2': (-13, 2), 'S3': (-14, 4)}  # points from curve to number
STATE_MEANINGS = {'S1': 'both', 'S2': 'ball on table', 'S3': 'ball on ball'}


def draw_impulse_plane(balls: TwoBalls, path: Path) -> None:
    """Write the plane of impulses: the ellipse of energy, lines of compression, four regions."""
    figure = new_figure(7.0, 6.0)
    axes = figure.subplots()
    _plane(axes, balls)
    m1, v0 = balls.masses[0], -balls.v0
    wide = m1 * v0
    high = wide * np.sqrt(1.0 + balls.masses[1] / m1)
    for level in (wide + high, wide - high):
        axes.axhline(level, color=GREY, linewidth=0.8, linestyle=':')
    axes.axvline(2.0 * wide, color=GREY, linewidth=0.8, linestyle=':')
    places = ('I', 0.5, 0.25), ('II', 1.2, 0.75), ('III', 0.5, 0.95), ('IV', 1.58, 1.85)
    for text, x, y in places:
        axes.annotate(text, (x * wide, y * wide), ha='center', va='center', fontsize=11)
    axes.text(
        1.04,
        0.5,
        'I  both impacts compress\nII  ball on ball restores\n'
        'III  ball on table restores\nIV  both restore:\n      here it ends\n\n'
        '●  (0, 0) and −2 m₁v₀ (1, 1)',
        transform=axes.transAxes,
        va='center',
        fontsize=9,
    )
    axes.plot([0.0, 2.0 * wide], [0.0, 2.0 * wide], 'o', color='black', markersize=4)
    axes.set_title(
        'Two balls on a table: energy keeps the impulses inside the ellipse', fontsize='medium'
    )
    axes.legend(loc='upper left', bbox_to_anchor=(1.0, 0.3), fontsize='small', frameon=False)
    save(figure, path)


def draw_two_balls(balls: TwoBalls, path: Path) -> None:
    """Write one collision: its curve of impulses, its elastic energies, a table of its states."""
    trace = balls.trace()
    states = balls.states(trace)
    figure = new_figure(11.0, 6.6)
    left, right = figure.subplots(1, 2)
    figure.get_layout_engine().set(rect=(0.0, 0.2, 1.0, 0.8))
    _plane(left, balls)
    _curve(left, trace, states)
    _energies(right, balls, trace, states)
    _table(figure, balls, trace, states)
    kinetic = balls.kinetic_energy(normal_impulses(trace)[[0, -1]])
    figure.suptitle(
        f'Two balls on a table: states {" ".join(state.name for state in states)}, '
        f'{kinetic[0] - kinetic[1]:.4f} J of {kinetic[0]:.4g} J are lost\n'
        f'm₁ = {balls.masses[0]:g} kg, m₂ = {balls.masses[1]:g} kg, k₂/k₁ = {balls.ratio:g}, '
        f'e₁² = {balls.restitution[0] ** 2:.3g}, e₂² = {balls.restitution[1] ** 2:.3g}, '
        f'v₀ = −{-balls.v0:g} m/s, law {balls.law}',
        fontsize='medium',
    )
    save(figure, path)


def draw_ping_pong(path: Path) -> None:
    """Write the velocities of two ping-pong balls after one falls on the other."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    speeds = np.array([2.0, 4.0])
    laws = {'energetic': '-', 'bistiffness': '--'}
    found = {law: TwoBalls(restitution=PING_PONG, v0=-1.0, law=law).outcome() for law in laws}
    for ball, (name, colour) in enumerate((('upper', BLUE), ('lower', VERMILION))):
        highest = max(parts[ball] for parts in found.values())
        for law, parts in found.items():
            part = parts[ball]
            above = part == highest
            axes.plot(speeds, part * speeds, laws[law], color=colour)
            axes.annotate(
                f'{name} ball, {law}: {part:.4f} |v₀|',
                (3.0, 3.0 * part),
                (-5, 5) if above else (5, -5),
                textcoords='offset points',
                ha='right' if above else 'left',
                va='bottom' if above else 'top',
                fontsize='small',
                color=colour,
            )
    axes.set(
        xlabel='speed of the falling ball |v₀| (m/s)',
        ylabel='velocity upward (m/s)',
        xlim=speeds,
        ylim=(0.0, None),
    )
    axes.grid(alpha=0.3)
    upper = ' or '.join(f'{parts[0]:.2f}' for parts in found.values())
    axes.set_title(
        f'Ping-pong balls on plexiglass: the upper ball flies off at {upper} |v₀|\n'
        'e₁ = 0.807755, e₂ = 0.846529, k₂/k₁ = 10',
        fontsize='medium',
    )
    save(figure, path)


def _plane(axes: Any, balls: TwoBalls) -> None:
    """Draw the ellipse and the two lines of compression."""
    edge = balls.ellipse()
    axes.fill(edge[:, 0], edge[:, 1], color=SKY, alpha=0.12, linewidth=0)
    axes.plot(edge[:, 0], edge[:, 1], color=SKY, linewidth=1.4, label='all energy kinetic (15)')
    low, high = edge.min(axis=0), edge.max(axis=0)
    first = np.linspace(low[0], high[0], 2)
    for second, dashes, text in zip(
        balls.compression_lines(first),
        ('--', '-.'),
        ('ℓ₁: ball on ball turns', 'ℓ₂: ball on table turns'),
        strict=True,
    ):
        axes.plot(first, second, dashes, color=GREY, linewidth=1.2, label=text)
    margin = 0.06 * (high - low)
    axes.set(
        xlim=(low[0] - margin[0], high[0] + margin[0]),
        ylim=(low[1] - margin[1], high[1] + margin[1]),
        aspect='equal',
        xlabel='I₁, ball on ball (N s)',
        ylabel='I₂, ball on table (N s)',
    )
    axes.axhline(0.0, color='black', linewidth=0.6)
    axes.axvline(0.0, color='black', linewidth=0.6)


def _curve(axes: Any, trace: CollisionTrace, states: list[ImpactState]) -> None:
    impulses = normal_impulses(trace)
    numbers: dict[str, list[str]] = {}
    for number, state in enumerate(states, 1):
        x, y = impulses[state.samples].T
        numbers.setdefault(state.name, []).append(str(number))
        axes.plot(x, y, color=STATE_COLOURS[state.name], linewidth=2.2)
        axes.plot(x[-1], y[-1], 'o', color='black', markersize=3.5, zorder=5)
        middle = len(x) // 3
        axes.annotate(
            str(number),
            (x[middle], y[middle]),
            NUMBER_OFFSETS[state.name],
            textcoords='offset points',
            fontsize=10,
            color=STATE_COLOURS[state.name],
        )
    for name, which in numbers.items():
        axes.plot(
            [],
            [],
            color=STATE_COLOURS[name],
            linewidth=2.2,
            label=f'{", ".join(which)}: {name}, {STATE_MEANINGS[name]}',
        )
    axes.legend(loc='upper left', bbox_to_anchor=(1.0, 1.0), fontsize='small', frameon=False)
    axes.set_title('(a) impulses', fontsize='medium', loc='left')


def _energies(
    axes: Any, balls: TwoBalls, trace: CollisionTrace, states: list[ImpactState]
) -> None:
    """Draw the energy of each spring over the impulse that it gave; the legend has the losses."""
    impulses, lost_until = normal_impulses(trace), balls.losses(normal_impulses(trace))
    springs = (PURPLE, 'E₁, ball on ball'), (GREEN, 'E₂, ball on table')
    for j, (colour, name) in enumerate(springs):
        lost, counted = [], 0.0
        for part in (s.samples for s in states if trace.active[s.samples, j].all()):
            x, y = impulses[part, j], trace.energies[part, j]
            axes.plot(x, y, color=colour, linewidth=2.0)
            if part.stop == len(trace.time) or not trace.active[part.stop, j]:
                axes.plot([x[-1], x[-1]], [y[-1], 0.0], color=colour, linewidth=1.0, linestyle=':')
                end = min(part.stop, len(trace.time) - 1)  # the last impulse included
                lost.append(f'{lost_until[end, j] - counted:.3f} J')
                counted = lost_until[end, j]
        losses = ' and '.join(lost) or 'nothing'
        axes.plot([], [], color=colour, linewidth=2.0, label=f'{name}: loses {losses}')
    for number, state in enumerate(states, 1):
        for j in (0, 1):
            if trace.active[state.samples, j].all():
                end = state.samples.stop - 1
                axes.plot(
                    impulses[end, j],
                    trace.energies[end, j],
                    'o',
                    color='black',
                    markersize=3.5,
                    zorder=5,
                )
                axes.annotate(
                    str(number),
                    (impulses[end, j], trace.energies[end, j]),
                    (4, 3),
                    textcoords='offset points',
                    fontsize=9,
                )
    axes.set(
        xlabel='impulse of the same contact, I₁ or I₂ (N s)',
        ylabel='elastic energy (J)',
        xlim=(0.0, None),
    )
    axes.grid(alpha=0.3)
    axes.margins(y=0.15)  # room for the legend
    axes.set_ylim(0.0, None)
    axes.legend(loc='upper left', fontsize='small', frameon=False)
    axes.set_title(
        '(b) elastic energies; numbers: ends of the states', fontsize='medium', loc='left'
    )


def _table(figure: Any, balls: TwoBalls, trace: CollisionTrace, states: list[ImpactState]) -> None:
    """Write impulses, velocities and energies at the end of each state."""
    axes = figure.add_axes((0.06, 0.01, 0.9, 0.17))
    axes.set_axis_off()
    impulses = normal_impulses(trace)
    velocities, kinetic = balls.velocities(impulses), balls.kinetic_energy(impulses)
    rows = [
        [
            f'{number}: {state.name}',
            STATE_MEANINGS[state.name],
            state.events,
            *(
                f'{value:.4f}'.replace('-', '−')
                for value in (
                    *impulses[end],
                    *velocities[end],
                    *trace.energies[end],
                    kinetic[end],
                )
            ),
        ]
        for number, state in enumerate(states, 1)
        for end in (state.samples.stop - 1,)
    ]
    head = [
        'state',
        'acts',
        'events',
        'I₁ (N s)',
        'I₂ (N s)',
        'v₁ (m/s)',
        'v₂ (m/s)',
        'E₁ (J)',
        'E₂ (J)',
        'kinetic (J)',
    ]
    table = axes.table(rows, colLabels=head, loc='center', cellLoc='center', edges='horizontal')
    table.auto_set_font_size(False)
    table.set_fontsize(8.5)
    table.scale(1.0, 1.25)
    axes.set_title(
        '(c) at the end of each state; C: an impact ends its compression, R: its restitution',
        fontsize=9,
        loc='left',
        pad=2,
    )

"""The report of a calibration: one page that needs nothing else, for a person with a table."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from html import escape
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from billiard_shot.calibration.result import (
    advice,
    Calibration,
    Check,
    Estimate,
    KEPT,
    quantiles,
    SPANS,
)
from billiard_shot.pictures.view import write_text
from billiard_shot.table.run.outline import outline_of

Floats = NDArray[np.float64]
PATHS = '#ffffff', '#f0e442', '#e69f00', '#56b4e9', '#cc79a7', '#000000'
SPAN_NAMES = 'first second', 'first 2 s', 'first 5 s', 'whole shot'
assert len(SPAN_NAMES) == len(SPANS)
TIMES = np.array([0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])
SPEEDS = np.array([0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])
CONTACTS = np.arange(0.0, 13.0)
LEAST_SAMPLES = 20
"""Samples that a point of a chart stands for, at least."""

WIDTH, HEIGHT, LEFT, BELOW = 320, 190, 40, 34  # of a chart, and its margins


def write_report(calibration: Calibration, path: Path) -> None:
    """Write the report to a file; ValueError if that fails."""
    write_text(path, report_page(calibration))


def report_page(calibration: Calibration) -> str:
    """Make the page."""
    return styled_page(_content(calibration))


def styled_page(content: Iterable[str]) -> str:
    """Make a page of lines of HTML, in the style of the report."""
    template = files('billiard_shot.pictures') / 'page' / 'calibration.html'
    text = template.read_text(encoding='utf-8')
    return text.replace('<!-- CONTENT -->', '\n'.join(content), 1)


def _content(result: Calibration) -> Iterator[str]:
    yield '<h1>Calibration of a table</h1>'
    yield (
        f'<p class="soft">{escape(", ".join(result.recordings))}: {len(result.fitted)} shots '
        f'fitted, {len(result.checks)} held out.</p>'
    )
    if not result.converged:
        yield f'<p class="warning">{escape(result.state)}.</p>'
    yield from (f'<p class="soft">{escape(text)}.</p>' for text in result.notes)
    if result.checks:
        yield '<h2>How well the scene predicts shots that it was not fitted to</h2>'
        yield from _errors(result)
        yield '<h2>Recorded and predicted paths</h2>'
        yield from _paths(result)
        yield '<h2>Where the errors come from</h2>'
        yield '<div class="row">'
        yield from _charts(result)
        yield '</div>'
    yield '<h2>What is known of the table</h2>'
    yield from _numbers(result.estimates)
    if unknown := advice(result.estimates):
        yield '<h2>What to film next</h2><ul>'
        yield from (f'<li>{escape(text)}: decides {escape(name)}</li>' for name, text in unknown)
        yield '</ul>'
    if result.ignored:
        yield '<h2>What was ignored</h2><ul>'
        yield from (f'<li>{escape(text)}</li>' for text in result.ignored)
        yield '</ul>'


def _errors(result: Calibration) -> Iterator[str]:
    yield (
        '<p>Distance of all balls from where they were seen (root mean square of a shot), after '
        'the launch that fits best. The scene before had the same search.</p>'
        '<div class="wide"><table><tr><th></th><th colspan="3" class="now">this scene</th>'
        '<th colspan="3" class="before">the scene before</th></tr><tr><th>in cm</th>'
        + 2 * '<th>best 10 %</th><th>median</th><th>worst 10 %</th>'
        + '</tr>'
    )
    rows = zip(SPAN_NAMES, quantiles(result.checks), _quantiles(result.checks_before), strict=True)
    for name, now, before in rows:
        cells = ''.join(f'<td class="number">{100.0 * each:.1f}</td>' for each in (*now, *before))
        yield f'<tr><td>{name}</td>{cells}</tr>'
    yield '</table></div>'


def _quantiles(checks: Sequence[Check]) -> Floats:
    return quantiles(checks) if checks else np.full((len(SPANS), 3), np.nan)


def _paths(result: Calibration) -> Iterator[str]:
    """Draw the best, the median and the worst shot."""
    order = sorted(result.checks, key=Check.rmse)
    chosen = {'best': order[0], 'median': order[len(order) // 2], 'worst': order[-1]}
    yield '<p>Broad lines: as recorded; dashed lines: as predicted.</p><div class="row">'
    for title, check in chosen.items():
        yield (
            f'<figure>{_table(result, check)}<figcaption>{title}: shot '
            f'{escape(check.samples.name)}, {100.0 * check.rmse():.1f} cm</figcaption></figure>'
        )
    yield '</div>'


def _table(result: Calibration, check: Check) -> str:
    outline = outline_of(result.scene)
    x, y = outline.frame
    cushions = ''.join(
        f'<polygon points="{_points(each)}" fill="#245643"/>' for each in outline.cushions
    )
    parts = [
        f'<svg viewBox="{-x:.3f} {-y:.3f} {2 * x:.3f} {2 * y:.3f}" role="img" '
        f'aria-label="shot {escape(check.samples.name)}">'
        f'<rect x="{-x:.3f}" y="{-y:.3f}" width="{2 * x:.3f}" height="{2 * y:.3f}" rx=".04" '
        f'fill="#5d4330"/><rect x="{-outline.back[0]:.3f}" y="{-outline.back[1]:.3f}" '
        f'width="{2 * outline.back[0]:.3f}" height="{2 * outline.back[1]:.3f}" '
        f'fill="#2f6f55"/>{cushions}'
    ]
    parts += [
        f'<circle cx="{x:.3f}" cy="{-y:.3f}" r="{radius:.3f}" fill="#111"/>'
        for x, y, radius in outline.holes
    ]
    frame, samples = result.frames[check.samples.recording], check.samples
    for ball, colour in zip(range(len(samples.balls)), PATHS, strict=False):
        mine = samples.ball == ball
        rest = samples.rest[ball][np.newaxis]
        for name, places in (('seen', samples.place[mine]), ('path', check.places[mine])):
            line = frame.to_table(np.concatenate([rest, places]))
            shade = 'stroke-opacity=".45"' if name == 'seen' else ''
            parts.append(
                f'<polyline class="{name}" points="{_points(line)}" stroke="{colour}" {shade}/>'
            )
        (cx, cy) = frame.to_table(rest)[0]
        parts.append(
            f'<circle cx="{cx:.3f}" cy="{-cy:.3f}" r="{result.scene.ball.radius}" '
            f'fill="{colour}"/>'
        )
    return ''.join([*parts, '</svg>'])


def _points(line: Floats) -> str:
    return ' '.join(f'{x:.3f},{-y:.3f}' for x, y in line.tolist())


def _charts(result: Calibration) -> Iterator[str]:
    """Draw the errors over time, over speed, and over the number of contacts so far."""
    charts: tuple[tuple[str, Floats, Callable[[Check], Floats]], ...] = (
        ('time from the strike (s)', TIMES, lambda check: check.times),
        ('speed of the ball (m/s)', SPEEDS, _speeds),
        ('contacts so far', CONTACTS, _contacts_so_far),
    )
    for label, edges, column in charts:
        lines = []
        for name, checks in (('before', result.checks_before), ('now', result.checks)):
            if not checks:
                continue
            values = np.concatenate([column(check) for check in checks])
            errors = np.concatenate([check.errors for check in checks])
            lines += [(name, part, _binned(values, errors, edges, part)) for part in (0.5, 0.9)]
        yield f'<figure>{_chart(label, edges, lines)}</figure>'
    yield (
        '<p class="soft">Errors of samples: median (lines) and 90 % quantile (dashed); '
        '<span class="now">this scene</span>, <span class="before">the scene before</span>.</p>'
    )


def _speeds(check: Check) -> Floats:
    """Return the speeds of balls at their samples, from the samples around them [m/s]."""
    speeds = np.zeros(len(check.times))
    for ball in range(len(check.samples.balls)):
        mine = np.flatnonzero(check.samples.ball == ball)
        if len(mine) > 1:
            rates = np.gradient(check.samples.place[mine], check.times[mine], axis=0)
            speeds[mine] = np.linalg.norm(rates, axis=-1)
    return speeds


def _contacts_so_far(check: Check) -> Floats:
    return np.searchsorted(check.contacts, check.times).astype(float)


def _binned(
    values: Floats, errors: Floats, edges: Floats, part: float
) -> list[tuple[float, float]]:
    """Return the middles of intervals, and a quantile of the errors there [cm]."""
    points = []
    for low, high in pairwise(edges.tolist()):
        inside = errors[(values >= low) & (values < high)]
        if len(inside) >= LEAST_SAMPLES:
            points.append((0.5 * (low + high), 100.0 * float(np.quantile(inside, part))))
    return points


def _chart(
    label: str, edges: Floats, lines: Sequence[tuple[str, float, list[tuple[float, float]]]]
) -> str:
    top = max((y for _, _, points in lines for _, y in points), default=1.0)
    right = float(edges[-1])

    def place(x: float, y: float) -> str:
        across = LEFT + (WIDTH - LEFT - 10) * x / right
        return f'{across:.1f},{HEIGHT - BELOW - (HEIGHT - BELOW - 14) * y / top:.1f}'

    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="errors over {label}">']
    for share in (0.0, 0.5, 1.0):
        x, y = place(0.0, share * top).split(',')
        below = place(share * right, 0.0).split(',')[0]
        parts.append(
            f'<path d="M{x} {y}H{WIDTH - 10}" stroke="#d5dade"/>'
            f'<text x="{LEFT - 6}" y="{float(y) + 4:.1f}" text-anchor="end">'
            f'{share * top:.3g}</text><text x="{below}" y="{HEIGHT - BELOW + 14}" '
            f'text-anchor="middle">{share * right:.3g}</text>'
        )
    for name, part, points in lines:
        dashes = '' if part == 0.5 else 'stroke-dasharray="5 4"'
        path = ' '.join(place(x, y) for x, y in points)
        parts.append(
            f'<polyline points="{path}" fill="none" stroke="var(--{name})" stroke-width="1.8" '
            f'{dashes}/>'
        )
    parts.append(
        f'<text x="{WIDTH / 2}" y="{HEIGHT - 4}" text-anchor="middle">{label}</text>'
        f'<text x="4" y="10">cm</text></svg>'
    )
    return ''.join(parts)


def _numbers(estimates: Sequence[Estimate]) -> Iterator[str]:
    yield (
        '<p>Bars: intervals that hold the truth in 95 % of calibrations; grey: range of published '
        'values; line: the scene before.</p><div class="wide"><table><tr><th>number</th>'
        '<th>value</th><th></th><th>95 % interval</th><th>decided by shots</th></tr>'
    )
    for each in estimates:
        unit = f' {each.unit}' if each.unit else ''
        value = f'<td>{escape(each.name)}</td><td class="number">{each.value:.4g}{unit}</td>'
        if each.interval is None:
            yield f'<tr>{value}<td colspan="3" class="soft">{KEPT}</td></tr>'
            continue
        low, high = each.interval
        yield (
            f'<tr>{value}<td>{_interval(each)}</td><td class="number">{low:.4g} to {high:.4g}</td>'
            f'<td>{escape(", ".join(each.shots))}</td></tr>'
        )
    yield '</table></div>'


def _interval(estimate: Estimate) -> str:
    """Draw an interval beside the range of published values and the value before."""
    assert estimate.interval is not None
    low, high = estimate.interval
    shown = [low, high, estimate.before, *(estimate.published or ())]
    start, room = min(shown), (max(shown) - min(shown)) or 1.0

    def x(value: float) -> float:
        return 10.0 + 240.0 * (value - start) / room

    parts = ['<svg class="interval" viewBox="0 0 260 26" role="img" aria-label="interval">']
    if estimate.published:
        a, b = map(x, estimate.published)
        parts.append(f'<rect x="{a:.1f}" y="4" width="{b - a:.1f}" height="18" fill="#e9edf0"/>')
    parts.append(
        f'<path d="M{x(estimate.before):.1f} 3V23" stroke="var(--before)" stroke-width="2"/>'
        f'<path d="M{x(low):.1f} 13H{x(high):.1f}" stroke="var(--now)" stroke-width="5" '
        f'stroke-linecap="round"/><circle cx="{x(estimate.value):.1f}" cy="13" r="5" '
        'fill="var(--now)"/></svg>'
    )
    return ''.join(parts)

"""Tables in plain text."""

from collections.abc import Iterable, Sequence


def table(rows: Sequence[Sequence[str]]) -> str:
    """Format rows of cells as aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return '\n'.join(
        '  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def numbers(values: Iterable[float], digits: int) -> str:
    """Format numbers with `digits` digits after the decimal point, right-aligned."""
    # + 0.0 makes 0 of -0
    texts = (f'{round(value, digits) + 0.0:.{digits}f}' for value in values)
    return ' '.join(text.rjust(digits + 4) for text in texts)

"""The table of a game from above, drawn with characters."""

from itertools import product

from billiard_shot.game.state import State
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.words import ball_in_words

COLUMNS = 67
ROW = 2.0  # height of a character, in widths
CUE, POCKET, HEAD_STRING = '@', 'O', ':'


def table_text(state: State) -> str:
    """
    Draw the balls of a state on the table, with its pockets, its head string and its size [m].

    The foot of the table is to the right. Balls that are too near to each other for the size of
    the characters are drawn beside their places.
    """
    rows = round(COLUMNS * state.width / state.length / ROW)
    cells = [[' '] * COLUMNS for _ in range(rows)]
    for line in cells:
        line[COLUMNS // 4] = HEAD_STRING
    taken: set[tuple[int, int]] = set()
    labels = {ball: _label(ball) for ball in state.balls}
    for ball, label in labels.items():
        x, y = state.balls[ball]
        across = (x / state.length + 0.5) * COLUMNS - 0.5 * len(label)
        down = (0.5 - y / state.width) * rows - 0.5
        row, column = min(
            (
                place
                for place in product(range(rows), range(COLUMNS - len(label) + 1))
                if not any((place[0], place[1] + i) in taken for i in range(-1, len(label) + 1))
            ),
            key=lambda place: (ROW * (place[0] - down)) ** 2 + (place[1] - across) ** 2,
        )
        cells[row][column : column + len(label)] = label
        taken |= {(row, column + i) for i in range(len(label))}
    named = state.game.pockets
    x, y = 0.5 * state.length, 0.5 * state.width
    key = [f'{labels[ball]} {ball_in_words(ball)}' for ball in labels if not ball.isdecimal()]
    return '\n'.join(
        [
            *([_spread(*(f'{end}_left' for end in ('head', 'side', 'foot')))] if named else []),
            f'{_edge(named)} y {y:.2f}',
            *(f'|{"".join(line)}|' for line in cells),
            f'{_edge(named)} y {-y:.2f}',
            *([_spread(*(f'{end}_right' for end in ('head', 'side', 'foot')))] if named else []),
            _spread(f'x {-x:.2f}', ', '.join([*key, f'{HEAD_STRING} head string']), f'x {x:.2f}'),
        ]
    )


def _label(ball: str) -> str:
    """One or two characters for a ball."""
    if ball == CUE_BALL:
        return CUE
    return ball if ball.isdecimal() else ball[0].upper()


def _edge(pockets: bool) -> str:
    corner = POCKET if pockets else '+'
    half = '-' * ((COLUMNS - 1) // 2)
    return f'{corner}{half}{POCKET if pockets else "-"}{half}{corner}'


def _spread(left: str, middle: str, right: str) -> str:
    """Put words at the left end, in the middle and at the right end of a line."""
    text = middle.center(COLUMNS + 2)
    return left + text[len(left) : COLUMNS + 2 - len(right)] + right

"""When a gap between two bodies closes, if it is a polynomial of fourth degree in time."""

from billiard_shot.compiled import inner
from billiard_shot.numerics.quartic import first_quartic_root

HORIZON = 1e3  # s: as far as endless motions are looked at; 1e-7 of it is the shortest contact
TOUCH_GAP = 1e-10  # m
PRESSED_GAP = 5e-10  # m
MIN_CLOSING_SPEED = 1e-5  # m/s


@inner
def contact_time(
    a: float, b: float, c: float, d: float, e: float, end: float, scale: float
) -> float:
    """
    When a gap a + b t + c t^2 + d t^3 + e t^4 closes: the first such time in [0, end], or inf.

    `scale` is the polynomial's value per metre of the gap. Bodies within TOUCH_GAP of each other
    touch. If they part, the contact that is over is divided out. If they approach, they meet at
    once. If they do neither (below MIN_CLOSING_SPEED), they meet when they are pressed together by
    PRESSED_GAP.
    """
    if a <= TOUCH_GAP * scale:
        if b < -MIN_CLOSING_SPEED * scale:
            return 0.0
        if b > MIN_CLOSING_SPEED * scale:
            a, b, c, d, e = b, c, d, e, 0.0
        else:
            a = max(a + PRESSED_GAP * scale, 0.1 * PRESSED_GAP * scale)
    span = min(end, HORIZON)
    square = span * span
    return span * first_quartic_root(
        a, b * span, c * square, d * square * span, e * square * square
    )

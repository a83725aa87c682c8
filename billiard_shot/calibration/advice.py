"""Films that would decide the numbers of a scene that the shots so far do not decide."""

from collections.abc import Iterable

from billiard_shot.calibration.estimate import Estimate

FILM = {
    'cloth.sliding_friction': 'straight shots with draw that meet nothing for a metre',
    'cloth.rolling_resistance': 'slow balls that roll to rest without meeting anything',
    'cloth.rolling_rise': 'balls that roll without meeting anything, slow ones and fast ones',
    'cloth.spin_deceleration': 'slow shots with much side that come back from a far cushion',
    'contacts.ball_ball.restitution': 'full hits on a ball, and how far both balls go',
    'contacts.ball_ball.friction_fast': 'fast cuts of 30 to 60 degrees without side',
    'contacts.ball_ball.friction_slow': 'slow cuts of 30 to 60 degrees without side',
    'table.cushion.restitution': 'rolling balls straight at a cushion, slow ones and fast ones',
    'table.cushion.early_fading': 'slow balls straight at a cushion, at 0.2 to 1 m/s',
    'table.cushion.fading': 'balls straight at a cushion at 2 m/s and more',
    'table.cushion.friction': 'rolling balls at 30 to 60 degrees at a cushion, and side',
    'table.length': 'balls that bounce off both short cushions',
    'table.width': 'balls that bounce off both long cushions',
}
ANYTHING = 'more shots that go over the whole table'


def advice(estimates: Iterable[Estimate]) -> list[tuple[str, str]]:
    """Return what to film for each number that is not known, by its name."""
    return [
        (each.name, FILM.get(each.name, ANYTHING)) for each in estimates if each.interval is None
    ]

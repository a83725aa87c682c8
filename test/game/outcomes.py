"""Outcomes of shots for the tests of rules."""

from billiard_shot.game import Outcome


def outcome(state, *pots, gone=(), first='1', cushion=None, of=None, places=None, **more):
    """What a shot from a state, or from another one, did: `pots` are pairs of ball and pocket."""
    driven = {first} - {None} if cushion is None else cushion
    lost = {*gone, *(ball for ball, _ in pots)}
    left = {ball: place for ball, place in (of or state).balls.items() if ball not in lost}
    return Outcome(first, pots, tuple(gone), frozenset(driven), places=places or left, **more)


def numbers(ruling):
    """Numbers of the rules of the fouls."""
    return [foul.rule for foul in ruling.fouls]

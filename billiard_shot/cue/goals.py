"""Goals to play a shot: each shot is played once, and within a limited time."""

from collections.abc import Container

from billiard_shot.cue.outcome import GoalOutcome, RefusedError


def check_goal(
    shot_id: str, remaining: float, played: Container[str], max_validity: float
) -> None:
    """
    Check that a shot is new, and that its goal is valid for a time [s] up to `max_validity`.

    Raises
    ------
    RefusedError
        ALREADY_PLAYED, ALREADY_EXPIRED or INVALID_PLAN, with the reason.

    """
    if shot_id in played:
        raise RefusedError(
            GoalOutcome.ALREADY_PLAYED,
            f'shot_id must be new, got {shot_id!r}: the cue has been aimed for it before',
        )
    if not remaining > 0.0:
        raise RefusedError(
            GoalOutcome.ALREADY_EXPIRED,
            f'expiry must be ahead of now, got {-remaining:.3g} s ago',
        )
    if remaining > max_validity:
        raise RefusedError(
            GoalOutcome.INVALID_PLAN,
            f'expiry must be at most {max_validity:g} s ahead, got {remaining:.6g} s',
        )

"""Goals to play a shot: each shot is played once, within a limited time, and by one program."""

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


def check_stamp(stamp: float, started: float, latest: float) -> None:
    """Refuse a plan without a stamp (0), from before this program `started`, or after `latest`."""
    if not started <= stamp <= latest:  # a program that is started again has forgotten its shots
        raise RefusedError(
            GoalOutcome.INVALID_PLAN if stamp > latest else GoalOutcome.ALREADY_EXPIRED,
            f'plan.header.stamp must be from {started:.3f}, the start of the driver, to '
            f'{latest:.3f}, got {stamp:.3f} (s)',
        )

"""Shots that people type, one in a line, and shots that only a camera saw."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import product
import math
from typing import NamedTuple

from billiard_shot.game.referee import check_names, judge
from billiard_shot.game.state import Call, Decision, NO_CALL, Outcome, Ruling, State
from billiard_shot.game.strokes import ListedShot, playable_stroke
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused
from billiard_shot.scene.placement import CUE_BALL, head_string
from billiard_shot.shot.aim import azimuth_at, cut_for_pocket
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.results import POCKET_NAMES

MOVED = 0.005
"""Distance that shows that a ball has moved [m]; smaller ones may be errors of the camera."""

Places = Mapping[str, tuple[float, float]]


def possible_rulings(state: State, call: Call, places: Places) -> tuple[Ruling, ...]:
    """
    Return the rulings that pictures allow, one for each way in which the game may go on.

    Parameters
    ----------
    state : State
        Before the shot.
    call : Call
    places : mapping of str to (x, y)
        The balls that are left, at rest [m]; all others have fallen into pockets.

    """
    gone = [ball for ball in state.balls if ball not in places]
    moved = [
        ball
        for ball in state.object_balls
        if ball in gone or math.dist(state.balls[ball], places[ball]) > MOVED
    ]
    met: list[tuple[str, ...]] = [(ball,) for ball in moved] or [()]
    cushions = frozenset[str](), frozenset((*moved, CUE_BALL))
    kitchens = (False, True) if state.in_hand == 'kitchen' else (False,)
    pockets = (call.pocket, '') if call.ball in gone else ('',)  # of the called ball
    found: list[Ruling] = []
    for first, driven, kitchen, pocket in product(met, cushions, kitchens, pockets):
        outcome = Outcome(
            first_contact=first[0] if first else None,
            pocketed=tuple((ball, pocket if ball == call.ball else '') for ball in gone),
            to_cushion=driven,
            from_kitchen=kitchen,
            met=first,
            cushions_before=(0,) * len(first),
            places=places,
        )
        ruling = judge(state, call, outcome)
        if all(ruling.state != each.state for each in found):
            found.append(ruling)
    return tuple(found)


class ShotReport(NamedTuple):
    """What somebody saw of a shot."""

    first_contact: str = ''  # ball that the cue ball met first; '' if it met none
    to_cushion: Collection[str] = ()  # balls driven to a cushion after the first contact
    pockets: Mapping[str, str] = {}  # of each ball that fell; others that are gone left the table
    double_hit: bool = False  # the cue hit the cue ball twice


def told_outcome(state: State, places: Places, told: ShotReport) -> Outcome:
    """
    Complete what pictures show of a shot by what somebody saw.

    Parameters
    ----------
    state : State
        Before the shot.
    places : mapping of str to (x, y)
        The balls that are left, at rest [m].
    told : ShotReport

    Raises
    ------
    ValueError
        With the field, its value and the allowed names.

    """
    first_contact, to_cushion, pockets, double_hit = told
    gone = [ball for ball in state.balls if ball not in places]
    check_names(
        ('first_contact', (first_contact,), ('', *state.object_balls)),
        ('to_cushion', to_cushion, tuple(state.balls)),
        ('pocketed', pockets, tuple(gone)),
        ('pockets', pockets.values(), POCKET_NAMES),
    )
    return Outcome(
        first_contact=first_contact or None,
        pocketed=tuple(pockets.items()),
        off_table=tuple(ball for ball in gone if ball not in pockets),
        to_cushion=frozenset(to_cushion),
        from_kitchen=bool(first_contact) and state.balls[first_contact][0] < head_string(state),
        double_hit=double_hit,
        met=(first_contact,) if first_contact else (),
        cushions_before=(0,) if first_contact else (),
        places=places,
    )


PLACE_HELP = """\
X Y                    place the cue ball (m); 0 0 is the middle of the table
?                      this text
quit, save             ends the game, which is kept, as does Ctrl+C"""

SHOT_HELP = """\
N [SPEED [B [A]]]      play shot N of the list: speed in m/s, tip B up and A right in ball radii
aim BALL [POCKET] SPEED [B [A [ELEVATION]]]
                       send BALL into POCKET, or meet it fully; such as: aim 8 foot_left 3
A B ELEVATION AZIMUTH SPEED [BALL POCKET]
                       play any stroke (ball radii, degrees, m/s), with a call
safe ..., push ...     one of these as a safety, as a push-out
?                      this text
quit, save             ends the game, which is kept, as does Ctrl+C
If ELEVATION is left out, or is -, the cue is raised as far as clearance and your errors need.
AZIMUTH 0 points to the foot, 90 to the left side. B above 0 makes follow, below 0 draw."""

OUTCOME_HELP = """\
met BALL, cushion BALL ..., BALL POCKET, double     such as: met 3, cushion 3 cue, 3 foot_left
the ball that the cue ball met first, or none; balls that then met a cushion; the pocket of each
ball that fell; whether the cue hit the cue ball twice. All but the first may be left out."""

QUIT_WORDS = 'quit', 'exit', 'q', 'save'
"""Words that end the game."""

AIM = 'SPEED', 'B', 'A', 'ELEVATION'
"""Names of the numbers after the ball and the pocket of `aim`."""


def read_place(line: str, state: State) -> tuple[float, float]:
    """Read where the cue ball in hand is to lie [m]."""
    x, y = _numbers(line.split(), 'X Y')
    if why := state.no_place(x, y):
        raise refused((x, y), why, 'the cue ball', 'm')
    return x, y


def read_choice(line: str, state: State) -> Decision:
    """Read one of the choices of a state."""
    if line.strip() not in state.choices:
        raise refused(line.strip(), f'one of {", ".join(state.choices)}', 'choice')
    return Decision(choice=line.strip())


def read_confirmation(line: str) -> bool:
    """Read whether a shot or a place is confirmed; an empty line confirms it."""
    if line.strip() not in ('', 'u'):
        raise ValueError(f'{line.strip()!r} is neither Enter nor u')
    return not line.strip()


def read_shot(line: str, scene: Scene, state: State, listed: Sequence[ListedShot]) -> Decision:
    """Read a stroke that can be played, and its call, as in `SHOT_HELP`, for a list of shots."""
    words = line.split()
    kind = words.pop(0) if words[:1] in (['safe'], ['push']) else ''
    if kind == 'push' and state.phase != 'second':
        raise ValueError('push is allowed only in the first shot after a break of nine-ball')
    match words:
        case ['aim', ball, *rest]:
            call, stroke = _aimed(ball, rest, scene, state, listed)
        case [number, *rest] if _is_number(number) and len(rest) <= 3:
            if float(number) not in range(len(listed)):
                allowed = f'0 to {len(listed) - 1}' if listed else 'a shot'
                raise refused(number, f'{allowed} in the list', 'N')
            shot = listed[int(float(number))].call
            call, stroke = _aimed(shot.ball or '', [shot.pocket, *rest], scene, state, listed)
        case [number, *rest] if _is_number(number) and len(rest) in (4, 6):
            call, stroke = _stated(words, scene, state)
        case _:
            typed = repr(line.strip()) if line.strip() else 'an empty line'
            raise ValueError(f'{typed} is not a shot; type ? for help')
    reason = f'{kind} {call.ball} to {call.pocket}' if call.ball else line
    call = replace(call, safety=kind == 'safe', push_out=kind == 'push')
    return Decision(stroke, call, reason=reason.strip())


def read_outcome(line: str) -> ShotReport:
    """Read what somebody saw of a shot, as in `OUTCOME_HELP`."""
    met, double_hit = '', False
    driven: tuple[str, ...] = ()
    pockets: dict[str, str] = {}
    for part in line.split(','):
        match part.split():
            case ['met', ball]:
                met = ball
            case ['cushion', *balls] if balls:
                driven = (*driven, *balls)
            case ['double'] | ['double', 'hit']:
                double_hit = True
            case [ball, pocket]:
                pockets[ball] = pocket
            case _:
                raise ValueError(f'{part.strip()!r} is not understood; type ? for help')
    if not met:
        raise ValueError('met BALL, or met none, is missing; type ? for help')
    return ShotReport('' if met == 'none' else met, driven, pockets, double_hit)


def _aimed(
    ball: str, words: list[str], scene: Scene, state: State, listed: Sequence[ListedShot]
) -> tuple[Call, Stroke]:
    """Read a shot that sends a ball into a pocket, or that meets it fully."""
    _check_ball(ball, state)
    pocket = words.pop(0) if words and not _is_number(words[0]) else ''
    call = Call(ball, pocket) if pocket else NO_CALL
    if shot := next((each for each in listed if each.call == call), None):
        azimuth, words = shot.azimuth, words or [str(shot.speed)]
    else:
        azimuth = azimuth_at(scene, ball, cut_for_pocket(scene, ball, pocket) if pocket else 0.0)
    if not 1 <= len(words) <= len(AIM):
        raise refused(' '.join(words), f'1 to {len(AIM)} numbers', 'SPEED [B [A [ELEVATION]]]')
    numbers = _numbers(words, ' '.join(AIM[: len(words)]))
    speed, b, a, elevation = (*numbers, 0.0, 0.0, 0.0)[: len(AIM)]
    offsets = a, b, elevation, math.degrees(azimuth), speed
    return call, playable_stroke(scene, offsets, stated=len(numbers) == len(AIM), aimed=True)


def _stated(words: list[str], scene: Scene, state: State) -> tuple[Call, Stroke]:
    """Read any stroke, with or without a call."""
    call = NO_CALL
    if words[5:]:
        _check_ball(words[5], state)
        call = Call(words[5], words[6])
    stated = words[2] != '-'
    offsets = _numbers(
        [*words[:2], words[2] if stated else '0', *words[3:5]], 'A B ELEVATION AZIMUTH SPEED'
    )
    return call, playable_stroke(scene, offsets, stated=stated, aimed=False)


def _check_ball(ball: str, state: State) -> None:
    if ball not in state.object_balls:
        raise refused(ball, f'one of {", ".join(state.object_balls)}', 'BALL')


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _numbers(words: Sequence[str], names: str) -> list[float]:
    """Read a number for each name."""
    count = len(names.split())
    if len(words) != count or not all(map(_is_number, words)):
        raise refused(' '.join(words), f'{count} numbers' if count > 1 else 'a number', names)
    return [float(word) for word in words]

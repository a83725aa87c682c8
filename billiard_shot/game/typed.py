"""
Decisions and outcomes of shots as people type them, one in a line.

If a line is not one of the allowed ones, ValueError says so in a sentence.
"""

from collections.abc import Sequence
from dataclasses import replace
import math

from billiard_shot.game.call import Call, Decision, NO_CALL
from billiard_shot.game.placing import call_of
from billiard_shot.game.seen import Told
from billiard_shot.game.state import State
from billiard_shot.planning.shots import DirectShots
from billiard_shot.scene.errors import refused
from billiard_shot.shot.stroke import Stroke

SHOT_HELP = """\
N [SPEED [B [A]]]      play shot N of the list: speed in m/s, tip B up and A right in ball radii
A B ELEVATION AZIMUTH SPEED [BALL POCKET]
                       play any stroke (ball radii, degrees, m/s), with a call
safe N [SPEED [B [A]]] the same as a safety; push N ...: as a push-out
?                      this text
Ctrl+C                 ends the game"""

OUTCOME_HELP = """\
met BALL, cushion BALL ..., BALL POCKET, double     such as: met 3, cushion 3 cue, 3 foot_left
the ball that the cue ball met first, or none; balls that then met a cushion; the pocket of each
ball that fell; whether the cue hit the cue ball twice. All but the first may be left out."""


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


def read_shot(line: str, state: State, direct: DirectShots) -> Decision:
    """Read a stroke and its call, as in `SHOT_HELP`, where `direct` is the list."""
    words = line.split()
    kind = words.pop(0) if words and words[0] in ('safe', 'push') else ''
    if len(words) in (5, 7):
        a, b, elevation, azimuth, speed = _numbers(words[:5], 'A B ELEVATION AZIMUTH SPEED')
        call = NO_CALL
        if words[5:]:
            call = Call(ball=words[5], pocket=words[6])
            if call.ball not in state.object_balls:
                raise refused(call.ball, f'one of {", ".join(state.object_balls)}', 'BALL')
        offsets = [a, b, math.radians(elevation), math.radians(azimuth), speed]
    elif 1 <= len(words) <= 4:
        number = _numbers(words[:1], 'N')[0]
        if number not in range(len(direct)):
            raise refused(words[0], f'one of the {len(direct)} shots of the list', 'N')
        call, offsets = call_of(direct, int(number)), direct.offsets[int(number)].tolist()
        changes = _numbers(words[1:], ' '.join(('SPEED', 'B', 'A')[: len(words) - 1]))
        for place, change in zip((4, 1, 0), changes, strict=False):
            offsets[place] = change
    else:
        raise ValueError(f'{line.strip()!r} is not a shot; type ? for help')
    call = replace(call, safety=kind == 'safe', push_out=kind == 'push')
    return Decision(Stroke.from_offsets(*offsets), call)


def read_outcome(line: str) -> Told:
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
    return Told('' if met == 'none' else met, driven, pockets, double_hit)


def _numbers(words: Sequence[str], names: str) -> list[float]:
    """Read a number for each name."""
    count = len(names.split())
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise refused(' '.join(words), f'{count} numbers' if count > 1 else 'a number', names)
    return numbers

"""A person at the terminal, as a player."""

from dataclasses import replace
import math

from billiard_shot import Scene, Stroke
from billiard_shot.game.agent import scene_of
from billiard_shot.game.call import Call, Decision, NO_CALL
from billiard_shot.game.placing import call_of, direct_shots
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.planning.shots import DirectShots

HELP = """\
N [SPEED [B [A]]]      play shot N of the list: speed in m/s, tip B up and A right in ball radii
A B ELEVATION AZIMUTH SPEED [BALL POCKET]
                       play any stroke (ball radii, degrees, m/s), with a call
safe N [SPEED [B [A]]] the same as a safety; push N ...: as a push-out
?                      this text
Ctrl+C                 ends the game"""


class Person:
    """
    Asks a person for each decision.

    Parameters
    ----------
    scene : Scene
    seed : int
        Does not count.

    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._scene = scene

    def place(self, state: State) -> tuple[float, float]:
        """Ask until the place is allowed."""
        _show(state)
        while True:
            words = _ask(f'cue ball in hand ({state.in_hand}), x y (m): ').split()
            try:
                x, y = map(float, words)
            except ValueError:
                print('two numbers, such as -0.8 0.1')
                continue
            if why := state.no_place(x, y):
                print(f'the cue ball must be {why} (m)')
                continue
            return x, y

    def decide(self, state: State) -> Decision:
        """Ask until there is a choice, or a stroke that can be read."""
        if state.choices:
            while (choice := _ask(f'{" or ".join(state.choices)}: ').strip()) not in state.choices:
                pass
            return Decision(choice=choice)
        _show(state)
        scene = scene_of(self._scene, state)
        direct = direct_shots(scene, state)
        for number in range(len(direct)):
            call, chance = call_of(direct, number), 100.0 * direct.chance[number]
            print(f'{number:3}  {call.ball} to {call.pocket}, chance {chance:.0f} %')
        while True:
            line = _ask('shot (? for help): ')
            try:
                return _decision(line.split(), direct)
            except (ValueError, IndexError) as error:
                print(HELP if line.strip() == '?' else error)

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Print the ruling."""
        print(f'player {state.player}: {decision.reason or "shot"}: {ruling.text}')


def _ask(prompt: str) -> str:
    """Ask for a line; the end of the input (Ctrl+D) ends the program as Ctrl+C does."""
    try:
        return input(prompt)
    except EOFError:
        raise KeyboardInterrupt from None


def _decision(words: list[str], direct: DirectShots) -> Decision:
    """Read a decision; ValueError or IndexError if it is none."""
    safety, push = words[0] == 'safe', words[0] == 'push'
    if safety or push:
        words = words[1:]
    if len(words) >= 5:
        a, b, elevation, azimuth, speed = map(float, words[:5])
        call = Call(words[5], words[6]) if len(words) > 5 else NO_CALL
        offsets = [a, b, math.radians(elevation), math.radians(azimuth), speed]
    else:
        number = int(words[0])
        call = call_of(direct, number)
        offsets = direct.offsets[number].tolist()
        for place, word in zip((4, 1, 0), words[1:], strict=False):
            offsets[place] = float(word)
    call = replace(call, safety=safety, push_out=push)
    return Decision(Stroke.from_offsets(*offsets), call)


def _show(state: State) -> None:
    """Print where the balls lie."""
    places = (f'{ball} ({x:.2f}, {y:.2f})' for ball, (x, y) in state.balls.items())
    group = f', {state.groups[state.player]}' if state.groups[state.player] else ''
    print(f'player {state.player}{group}: {", ".join(places)}')


make = Person

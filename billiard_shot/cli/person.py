"""A person at the terminal, as a player."""

from collections.abc import Callable
from typing import TypeVar

from billiard_shot import Scene
from billiard_shot.game.agent import scene_of
from billiard_shot.game.call import Decision
from billiard_shot.game.placing import call_of, direct_shots
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.game.typed import read_choice, read_place, read_shot, SHOT_HELP

T = TypeVar('T')


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
        prompt = f'cue ball in hand ({state.in_hand}), x y (m): '
        return _ask(prompt, 'two numbers, such as -0.8 0.1', lambda line: read_place(line, state))

    def decide(self, state: State) -> Decision:
        """Ask until there is a choice, or a stroke that can be read."""
        if state.choices:
            choices = ' or '.join(state.choices)
            return _ask(f'{choices}: ', choices, lambda line: read_choice(line, state))
        _show(state)
        direct = direct_shots(scene_of(self._scene, state), state)
        for number in range(len(direct)):
            call, chance = call_of(direct, number), 100.0 * direct.chance[number]
            print(f'{number:3}  {call.ball} to {call.pocket}, chance {chance:.0f} %')
        return _ask('shot (? for help): ', SHOT_HELP, lambda line: read_shot(line, state, direct))

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Print the ruling."""
        print(f'player {state.player}: {decision.reason or "shot"}: {ruling.text}')


def _ask(prompt: str, help_text: str, read: Callable[[str], T]) -> T:
    """Ask until a line can be read; the end of the input (Ctrl+D) ends the program as Ctrl+C."""
    while True:
        try:
            line = input(prompt)
        except EOFError:
            raise KeyboardInterrupt from None
        try:
            return read(line)
        except ValueError as error:
            print(help_text if line.strip() == '?' else error)


def _show(state: State) -> None:
    """Print where the balls lie."""
    places = (f'{ball} ({x:.2f}, {y:.2f})' for ball, (x, y) in state.balls.items())
    group = f', {state.groups[state.player]}' if state.groups[state.player] else ''
    print(f'player {state.player}{group}: {", ".join(places)}')


make = Person

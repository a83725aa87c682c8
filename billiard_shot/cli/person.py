"""A person at the terminal, as a player."""

from collections.abc import Callable
import math
from typing import TypeVar

from billiard_shot import Scene
from billiard_shot.game import typed
from billiard_shot.game.rack import scene_of
from billiard_shot.game.state import CHOICES, Decision, Ruling, State
from billiard_shot.game.strokes import listed_shots
from billiard_shot.pictures.rack import table_text
from billiard_shot.shot.stroke import Stroke

T = TypeVar('T')


class Quit(KeyboardInterrupt):
    """The person ends the game by a word."""


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
        where = 'behind the head string' if state.in_hand == 'kitchen' else 'anywhere'
        prompt = f'cue ball in hand, {where}: x y (m), or ? for help: '
        while True:
            x, y = _ask(prompt, typed.PLACE_HELP, lambda line: typed.read_place(line, state))
            if _holds(f'cue ball at ({x:g}, {y:g})', 'keeps it there'):
                return x, y

    def decide(self, state: State) -> Decision:
        """Ask until there is a choice, or a stroke that can be played."""
        _show(state)
        if state.choices:
            choices = '\n'.join(f'{each:10} {CHOICES[each]}' for each in state.choices)
            print(choices)
            prompt = f'{" or ".join(state.choices)}: '
            return _ask(prompt, choices, lambda line: typed.read_choice(line, state))
        scene = scene_of(self._scene, state)
        listed = listed_shots(scene, state)
        for number, shot in enumerate(listed):
            chance = 100.0 * shot.chance
            print(f'{number:3}  {shot.call.ball} to {shot.call.pocket}, chance {chance:.0f} %')
        if not listed and state.game.pockets:
            print('no ball goes straight into a pocket')
        prompt = 'your shot, or ? for help: '
        while True:
            decision = _ask(
                prompt, typed.SHOT_HELP, lambda line: typed.read_shot(line, scene, state, listed)
            )
            if decision.stroke and _holds(_in_words(decision, decision.stroke), 'plays it'):
                return decision

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Do nothing: the command prints the rulings."""


def _ask(prompt: str, help_text: str, read: Callable[[str], T]) -> T:
    """Ask until a line can be read; `quit`, or the end of the input (Ctrl+D), ends the game."""
    while True:
        try:
            line = input(prompt)
        except EOFError:
            raise KeyboardInterrupt from None
        if line.strip().lower() in typed.QUIT_WORDS:
            raise Quit
        try:
            return read(line)
        except ValueError as error:
            print(help_text if line.strip() == '?' else error)


def _holds(what: str, does: str) -> bool:
    """Ask for the confirmation of a shot or a place that was typed."""
    choice = f'Enter {does}, u takes it back'
    return _ask(f'{what}; {choice}: ', choice, typed.read_confirmation)


def _show(state: State) -> None:
    """Draw the table, and say what the player plays."""
    print(f'\n{table_text(state)}\n{_aims(state)}')


def _aims(state: State) -> str:
    """Say which balls the player may meet first, in the words of the game, and the score."""
    legal = state.game.targets(state)
    others = [ball for ball in state.object_balls if ball not in legal]
    group = state.groups[state.player]
    if state.phase == 'break':
        text = 'you break'
    elif not others:
        text = 'you play any ball'
    elif len(legal) == 1:
        text = f'you play the {legal[0]}'
    elif group:
        text = f'you play the {group}: {", ".join(sorted(legal, key=int))}'
    else:
        text = f'you play any ball but the {", ".join(others)}'
    score = f'; {state.scores[0]} : {state.scores[1]} of {state.target} points'
    return text + (score if state.target else '')


def _in_words(decision: Decision, stroke: Stroke) -> str:
    a, b, elevation, azimuth, speed = stroke.offsets
    return (
        f'{decision.reason}: {speed:.4g} m/s, tip {_signed(b)} up and {_signed(a)} right, '
        f'azimuth {math.degrees(azimuth):.1f}°, elevation {math.degrees(elevation):.1f}°'
    )


def _signed(offset: float) -> str:
    return f'{round(offset, 2) + 0.0:g}'  # 0, not -0


make = Person

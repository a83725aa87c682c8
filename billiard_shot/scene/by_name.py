"""Values by the names of balls."""

from typing import TypeVar

from billiard_shot.scene.errors import must_be_one_of

T = TypeVar('T')


class ByName(dict[str, T]):
    """Values by the names of balls; the error for a missing name tells which names there are."""

    def __missing__(self, name: str) -> T:
        raise KeyError(f'ball {must_be_one_of(self, name, "ball")}')

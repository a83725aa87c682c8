"""Safety inputs: a value, when it was heard, and what silence means."""
from dataclasses import dataclass
import math


@dataclass(slots=True)
class Input:
    """
    A yes-or-no input that has to be repeated; times are those of a steady clock [s].

    Parameters
    ----------
    name : str
    safe : bool
        The value that allows motion.
    timeout : float
        After so long without a word [s] it no longer does.

    """

    name: str
    safe: bool
    timeout: float
    value: bool | None = None
    heard: float = -math.inf

    def hear(self, value: bool, now: float) -> None:
        """Take note of a value."""
        self.value, self.heard = value, now

    def fresh(self, now: float) -> bool:
        """Whether it was heard lately."""
        return now - self.heard <= self.timeout

    def allows(self, now: float) -> bool:
        """Whether it was heard lately and is safe."""
        return self.value is self.safe and self.fresh(now)

    def complaint(self, now: float) -> str:
        """Why it does not allow motion."""
        if self.value is None:
            return f'{self.name}: never heard'
        if not self.fresh(now):
            return (f'{self.name}: silent for {now - self.heard:.3g} s, more than '
                    f'{self.timeout:g} s')
        return f'{self.name}: is {str(self.value).lower()}'

"""The file that keeps a latched state: a driver that starts again must not forget a stop."""

import os
from pathlib import Path

from billiard_shot.cue.safety import LATCHED_STATES, SafetyState

UNKNOWN = SafetyState.FAULT, 'state unknown: clear_fault'
"""State and reason if the file is damaged."""


def read_latched(path: Path) -> tuple[SafetyState, str] | None:
    """
    Read the latched state and its reason; None if there is no file.

    Raises
    ------
    OSError
        If the file cannot be read, or if it could not be written again.

    """
    _write_beside(path, '').unlink()
    if not path.exists():
        return None
    name, _, reason = path.read_text('utf-8', 'replace').removesuffix('\n').partition(' ')
    found = [state for state in LATCHED_STATES if state.name == name]
    return (found[0], reason) if found and reason else UNKNOWN


def write_latched(path: Path, state: SafetyState, reason: str) -> None:
    """
    Write a latched state, such that it survives a loss of power; remove the file if it is not one.

    Raises
    ------
    OSError
        If that is not possible.

    """
    if state in LATCHED_STATES:
        os.replace(_write_beside(path, f'{state.name} {reason}\n'), path)
    elif path.exists():
        path.unlink()
    else:
        return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _write_beside(path: Path, text: str) -> Path:
    """Write a file in the folder of another one, down to the disk, and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f'{path.name}.new')
    with beside.open('w', encoding='utf-8', errors='replace') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    return beside

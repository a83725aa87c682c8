"""`billiard-shot calibrate convert`: a recording as CSV."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from billiard_shot.calibration.reader import read_recording, write_csv
from billiard_shot.cli.options import option, positional


@dataclass(frozen=True)
class OfFiles:
    """
    The files.

    Parameters
    ----------
    recording : FILE
        Recording (.json or .csv).
    output : FILE.csv
        File to write.

    """

    recording: Path = positional()
    output: Path = option('-o', required=True)


OPTIONS = (OfFiles(),)


def run(options: argparse.Namespace) -> int:
    """Write the file, and say what was left out."""
    recording = read_recording(options.recording)
    write_csv(recording, options.output)
    for text in recording.ignored:
        print(f'ignored: {text}')
    print(f'{len(recording.shots)} shots in {options.output}')
    return 0

"""`billiard-shot calibrate convert`: a recording as CSV."""

import argparse
from pathlib import Path

from billiard_shot.calibration.reader import read_recording, write_csv


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the files."""
    parser.add_argument('recording', type=Path, metavar='FILE', help='recording (.json or .csv)')
    parser.add_argument(
        '-o', '--output', type=Path, required=True, metavar='FILE.csv', help='file to write'
    )


def run(options: argparse.Namespace) -> int:
    """Write the file, and say what was left out."""
    recording = read_recording(options.recording)
    write_csv(recording, options.output)
    for text in recording.ignored:
        print(f'ignored: {text}')
    print(f'{len(recording.shots)} shots in {options.output}')
    return 0

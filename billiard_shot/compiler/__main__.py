"""`python -m billiard_shot.compiler FOLDER TARGET ...`: build the library into a folder."""

from pathlib import Path
import sys

from billiard_shot.compiler.build import build

if __name__ == '__main__':
    build(Path(sys.argv[1]), sys.argv[2:])

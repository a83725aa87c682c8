"""Modules that the benchmarks share; those of the studies can be imported, too."""

from pathlib import Path
import sys

sys.path.append(str(Path(__file__).resolve().parents[2]))

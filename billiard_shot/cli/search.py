"""Options of the search for strokes, for all commands that plan."""

import argparse
import math

from billiard_shot.planning.noises import NOISES
from billiard_shot.scene import Noise, Scene


def add_search_arguments(parser: argparse.ArgumentParser, budget: int, of_what: str) -> None:
    """
    Add options for noise, budget and seed.

    `budget` is the default; `of_what` completes its help text.
    """
    search = parser.add_argument_group('search')
    search.add_argument(
        '--noise',
        metavar='NAME',
        choices=[*NOISES],
        help=f'execution noise: {", ".join(NOISES)} (default: that of the scene)',
    )
    search.add_argument(
        '--noise-scale',
        type=float,
        default=1.0,
        metavar='FACTOR',
        help='factor on the noise (default: %(default)g)',
    )
    search.add_argument(
        '--budget',
        type=int,
        default=budget,
        metavar='N',
        help=f'largest number of simulated strokes{of_what} (default: {budget})',
    )
    search.add_argument(
        '--seed',
        type=int,
        default=1,
        metavar='N',
        help='seed of all random numbers (default: %(default)d)',
    )


def selected_noise(options: argparse.Namespace, scene: Scene) -> Noise:
    """Select the execution noise; ValueError if an option is invalid."""
    if not 0.0 <= options.noise_scale < math.inf:
        raise ValueError(f'--noise-scale must be at least 0, got {options.noise_scale!r}')
    noise = NOISES[options.noise] if options.noise else scene.noise
    return noise.times(options.noise_scale)

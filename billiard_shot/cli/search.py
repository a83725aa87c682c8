"""Options of a search for strokes, the same for all commands that plan."""

import argparse
import math

from billiard_shot.planning.plan import NOISES
from billiard_shot.scene import Noise, Scene


def add_search_arguments(parser: argparse.ArgumentParser, budget: int, of_what: str) -> None:
    """
    Noise, budget and seed.

    `budget` is that without the option; `of_what` ends the sentence about it.
    """
    search = parser.add_argument_group('search')
    search.add_argument(
        '--noise',
        metavar='NAME',
        choices=[*NOISES],
        help=f'{", ".join(NOISES)} (the noise of the scene)',
    )
    search.add_argument(
        '--noise-times',
        type=float,
        default=1.0,
        metavar='FACTOR',
        help='makes it larger or smaller (%(default)g)',
    )
    search.add_argument(
        '--budget',
        type=int,
        default=budget,
        metavar='N',
        help=f'most strokes that are simulated{of_what} (%(default)d)',
    )
    search.add_argument('--seed', type=int, default=1, metavar='N', help='(%(default)d)')


def noise_of(options: argparse.Namespace, scene: Scene) -> Noise:
    """Noise that the options ask for; ValueError where it makes no sense."""
    if not 0.0 <= options.noise_times < math.inf:
        raise ValueError(
            f'--noise-times: {options.noise_times!r} is not allowed; it must be at least 0'
        )
    noise = NOISES[options.noise] if options.noise else scene.noise
    return noise.times(options.noise_times)

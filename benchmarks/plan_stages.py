"""
Stages of the planner: the success that each one contributes.

Pots in bins of cut angle and distance, and crowded tables. Each stage is switched off in turn, and
all plans have the same time. The success of each plan is that of its held-out trials.

    python benchmarks/plan_stages.py [--full]
"""

import argparse
from contextlib import contextmanager

import numpy as np
from tools.plan_scenes import crowded_scene, pot_scene, TOURNAMENT

from billiard_shot import plan
from billiard_shot.planning import search

SECONDS = 1.0  # for a plan
BUDGET = 1_000_000  # strokes: more than a plan has time for


@contextmanager
def without(**changes):
    """Change names of the search for a while."""
    before = {name: getattr(search, name) for name in changes}
    for name, value in changes.items():
        setattr(search, name, value)
    try:
        yield
    finally:
        for name, value in before.items():
            setattr(search, name, value)


def no_points(*_):
    """Find no places to send the cue ball to."""
    return []


def no_curves(problem, *_):
    """Make no candidates along curved paths."""
    return search.candidates_along(problem, [])


def only_pairs(wanted):
    """Make candidates only for wanted pairs of cushions, (after, before)."""
    make = search._cushion_candidates
    return lambda problem, runner, cushions, count: make(
        problem, runner, list(filter(wanted, cushions)), count
    )


VARIANTS = {
    'all stages': {},
    'without combinations': {'combinations': no_points},
    'without curved paths': {'_curved_candidates': no_curves},
    'without banks': {'_cushion_candidates': only_pairs(lambda pair: pair[0] == 0)},
    'without kicks': {'_cushion_candidates': only_pairs(lambda pair: pair[1] == 0)},
    'without cushions': {'CUSHIONS_BELOW': -1.0},
    'without two cushions and random strokes': {'RANDOM_BELOW': -1.0},
    'one round': {'MAX_ROUNDS': 1},
    'all kinds at once': {'DETOURS_BELOW': 2.0, 'CUSHIONS_BELOW': 2.0, 'CURVES_BELOW': 2.0},
}


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('--full', action='store_true')
    count = 50 if parser.parse_args().full else 10
    draw = np.random.default_rng(41)
    groups = {
        'pots': [pot_scene(draw, i % 5, i % 3) for i in range(count)],
        'crowded tables': [(crowded_scene(draw), {'pot': '8'}) for _ in range(count)],
    }
    plan(*groups['pots'][0], budget=500)  # compiles and loads the library
    for name, scenes in groups.items():
        print(f'{name}: {count}')
        everything = None
        for variant, changes in VARIANTS.items():
            with without(**changes):
                results = [
                    plan(*each, noise=TOURNAMENT, seed=i, budget=BUDGET, time_limit=SECONDS)
                    for i, each in enumerate(scenes)
                ]
            success = 100.0 * np.array(
                [each.best.success if each.best else 0.0 for each in results]
            )
            everything = success if everything is None else everything
            change = success - everything
            error = change.std(ddof=1) / np.sqrt(count)
            print(
                f'    {variant:42s} {success.mean():5.1f} %  {change.mean():+5.1f} +- {error:.1f}'
                f'  {np.median([each.simulations for each in results]):7.0f} strokes'
            )


if __name__ == '__main__':
    main()

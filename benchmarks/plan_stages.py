"""
Stages of the planner: the success that each one contributes.

Pots in bins of cut angle and distance, and crowded tables. Each stage is switched off in turn, and
all plans have the same time. The success of each plan is that of its held-out trials.

    python benchmarks/plan_stages.py [--full]
"""

import argparse
from contextlib import contextmanager
from functools import partial

import numpy as np
from tools.plan_scenes import crowded_scene, pot_scene, TOURNAMENT

from billiard_shot import plan
from billiard_shot.planning import search, stages

SECONDS = 1.0  # for a plan
BUDGET = 1_000_000  # strokes: more than a plan has time for


@contextmanager
def changed(module, **changes):
    """Change names of a module for a while."""
    before = {name: getattr(module, name) for name in changes}
    for name, value in changes.items():
        setattr(module, name, value)
    try:
        yield
    finally:
        for name, value in before.items():
            setattr(module, name, value)


def kinds_but(*names):
    """Leave out kinds of candidates."""
    return {'KINDS': tuple(kind for kind in stages.KINDS if kind.name not in names)}


def only_pairs(wanted):
    """Make candidates only for wanted pairs of cushions, (after, before)."""
    kinds = []
    for kind in stages.KINDS:
        if 'cushion' in kind.name:
            pairs, count = kind.make.args
            make = partial(kind.make.func, list(filter(wanted, pairs)), count)
            kind = kind._replace(make=make)
        kinds.append(kind)
    return {'KINDS': tuple(kinds)}


VARIANTS = {
    'all stages': (stages, {}),
    'without combinations': (stages, kinds_but('combinations')),
    'without curved paths': (stages, kinds_but('curves')),
    'without banks': (stages, only_pairs(lambda pair: pair[0] == 0)),
    'without kicks': (stages, only_pairs(lambda pair: pair[1] == 0)),
    'without cushions': (stages, kinds_but('one cushion', 'two cushions')),
    'without two cushions and random strokes': (
        stages,
        {**kinds_but('two cushions'), 'RANDOM_BELOW': -1.0},
    ),
    'one round': (search, {'MAX_ROUNDS': 1}),
    'all kinds at once': (
        stages,
        {'KINDS': tuple(kind._replace(below=2.0) for kind in stages.KINDS)},
    ),
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
    for name, scenes in groups.items():
        print(f'{name}: {count}')
        everything = None
        for variant, (module, changes) in VARIANTS.items():
            with changed(module, **changes):
                results = [
                    plan(*each, noise=TOURNAMENT, seed=i, budget=BUDGET, seconds=SECONDS)
                    for i, each in enumerate(scenes)
                ]
            success = 100.0 * np.array(
                [each.best.success if each.best else 0.0 for each in results]
            )
            everything = success if everything is None else everything
            gain = success - everything
            error = gain.std(ddof=1) / np.sqrt(count)
            print(
                f'    {variant:42s} {success.mean():5.1f} %  {gain.mean():+5.1f} +- {error:.1f}'
                f'  {np.median([each.simulations for each in results]):7.0f} strokes'
            )


if __name__ == '__main__':
    main()

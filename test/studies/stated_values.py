"""
The values that the hard cases state, from the slow check of test/impact.

    python test/studies/stated_values.py > studies/hard_cases.csv

Nothing here uses the solver. The slow check runs with two step sizes: the accuracy that is stated
is 20 times their difference, or five times the spread that it finds itself. Cases that it does not
finish state a limit in closed form, or no value.
"""

import csv
from dataclasses import replace
import math
from pathlib import Path
import sys

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / 'impact'))

from slow_check import slow_collide

from studies.collisions import stacked
from studies.hard_case_families import families

LAWS = ('bistiffness', 'energetic')
WORST = 1e-3  # of the speed: a value known less well states nothing
# Steps a period, and periods, of the fastest spring.
EFFORTS = ((400, 100), (4_000, 100), (400, 20_000), (40, 20_000))

COLUMNS = 'family', 'member', 'law', 'within', 'motion'


def as_dictionaries(case):
    """Bodies and contacts as `slow_collide` takes them."""
    bodies = []
    for body in case.bodies:
        names = 'mass', 'inertia', 'velocity', 'spin', 'position', 'guide', 'end_mass'
        entry = {name: getattr(body, name) for name in names}
        bodies.append({name: value for name, value in entry.items() if value is not None})
    names = 'a', 'b', 'point', 'normal', 'restitution', 'friction', 'stiffness'
    return bodies, [{name: getattr(contact, name) for name in names} for contact in case.contacts]


def slow_motion(case, law, steps, periods):
    """Motion after a collision by the slow check, whether that finished, and its spread."""
    if any(contact.restitution == 0.0 for contact in case.contacts):
        law = 'energetic'  # at e = 0, as at e = 1, the laws agree; the slow check knows it so
    answer = slow_collide(
        *as_dictionaries(case), law=law, exponent=case.exponent, steps=steps, periods=periods
    )
    return case.motion(answer.velocities, answer.spins), answer.finished, answer.spread


def closed_form(family, member, case, law):
    """Limits: (accuracy, motion), or None."""
    e = [contact.restitution for contact in case.contacts]
    if family == "Newton's cradle" and not any(e):  # all together
        count = len(case.bodies)
        return 1e-6, np.tile((1 / count, 0, 0), count)
    if family == 'stiffness ratio' and member == '1e8, stacked':
        return 1e-3, np.array([0, 0, e[0], 0, 0, 0])  # the lower ball as good as fixed
    if family == 'stiffness ratio' and member == '1e-8, stacked':
        # First the balls alone; the table slows the lower one until both go at one speed; then
        # they go down and up together. Energies in m v^2.
        energy = 0.5 * e[0] + 0.25 * (1.0 - e[0]) ** 2
        together = e[1] * math.sqrt(energy)
        return 1e-3, np.array([0, 0, together, 0, 0, together])
    if member.endswith('jammed by friction'):  # the walls hold it
        return 1e-9, np.zeros(6)
    return None


def stated(family, member, case, law):
    """(accuracy, alternatives) of a case, or None."""
    if (limit := closed_form(family, member, case, law)) is not None:
        return limit[0], (limit[1],)
    if family == 'end and reactivation at once' and law == 'energetic':
        ratio = case.contacts[1].stiffness
        sides = [
            slow_motion(stacked(ratio=ratio * (1 + side)), law, 4000, 60)[0]
            for side in (-1e-5, 1e-5)
        ]
        return 1e-3, tuple(sides)
    for steps, periods in EFFORTS:
        if family == 'stiffness ratio' and '8' in member and steps > 100:
            continue
        rough, done, _ = slow_motion(case, law, steps // 2, periods)
        if not done:
            continue
        fine, _, spread = slow_motion(case, law, steps, periods)
        spread = spread if spread < np.inf else 0.0  # infinite: other states, perhaps tiny ones
        within = max(20.0 * np.abs(fine - rough).max(), 5.0 * spread, 1e-7)
        if within < WORST:
            digits = 10.0 ** math.floor(math.log10(within))
            return math.ceil(within / digits) * digits, (fine,)
    return None


def rows(key, value):
    """Rows of the table for one case, one for each alternative."""
    within, alternatives = value
    for motion in alternatives:
        numbers = (0.0 if abs(x) < 1e-12 else x for x in motion)
        yield *key, f'{within:.0e}', ' '.join(f'{x:.9g}' for x in numbers)


def main():
    """Print the table."""
    table = csv.writer(sys.stdout, lineterminator='\n')
    table.writerow(COLUMNS)
    for family in families():
        for member, case in family.members.items():
            for law in LAWS:
                value = stated(family.name, member, replace(case), law)
                key = family.name, member, law
                print(f'{key} {value and value[0]}', file=sys.stderr)
                if value is not None:
                    table.writerows(rows(key, value))
                    sys.stdout.flush()


if __name__ == '__main__':
    main()

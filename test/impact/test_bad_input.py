"""Input that makes no sense is refused by name, value and range."""

import numpy as np
import pytest

from billiard_shot.impact import Body, collide, Contact

UP = (0.0, 0.0, 1.0)


def contact(**changes):
    return Contact(**{'a': 0, 'b': 1, 'point': (0, 0, 0), 'normal': UP, **changes})


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('mass', 0.0),
        ('mass', -1.0),
        ('mass', np.nan),
        ('velocity', (0.0, np.nan, 0.0)),
        ('velocity', (0.0, 1.0)),
        ('spin', (0.0, np.inf, 0.0)),
        ('position', (0.0, 0.0, np.nan)),
        ('inertia', -1.0),
        ('inertia', (1.0, 2.0, 0.0)),
        ('inertia', np.ones((3, 3))),
        ('inertia', np.triu(np.ones((3, 3)))),
        ('orientation', (0.0, 0.0, 0.0, 0.0)),
        ('guide', (0.0, 0.0, 0.0)),
    ],
)
def test_bodies(field, value):
    with pytest.raises(ValueError, match=field):
        Body(**{'mass': 1.0, field: value})


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('normal', (0.0, 0.0, 0.0)),
        ('normal', (0.0, np.nan, 1.0)),
        ('point', (0.0, np.inf, 1.0)),
        ('restitution', -0.1),
        ('restitution', 1.1),
        ('restitution', np.nan),
        ('friction', -0.1),
        ('friction', np.inf),
        ('stiffness', 0.0),
        ('stiffness', np.nan),
        ('exponent', 0.9),
    ],
)
def test_contacts(field, value):
    with pytest.raises(ValueError, match=field):
        contact(**{field: value})


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('law', 'newton'),
        ('exponent', 0.0),
        ('exponent', np.nan),
        ('tolerance', 0.0),
        ('tolerance', -1e-6),
        ('tolerance', np.nan),
    ],
)
def test_options(field, value):
    with pytest.raises(ValueError, match=field):
        collide([Body(mass=1.0, velocity=(0, 0, -1)), Body.fixed()], [contact()], **{field: value})


@pytest.mark.parametrize(('a', 'b'), [(0, 0), (0, 2), (-1, 0)])
def test_contacts_between_bodies_that_are_not_there(a, b):
    with pytest.raises(ValueError, match=r'\b(a|b)\b'):
        collide([Body(mass=1.0), Body.fixed()], [contact(a=a, b=b)])

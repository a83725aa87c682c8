"""
Simultaneous frictional impacts between rigid bodies.

Knows nothing of billiards. `collide` is the front door; `impulse_scheme` holds the paper's own
method, to compare with.
"""

from billiard_shot.impact.bodies import Body, Contact
from billiard_shot.impact.collide import collide, CollisionResult, Ending, Phase

__all__ = ['Body', 'CollisionResult', 'Contact', 'Ending', 'Phase', 'collide']

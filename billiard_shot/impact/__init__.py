"""
Simultaneous frictional impacts between rigid bodies.

This layer does not depend on billiards. Its public function is `collide`. The paper's own method,
for comparison, is in studies/impulse_scheme.py.
"""

from billiard_shot.impact.bodies import Body, Contact
from billiard_shot.impact.collide import collide, CollisionResult, Ending, Phase

__all__ = ['Body', 'CollisionResult', 'Contact', 'Ending', 'Phase', 'collide']

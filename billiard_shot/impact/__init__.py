"""
Simultaneous frictional impacts between rigid bodies.

This layer does not depend on billiards. Its public function is `collide`. The paper's own method,
for comparison, is in studies/impulse_scheme.py.
"""

from billiard_shot.impact.collide import Body, collide, CollisionResult, Contact, Ending, Phase

__all__ = ['Body', 'CollisionResult', 'Contact', 'Ending', 'Phase', 'collide']

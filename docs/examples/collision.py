"""Draw impulses and energies of two balls that collide on a table."""

from pathlib import Path

from billiard_shot import Body, Contact
from billiard_shot.pictures.history import draw_collision

bodies = [Body(mass=1.0, velocity=(0, 0, -3)), Body(mass=1.0), Body.fixed()]
contacts = [
    Contact(a=0, b=1, point=(0, 0, 0.06), normal=(0, 0, 1), restitution=0.95, stiffness=1.0),
    Contact(a=1, b=2, point=(0, 0, 0), normal=(0, 0, 1), restitution=0.63, stiffness=10.0),
]
draw_collision(bodies, contacts, Path('collision.png'), law='energetic')

"""Let a ball fall onto a second ball, which lies on a table."""

from billiard_shot import Body, collide, Contact

result = collide(
    [Body(mass=1.0, velocity=(0, 0, -3)), Body(mass=1.0), Body.fixed()],
    [
        Contact(a=0, b=1, point=(0, 0, 0.06), normal=(0, 0, 1), restitution=0.9**0.5),
        Contact(a=1, b=2, point=(0, 0, 0), normal=(0, 0, 1), restitution=0.4**0.5, stiffness=10.0),
    ],
    law='energetic',
)
for phase in result.phases:
    print(phase.active, phase.ending.name, phase.impulses[:, 2].round(4), phase.energies.round(4))
print(result.dissipated[:, 0].sum().round(4), 'J lost')  # 1.2494 J lost

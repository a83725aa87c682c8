"""
The shaft of a cue: a spring and a dashpot that hold the light end of the cue to its axis.

A mass with a spring and a dashpot stands for the bending shaft, whose waves carry the motion of
its end away: within 0.6 percent of the cue's speed, level strikes agree with those of a chain of
masses on a beam.

In a collision the shaft is a contact of the tip that has no normal force. Along its tangents,
which are normal to the axis, it pulls the tip back with spring * shift + damping * velocity.

Shafts are the last contacts of a collision; the log of phases leaves them out.

The end still swings when tip and ball have parted. Then the collision goes on as long as the
swing can bring the tip back to the ball, but no longer than `Model.swing`.
"""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.moving_bodies import PLACE_ROWS, separation_coefficient
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.state import (
    ContactState,
    FREE,
    INACTIVE,
    SHAFT,
    slip_speed,
    Workspace,
)


@inner
def logged_contacts(contacts: list[ContactState]) -> int:
    """Return the number of contacts that are not shafts."""
    count = len(contacts)
    while count > 0 and contacts[count - 1].normal_mode == SHAFT:
        count -= 1
    return count


@inner
def may_strike_again(contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether an end that swings may still bring its tip back to a ball."""
    for j in range(len(contacts)):
        shaft = contacts[j]
        if shaft.normal_mode == SHAFT:
            response = ws.delassus[3 * j + 1][3 * j + 1]
            stiffness = shaft.spring * response  # of the swing: its squared frequency
            rate = max(shaft.damping * response, sqrt(stiffness))
            x, y, speed = shaft.shift_1[0], shaft.shift_2[0], slip_speed(shaft)
            aside = sqrt(x * x + y * y)
            if speed + rate * aside > METHOD_OPTIONS.swing_left:
                fastest = sqrt(speed * speed + stiffness * aside * aside)
                for k in range(len(contacts)):
                    c = contacts[k]
                    opens = c.normal_mode == INACTIVE and c.hold == FREE
                    if opens and c.body_a == shaft.body_a and reaches(c, shaft, ws, fastest):
                        return True
    return False


@inner
def reaches(c: ContactState, shaft: ContactState, ws: Workspace, fastest: float) -> bool:
    """Whether tip and ball approach if the end swings back as fast as it can, or stops."""
    x, y, z = separation_coefficient(c, ws, PLACE_ROWS, 0)
    size = sqrt(x * x + y * y + z * z)
    swings = 0.0  # along the line of centres
    for k, along in enumerate((x, y, z)):
        across = shaft.slip_1[0] * shaft.tangent_1[k] + shaft.slip_2[0] * shaft.tangent_2[k]
        swings += along * across / size
    axis = ws.bodies[c.body_a].axis
    cosine = (x * axis[0] + y * axis[1] + z * axis[2]) / size
    sideways = sqrt(max(1.0 - cosine * cosine, 0.0))
    return c.velocity[0] - swings < sideways * fastest

"""
The strike in MuJoCo (extra `compare`), at a time step: the result of a general simulator.

Its contacts are soft and convex (Todorov 2014): springs and dampers relative to the contact's own
effective mass. A duration can be set, but no stiffness. The ratio of the two durations follows
from the ratio of the stiffnesses. Restitution comes from the damping. MuJoCo's model differs from
the library's, so its result does not converge to the library's.
"""

from collections.abc import Callable
import math

import numpy as np

from billiard_shot.records import Array
from billiard_shot.study.problem import Answer, ContactProblem

DURATION = 1e-3  # s, of a contact: that of a leather tip
LASTING = 12.0  # durations until all is over
TIP_RADIUS = 0.005  # m, radius of the cue's tip

MODEL = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="implicitfast" cone="elliptic"
          impratio="10" iterations="100" tolerance="1e-12"/>
  <worldbody>
    <geom name="table" type="plane" size="5 5 0.1" contype="0" conaffinity="0"/>
    <body name="ball" pos="0 0 {radius}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
      <geom name="ball" type="sphere" size="{radius}" contype="0" conaffinity="0"/>
    </body>
    <body name="cue" pos="{tip}">
      <joint name="cue" type="slide" axis="{axis}"/>
      <inertial pos="0 0 0" mass="{cue}" diaginertia="1 1 1"/>
      <geom name="tip" type="sphere" size="{size}" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="tip" geom2="ball" condim="3" friction="{friction[0]} {friction[0]} 0 0 0"
          solref="{spring[0]}" solimp="0.99 0.99 0.001"/>
    <pair geom1="ball" geom2="table" condim="3" friction="{friction[1]} {friction[1]} 0 0 0"
          solref="{spring[1]}" solimp="0.99 0.99 0.001"/>
  </contact>
</mujoco>
"""


def spring_of(restitution: float, duration: float) -> str:
    """Stiffness and damping for a bounce of a unit mass with this restitution and duration."""
    loss = -math.log(max(restitution, 1e-3))
    frequency = math.pi / duration
    return f'{-(frequency**2 + (loss / duration) ** 2)} {-2.0 * loss / duration}'


def mujoco_strike(problem: ContactProblem, step: float) -> Callable[[], Callable[[], Answer]]:
    """
    Prepare a strike in time steps of `step` seconds; see `accuracy.Run`.

    Raises
    ------
    ModuleNotFoundError
        Without the extra `compare`.

    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(_description(problem, step))
    data = mujoco.MjData(model)
    count = math.ceil(LASTING * DURATION / step)
    turn = np.zeros(9)

    def run() -> Callable[[], Answer]:
        mujoco.mj_resetData(model, data)
        data.qvel[6] = problem.stroke.speed
        mujoco.mj_step(model, data, count)
        return read

    def read() -> Answer:
        mujoco.mju_quat2Mat(turn, data.qpos[3:7])  # MuJoCo has spins in the body's frame
        return data.qvel[:3].copy(), turn.reshape(3, 3) @ data.qvel[3:6], count

    return run


def _description(problem: ContactProblem, step: float) -> str:
    surface, n = problem.model.surface, np.array(problem.stroke.normal)
    ratio = math.sqrt(float(problem.stiffness[0] / problem.stiffness[1]))
    c = np.array(problem.stroke.velocity) / problem.stroke.speed
    place = np.array([0.0, 0.0, surface.radius]) + (surface.radius + TIP_RADIUS) * n

    def text(vector: Array) -> str:
        return ' '.join(map(repr, vector.tolist()))

    return MODEL.format(
        step=step,
        radius=surface.radius,
        mass=surface.mass,
        inertia=surface.inertia,
        tip=text(place),
        axis=text(c),
        cue=problem.model.cue_mass,
        size=TIP_RADIUS,
        friction=problem.friction.tolist(),
        spring=(
            spring_of(float(problem.restitution[0]), DURATION),
            spring_of(float(problem.restitution[1]), DURATION * ratio),
        ),
    )

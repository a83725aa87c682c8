import json
import os
import subprocess
import sys

import pytest

from billiard_shot import predict, Scene, Stroke

CODE = """
import json
from billiard_shot import predict, Scene, Stroke
shot = predict(Scene.load('paper'), Stroke((-1, -2, 1), (0, 0, -2)), tolerance=1e-9)
rest = shot.trajectory.final_position
print(json.dumps([shot.velocity.tolist(), shot.spin.tolist(), rest.tolist()]))
"""


def test_plain_python_gives_the_same():
    environment = {**os.environ, 'BILLIARD_SHOT_INTERPRET': '1'}
    done = subprocess.run(
        [sys.executable, '-W', 'error', '-c', CODE],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    shot = predict(Scene.load('paper'), Stroke((-1, -2, 1), (0, 0, -2)), tolerance=1e-9)
    velocity, spin, rest = json.loads(done.stdout)
    assert velocity == pytest.approx(shot.velocity, rel=1e-12)
    assert spin == pytest.approx(shot.spin, rel=1e-11, abs=1e-12)
    assert rest == pytest.approx(shot.trajectory.final_position, rel=1e-10)

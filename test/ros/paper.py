"""The four shots of the paper, and requests for them."""

from pathlib import Path

from billiard_shot import Scene
from billiard_shot.ros.predict_shot import request_of
from billiard_shot.shot.stroke import read_strokes

SCENE = Scene.load('paper')
FILE = Path(__file__).resolve().parents[2] / 'config' / 'strokes' / 'paper.yaml'
PAPER_SHOTS = read_strokes(FILE, SCENE.cue_ball)


def request_for(name):
    """Request for a shot of the paper, at a ball at the origin."""
    request = request_of(PAPER_SHOTS[name], SCENE)
    request.header.frame_id = 'table'
    return request

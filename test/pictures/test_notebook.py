"""Objects in notebooks: a picture, and a table in degrees and per cent."""

import re
import sys

import numpy as np
import pytest

from billiard_shot import plan, predict, predict_batch, Scene, Stroke
from billiard_shot.planning.result import PlanResult
from billiard_shot.shot.shot import facts
from billiard_shot.status import Status

SCENE = Scene.load('blocked')
STROKE = Stroke.from_offsets(0.06, 0.02, elevation_deg=32.1, azimuth_deg=-1.15, speed=3.2)
BATCH = predict_batch(SCENE, offsets=[STROKE.offsets] * 3 + [(0.9, 0.9, 0.0, 0.0, 1.0)])


def test_a_stroke_is_shown_in_degrees_on_the_face_of_the_ball():
    stroke = Stroke.from_offsets(0.3, -0.001, elevation_deg=32.1, azimuth_deg=-1.15, speed=3.2)
    html = stroke._repr_html_()
    cells = re.findall(r'<td[^>]*>([^<]*)</td>', html)
    assert cells == ['+0.30, +0.00 ball radii', '32.10°', '-1.15°', '3.2 m/s']
    assert 'cx="0.3000" cy="0.0010"' in html


def test_a_scene_is_shown_with_its_balls_and_errors():
    html = SCENE._repr_html_()
    assert 'cue, 1, 8' in html
    assert f'azimuth {SCENE.noise.azimuth_deg:g}°' in html


def test_a_shot_is_shown_with_what_its_balls_do():
    shot = predict(SCENE, STROKE)
    html = shot._repr_html_()
    assert shot.message in html
    assert dict(re.findall(r'<th[^>]*>([^<]*)</th><td[^>]*>([^<]*)</td>', html)) == facts(shot)


def test_a_batch_is_shown_in_per_cent():
    html = BATCH._repr_html_()
    rows = dict(re.findall(r'<th[^>]*>([^<]*)</th><td[^>]*>([^<]*)</td>', html))
    assert rows['strokes'] == '4'
    assert (rows['OK'], rows['MISS']) == ('75 %', '25 %')
    fallen = {f'{name} falls' for name in predict(SCENE, STROKE).pocketed}
    assert {name for name in rows if name.endswith('falls')} == fallen


def test_a_plan_is_shown_as_a_ranking():
    result = plan(SCENE, {'hit': '1'}, budget=500, seed=1)
    html = result._repr_html_()
    rows = re.findall(r'<tr>(.*?)</tr>', html)
    assert len(rows) == 1 + len(result.ranking)
    for row, each in zip(rows[1:], result.ranking, strict=True):
        assert f'{100 * each.success:.0f}' in row
        assert f'{np.degrees(each.stroke.offsets[2]) + 0.0:.2f}°' in row
    nothing = PlanResult(Status.NO_PLAN, 'none <found>', (), 0, 0.0, SCENE.noise)
    assert nothing._repr_html_() == '<p><b>NO_PLAN</b>: none &lt;found&gt;</p>'


@pytest.mark.parametrize('thing', [SCENE, Scene.load('pool'), predict(SCENE, STROKE), BATCH])
def test_pictures_are_there_if_matplotlib_is(thing, monkeypatch):
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    shown = thing._repr_html_()
    picture = re.compile(r'<img alt="" src="data:image/png;base64,[^"]{5000,}">')
    assert len(picture.findall(shown)) == 1
    monkeypatch.setitem(sys.modules, 'matplotlib.figure', None)
    assert thing._repr_html_() == picture.sub('', shown)

"""The widget of notebooks: Python follows the page, and the page follows Python."""

import json
import sys

from browser import find_browser
import pytest

from billiard_shot import machine_code, predict, Scene, Stroke

pytest.importorskip('anywidget', reason='needs the extra notebook')
from billiard_shot.pictures.widget import TableWidget

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
SCENE = Scene.load('frozen_combination')
STROKE = Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3)
SHOT = predict(SCENE, STROKE)
OTHER = Stroke.from_offsets(-0.1, 0.2, 0.15, 0.5, 2)


def ends(shot):
    return {name: place.tolist() for name, place in shot.final_position.items()}


def test_a_shot_is_there_at_once():
    widget = TableWidget(SHOT)
    assert widget.stroke == STROKE
    assert ends(widget.shot) == ends(SHOT)
    assert ends(TableWidget(predict(SCENE, STROKE, 1e-9)).shot) != ends(SHOT)


def test_a_scene_waits_for_the_stroke_of_the_page():
    widget = TableWidget('frozen_combination')
    assert (widget.stroke, widget.shot) == (None, None)
    widget.stroke = STROKE
    assert ends(widget.shot) == ends(SHOT)


def test_who_is_told_of_a_stroke_finds_its_shot():
    widget, told = TableWidget(SHOT), []
    widget.observe(lambda change: told.append((change.new, ends(widget.shot))), 'stroke')
    widget.stroke = OTHER
    assert told == [(OTHER, ends(predict(SCENE, OTHER)))]
    assert widget.state['stroke']['speed'] == pytest.approx(2)


def test_the_state_of_a_page_is_a_scene_and_a_stroke():
    widget, told = TableWidget(SHOT), []
    widget.observe(lambda change: told.append(change.new), 'shot')
    offsets = {'a': 0, 'b': 0.1, 'elevation': 0.1, 'azimuth': 0.5, 'speed': 4}
    widget.state = {
        'balls': {'cue': [-0.5, 0.1], '8': [0.3, 0]},
        'stroke': offsets,
        'effects': ['throw'],
        'parameters': {'cloth.rolling_resistance': 0.02},
    }
    balls = {'balls': {'cue': [-0.5, 0.1], '8': [0.3, 0]}}
    data = SCENE.to_dict() | balls | {'effects': {'throw': 'off'}}
    scene = Scene.from_dict(data).with_parameters(['cloth.rolling_resistance'], [0.02])
    assert widget.stroke == Stroke.from_offsets(**offsets)
    assert ends(widget.shot) == ends(predict(scene, widget.stroke))
    assert told == [widget.shot]


def test_an_axis_beside_a_rounded_tip_is_shown_where_it_touches():
    scene = Scene.from_dict({'like': 'frozen_combination', 'cue': {'tip_curvature_radius': 0.01}})
    widget = TableWidget(scene)
    axis = Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3, axis=True)
    widget.stroke = axis
    assert widget.stroke == axis.touching(0.01 / scene.ball.radius) != axis
    assert ends(widget.shot) == ends(predict(scene, axis))


def test_a_reader_without_widgets_gets_the_page_of_the_last_shot():
    widget = TableWidget(SHOT, height=400)
    widget.stroke = OTHER
    data, _ = widget._repr_mimebundle_()
    html = data['text/html']
    assert 'application/vnd.jupyter.widget-view+json' in data
    assert html.startswith('<iframe srcdoc="&lt;!DOCTYPE html&gt;')
    assert 'height: 400px' in html
    assert '&quot;framed&quot;: false' in html
    assert f'&quot;azimuth&quot;: {widget.state["stroke"]["azimuth"]}' in html


def test_without_anywidget_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, 'anywidget', None)
    monkeypatch.delitem(sys.modules, 'billiard_shot.pictures.widget')
    with pytest.raises(ImportError, match=r"pip install 'billiard_shot\[notebook\]'"):
        import billiard_shot.pictures.widget  # noqa: F401


# A model with two views, as a notebook has it.
NOTEBOOK = """<!DOCTYPE html><body><script type="module">
const {{ default: {{ render }} }} = await import(URL.createObjectURL(
  new Blob([{script}], {{ type: 'text/javascript' }})));
const values = {values};
const watchers = new Set();
globalThis.saved = [];
globalThis.model = {{
  get: (name) => values[name],
  set(name, value) {{
    const same = JSON.stringify(values[name]) === JSON.stringify(value);
    values[name] = value;
    if (!same && name === 'state') [...watchers].forEach((act) => act());
  }},
  save_changes: () => saved.push(structuredClone(values.state)),
  on: (_, act) => watchers.add(act),
  off: (_, act) => watchers.delete(act),
}};
globalThis.watchers = watchers;
globalThis.views = ['left', 'right'].map(() => {{
  const el = document.body.appendChild(document.createElement('div'));
  return render({{ model, el }});
}});
</script>"""


@pytest.mark.skipif(find_browser() is None, reason='needs Chromium')
def test_page_and_widget_follow_each_other(browser, tmp_path):
    widget = TableWidget(SHOT, height=300)
    values = {name: getattr(widget, name) for name in ('page', 'height', 'state')}
    script = json.dumps(str(widget._esm)).replace('<', '\\u003c')
    text = NOTEBOOK.format(script=script, values=json.dumps(values).replace('<', '\\u003c'))
    (tmp_path / 'notebook.html').write_text(text, encoding='utf-8')
    browser.messages.clear()
    browser.open(tmp_path / 'notebook.html')
    browser.wait_for("globalThis.model?.get('estimate')?.n === 2000")
    # what the page has made of the stroke of Python
    widget.state = browser.run('model.get("state")')
    assert widget.stroke == STROKE
    assert {'noise', 'units', 'drill'} <= widget.state.keys()
    # another stroke of Python comes to both pages
    widget.stroke = OTHER
    late = "new MessageEvent('message', { source: frames[0], data: { type: 'outcome' } })"
    browser.run(  # while a page still tells of the stroke before
        f'saved.length = 0; model.set("state", {json.dumps(widget.state)});'
        f'window.dispatchEvent({late}), 0'
    )
    browser.wait_for('saved.length >= 2')
    speeds = browser.run('saved.map(({ stroke }) => stroke.speed)')
    assert {*speeds} == {widget.state['stroke']['speed']}
    widget.state = browser.run('model.get("state")')
    assert widget.stroke == OTHER
    # other windows are not listened to
    browser.run("window.postMessage({ type: 'estimate', estimate: 'x', state: {} }, '*')")
    browser.settle()
    assert browser.run('model.get("estimate") !== "x"')
    browser.run('views.forEach((end) => end())')
    assert browser.run('watchers.size') == 0
    assert browser.messages == []

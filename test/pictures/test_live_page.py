"""The page of a shot is live: what people change, and what it then shows, is what Python says."""

import base64
import contextlib
import io
import json
import math
import re
import shlex

from browser import choose, drag, find_browser, open_tab, opened
import numpy as np
import pytest
import yaml

from billiard_shot import (
    machine_code,
    predict,
    predict_batch,
    predict_within_noise,
    Scene,
    shots,
    Stroke,
    TableStates,
)
from billiard_shot.cli import main
from billiard_shot.embed.scenes import core_script
from billiard_shot.pictures.view import page_of, page_of_scene
from billiard_shot.scene.player import NOISES, OFFSETS
from billiard_shot.shot.play import prepared_scene
from billiard_shot.shot.stroke import read_strokes
from billiard_shot.table.run.outline import outline_of
from billiard_shot.table.run.results import POCKET_NAMES

pytestmark = [
    pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code'),
    pytest.mark.skipif(find_browser() is None, reason='needs Chromium'),
]
COMBINATION = predict(
    Scene.load('frozen_combination'), Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3)
)


@pytest.fixture
def page(browser, tmp_path):
    """Open the combination in the browser; it must have nothing to complain about to the end."""
    yield opened(browser, tmp_path / 'shot.html', page_of(COMBINATION, 'A combination'))
    assert browser.messages == []


# ---- to the last bit ----

EIGHT = Scene.load('eight_ball')


def test_shots_in_the_page_are_those_of_python(browser, tmp_path):
    """To the last bit: 100 strokes on a table with 16 balls, and words and events with them."""
    opened(browser, tmp_path / 'page.html', page_of_scene(EIGHT))
    draw = np.random.default_rng(5)
    low, high = (-0.5, -0.5, 0.15, -math.pi, 0.5), (0.5, 0.5, 0.6, math.pi, 9.0)
    names = ('a', 'b', 'elevation', 'azimuth', 'speed')
    for offsets in draw.uniform(low, high, (100, 5)).tolist():
        stroke = dict(zip(names, offsets, strict=True))
        found = browser.run(
            f'(view.change({{ stroke: {json.dumps(stroke)} }}), {{ ...view.outcome, '
            'events: view.shown.events.slice(1).map(({ time, text }) => [time, text]) })'
        )
        shot = predict(EIGHT, Stroke.from_offsets(*offsets))
        assert found['status'] == shot.status.name
        if shot.status.refused:
            continue
        assert found['message'] == shot.message
        assert {name: end['position'] for name, end in found['balls'].items()} == {
            name: place.tolist() for name, place in shot.run.final_position.items()
        }
        assert found['events'] == [[event.time, str(event)] for event in shot.events]


# ---- under the hand ----


def test_a_ball_is_dragged_and_the_path_follows(page):
    begin = page.run("view.state.balls['8']")
    before = page.run("view.outcome.balls['8'].position")
    radius = COMBINATION.scene.ball.radius
    place = [begin[0] - 0.3, begin[1] + 0.2]
    start, end = page.run(
        f'[{[*begin, radius]}, {[*place, radius]}].map((p) => view.project(p).slice(0, 2))'
    )
    drag(page, start, end)
    assert page.run("view.state.balls['8']") == pytest.approx(place, abs=2e-3)
    assert page.run("view.outcome.balls['8'].position") != before
    page.press('z', modifiers=2)
    assert page.run("view.state.balls['8']") == begin
    assert page.run("view.outcome.balls['8'].position") == before
    page.press('Z', modifiers=10)
    assert page.run("view.state.balls['8']") == pytest.approx(place, abs=2e-3)


def test_balls_do_not_overlap_and_stay_on_the_table(page):
    radius = COMBINATION.scene.ball.radius
    first = page.run("view.state.balls['1']")
    start = page.run(f"view.project([...view.state.balls['8'], {radius}]).slice(0, 2)")
    drag(page, start, page.run(f'view.project({[*first, radius]}).slice(0, 2)'))
    gap = np.subtract(page.run("view.state.balls['8']"), first)
    assert np.hypot(*gap) == pytest.approx(2 * radius, abs=5e-4)
    assert page.run('view.outcome.status') == 'OK'
    start = page.run(f"view.project([...view.state.balls['8'], {radius}]).slice(0, 2)")
    drag(page, start, [30, 30])
    x, y = np.abs(page.run("view.state.balls['8']"))
    assert x < COMBINATION.scene.table.length / 2
    assert y < COMBINATION.scene.table.width / 2


def test_the_ring_and_the_cue_aim(page):
    azimuth = page.run('view.state.stroke.azimuth')
    x, y = page.run('view.project(view.ring).slice(0, 2)')
    drag(page, [x, y], [x + 30, y + 30])
    turned_to = page.run('view.state.stroke.azimuth')
    assert 0.02 < abs(turned_to - azimuth) < 1
    page.press('.')
    assert page.run('view.state.stroke.azimuth') == pytest.approx(turned_to - math.radians(0.1))


def test_the_tip_is_dragged_on_the_face_of_the_ball(page):
    box = page.run("document.getElementById('face').getBoundingClientRect().toJSON()")
    middle = [box['left'] + box['width'] / 2, box['top'] + box['height'] / 2]
    radius = box['width'] / 2.24
    drag(page, middle, [middle[0] - 0.4 * radius, middle[1] - 0.2 * radius])
    stroke = page.run('view.state.stroke')
    within = 1.5 / radius  # pointers are on whole pixels
    assert [stroke['a'], stroke['b']] == pytest.approx([-0.4, 0.2], abs=within)


def test_numbers_are_typed_in_either_unit(page):
    def type_speed(value):
        page.run(
            "(() => { const box = document.querySelectorAll('#stroke [type=number]')[0];"
            f"box.value = {value}; box.dispatchEvent(new Event('input')); }})()"
        )
        return page.run('view.state.stroke.speed')

    assert type_speed(4.5) == 4.5
    choose(page, 'units', 'us')
    assert type_speed(10) == pytest.approx(4.4704)


def test_the_cue_is_raised_where_something_is_in_its_way(browser, tmp_path):
    balls = {'cue': [1.2, 0.0], '8': [0.6, 0.2]}
    scene = Scene.from_dict({'like': 'blocked', 'balls': balls})
    opened(browser, tmp_path / 'page.html', page_of_scene(scene))
    browser.run('view.aim({ azimuth: 3.1, elevation: 0.02 })')
    high = browser.run('view.state.stroke.elevation')
    assert high > 0.05
    assert browser.run('view.outcome.status') == 'OK'
    browser.run('view.aim({ azimuth: 0.0 })')
    assert browser.run('view.state.stroke.elevation') < high


# ---- what else it tells and takes ----


def test_effects_and_numbers_of_the_scene_change_the_shot_as_in_python(page):
    scene = COMBINATION.scene
    page.run("view.change({ effects: ['throw'], parameters: { 'cloth.sliding_friction': 0.31 } })")
    changed = scene.with_parameters(['cloth.sliding_friction'], [0.31]).to_dict()
    changed['effects']['throw'] = 'off'
    shot = predict(Scene.from_dict(changed), COMBINATION.stroke)
    found = page.run('view.outcome')
    assert found['message'] == shot.message != COMBINATION.message
    assert {name: end['position'] for name, end in found['balls'].items()} == {
        name: place.tolist() for name, place in shot.run.final_position.items()
    }
    open_tab(page, 'table')
    assert not page.run("document.getElementById('effect-throw').checked")
    page.wait_for("document.getElementById('difference-slide').textContent")
    page.run("document.getElementById('effect-throw').click()")
    assert page.run('view.state.effects') == []


def test_a_link_brings_the_state_back(browser, tmp_path):
    scene = Scene.load('eight_ball')
    path = tmp_path / 'page.html'
    opened(browser, path, page_of_scene(scene))
    browser.run(
        "view.change({ effects: ['throw'], parameters: { 'cloth.sliding_friction': 0.31 },"
        "target: { ball: '8', pocket: 'side_left' }, units: 'us' })"
    )
    browser.run('view.aim({ a: 0.1, azimuth: 0.0123456789, speed: 8.7654321 })')
    browser.run("document.getElementById('go-on').click()")  # places have all their digits
    browser.press('k')
    browser.run('view.aim({ azimuth: 0.3 })')
    state = browser.run('view.state')
    browser.wait_for('location.hash.length > 1')
    fragment = browser.run('location.hash')
    assert 1 < len(fragment) <= 2000
    opened(browser, path, page_of_scene(scene), fragment)
    found = browser.run('view.state')
    for name in ('balls', 'stroke', 'effects', 'parameters', 'target', 'units', 'kept'):
        assert found[name] == state[name], name
    assert len(found['kept']) == 1
    assert browser.messages == []


@pytest.mark.parametrize(
    'changes',
    [
        {'balls': {'cue': [0, 0], '<img src=x onerror=console.log(1)>': [0.1, 0.1]}},
        {'balls': {'cue': ['0', 0]}},
        {'balls': {'1': [0, 0]}},
        {'balls': 7},
        {'balls': {'cue': None}},
        {'stroke': {'speed': '</script><script>console.log(1)</script>'}},
        {'stroke': {'speed': 1e400, 'a': 0}},
        {'noise': {'a': -1}},
        {'effects': ['constructor']},
        {'effects': {'length': 1}},
        {'parameters': {'__proto__.x': 1}},
        {'parameters': {'cloth.sliding_friction': -4}},
        {'target': {'ball': 'toString'}},
        {'units': '__proto__'},
        {'drill': {'tries': '<b>', 'successes': 1}},
        {'level': '1'},
        {'kept': 'x'},
        {'kept': [7]},
        {'kept': [{}, {}, {}]},
        {'kept': [{'balls': {'cue': None}}]},
        {'kept': [{'parameters': {'cloth.sliding_friction': -4}}]},
        [],
        None,
    ],
)
def test_links_that_make_no_sense_change_nothing(browser, tmp_path, changes):
    text = json.dumps(changes).replace('Infinity', '1e999')
    fragment = '#' + base64.urlsafe_b64encode(text.encode()).decode().rstrip('=')
    path = tmp_path / 'shot.html'
    opened(browser, path, page_of(COMBINATION), fragment)
    for name in ('balls', 'stroke', 'noise'):
        browser.run(f'view.state.{name}')
    assert browser.run('view.outcome.message') == COMBINATION.message
    assert browser.messages == []
    opened(browser, path, page_of(COMBINATION), '#%%%<script>')
    assert browser.messages == []


def exported(browser, kind):
    """Text that the page gives to copy."""
    open_tab(browser, 'share')
    choose(browser, 'export', kind)
    return browser.run("document.getElementById('exported').value")


def test_what_is_exported_gives_the_same_shot(page, tmp_path, capsys):
    page.run("view.change({ effects: ['throw'], parameters: { 'cloth.sliding_friction': 0.31 } })")
    page.run('view.aim({ azimuth: 0.5, speed: 2.5, b: 1e-7 })')
    ends = {name: end['position'] for name, end in page.run('view.outcome.balls').items()}
    near = {name: pytest.approx(place, abs=1e-6) for name, place in ends.items()}
    (tmp_path / 'scene.yaml').write_text(exported(page, 'scene'))
    scene = Scene.load(tmp_path / 'scene.yaml')
    (tmp_path / 'stroke.yaml').write_text(exported(page, 'stroke'))
    (stroke,) = read_strokes(tmp_path / 'stroke.yaml', scene.cue_ball).values()
    found = predict(scene, stroke).final_position
    assert {name: place.tolist() for name, place in found.items()} == near
    with contextlib.redirect_stdout(io.StringIO()):
        run = {}
        exec(exported(page, 'python'), run)
    assert {n: place.tolist() for n, place in run['shot'].final_position.items()} == ends
    command = exported(page, 'command').replace('scene.yaml', str(tmp_path / 'scene.yaml'))
    assert main([*shlex.split(command)[1:], '--json']) == 0
    assert json.loads(capsys.readouterr().out)['status'] == run['shot'].status.name
    request = yaml.safe_load(re.search(r'"(.*)"', exported(page, 'ros'))[1])
    pose, ball = request['cue_pose'], request['ball_position']
    placed = Stroke.from_pose(
        [pose['position'][axis] for axis in 'xyz'],
        [pose['orientation'][axis] for axis in 'xyzw'],
        request['speed'],
        [ball[axis] for axis in 'xyz'],
    )
    assert placed.offsets == pytest.approx(stroke.offsets, abs=1e-9)
    link = exported(page, 'link')
    assert link.startswith('file:')
    assert '#' in link


def test_errors_are_those_of_people_by_name(page):
    open_tab(page, 'drill')
    assert page.run("document.getElementById('errors-of').value") == 'tournament'
    choose(page, 'errors-of', 'fargo_500')
    noise, radius = page.run('view.state.noise'), COMBINATION.scene.ball.radius
    assert [noise[name] for name in OFFSETS] == NOISES['fargo_500'].sigmas(radius).tolist()
    page.run('view.change({ noise: { ...view.state.noise, a: 0.01 } })')
    assert page.run("document.getElementById('errors-of').value") == ''


def test_the_chance_is_that_of_python(browser, tmp_path):
    scene = Scene.from_dict({'like': 'blocked', 'balls': {'cue': [-0.4, 0], '8': [0.6, 0.2]}})
    opened(browser, tmp_path / 'page.html', page_of_scene(scene))
    browser.wait_for('view.estimate?.n === 2000')
    found = browser.run('view.estimate')
    strokes = browser.run(
        'view.tableFor(view.state).drawn(view.state.stroke, view.state.noise, 2000, 1)'
        '.map(Object.values)'
    )
    pocket = POCKET_NAMES.index(found['target']['pocket'])

    def chance_of(batch):
        falls = batch.pocket[:, batch.names.index(found['target']['ball'])] == pocket
        return (falls & (batch.pocket[:, 0] < 0) & ~batch.off_table[:, 0]).mean()

    assert found['chance'] == chance_of(predict_batch(scene, offsets=strokes))
    low, high = found['interval']
    assert low < found['chance'] < high
    quick = chance_of(predict_within_noise(scene, strokes))
    error = math.sqrt(2 * found['chance'] * (1 - found['chance']) / 2000)
    assert abs(found['chance'] - quick) <= 3 * error


def test_the_menu_lists_direct_shots_and_aims(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    open_tab(browser, 'shots')
    listed = "[...document.querySelectorAll('#shots button')]"
    count = browser.run(f'{listed}.length')
    assert count > 1
    for i in range(2):
        chosen = f'{listed}[{i}]'
        text = browser.run(f'({chosen}.click(), {chosen}.querySelector("span").innerText)')
        ball, pocket = text.split(' → ')
        target = browser.run('view.state.target')
        assert (target['ball'], target['pocket'].replace('_', ' ')) == (ball, pocket)
        assert browser.run(f'view.outcome.balls[{ball!r}].pocket') == target['pocket']


def test_direct_shots_are_those_on_the_cloth_of_the_page(browser, tmp_path):
    page = opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    name, value = 'cloth.rolling_resistance', 0.02
    scene = Scene.load('blocked').with_parameters([name], [value])
    found, usual = (
        page.run(f'view.tableFor({{ effects: [], parameters: {given} }}).shots(view.state.balls)')
        for given in (json.dumps({name: value}), '{}')
    )
    places, radius = page.run('view.state.balls'), scene.ball.radius
    names = prepared_scene(scene).names
    expected = shots(scene, TableStates(names, np.array([[(*places[n], radius) for n in names]])))
    speeds, others = ([shot['stroke']['speed'] for shot in each] for each in (found, usual))
    # the openings of pockets are those on the cloth of the scene
    assert speeds == pytest.approx(expected.offsets[:, 4], rel=1e-4)
    assert [shot['chance'] for shot in found] == pytest.approx(expected.chance, abs=2e-3)
    assert speeds != pytest.approx(others, rel=0.1)


def test_a_drill_counts_tries_with_errors(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    open_tab(browser, 'drill')
    browser.run("document.getElementById('begin-drill').click()")
    balls = browser.run('view.state.balls')
    successes = 0
    for tries in range(1, 13):
        # While the balls roll, Strike pauses: back to the start first, within the same picture.
        browser.run(
            "for (const id of ['again', 'play']) {"
            ' const it = document.getElementById(id); it.disabled = false; it.click() }'
        )
        found, target = browser.run('[view.outcome.balls, view.state.target]')
        ends = found[target['ball']]
        cue = found['cue']['motion']
        successes += (
            ends['motion'] == 'POCKETED'
            and ends['pocket'] == target['pocket']
            and (cue not in ('POCKETED', 'OFF_TABLE'))
        )
        drill = browser.run('view.state.drill')
        assert (drill['tries'], drill['successes']) == (tries, successes)
        assert browser.run('view.state.balls') == balls
    assert browser.run("document.getElementById('score').textContent").startswith(
        f'{successes} of 12'
    )


def test_play_goes_on_from_where_the_balls_rest(page):
    left = COMBINATION.after().balls
    page.run("document.getElementById('go-on').click()")
    assert page.run('view.state.balls') == {name: list(place) for name, place in left.items()}
    assert page.run('view.outcome.status') == 'OK'
    page.run("document.getElementById('undo').click()")
    assert page.run('view.outcome.message') == COMBINATION.message


def test_a_shot_that_is_kept_can_be_taken_back(page):
    stroke = page.run('view.state.stroke')
    page.press('k')
    page.run('view.aim({ speed: 1.2 })')
    assert page.run("document.querySelectorAll('#kept li').length") == 1
    page.run("document.querySelector('#kept button').click()")
    assert page.run('view.state.stroke') == stroke
    assert page.run('view.outcome.message') == COMBINATION.message


def test_it_says_why_a_ball_missed(browser, tmp_path):
    scene = Scene.load('blocked')
    opened(browser, tmp_path / 'page.html', page_of_scene(scene))
    target, stroke = browser.run('[view.state.target ?? view.intended, view.state.stroke]')
    browser.run(
        f'view.aim({{ azimuth: {stroke["azimuth"] + 0.03} }}, null,'
        f'{{ target: {json.dumps(target)} }})'
    )
    told = browser.run("document.getElementById('why').textContent")
    shot = predict(scene, Stroke.from_offsets(**(stroke | {'azimuth': stroke['azimuth'] + 0.03})))
    time = next(event.time for event in shot.events if event.kind == 'ball')
    ball = shot.run.balls[target['ball']].at(time)
    pocket = POCKET_NAMES.index(target['pocket'])
    way = outline_of(scene).holes[pocket, :2] - ball.position[:2]
    off = np.degrees(np.arctan2(*ball.velocity[1::-1]) - np.arctan2(*way[::-1]))
    side = 'left' if off > 0 else 'right'
    words = target['pocket'].replace('_', ' ')
    expected = f'{target["ball"]} misses {words}: it leaves {abs(off):.1f}° too far {side}'
    assert told.startswith(f'{expected}; throw turns it ')


@pytest.mark.parametrize(
    'name',
    ['<img src=x onerror=console.log(1)>', '</script>', '"><b>', '__proto__', 'constructor'],
)
def test_names_of_balls_are_harmless(browser, tmp_path, name):
    balls = {'cue': [-0.5, 0.0], name: [0.3, 0.1]}
    scene = Scene.from_dict({'like': 'pool_table', 'balls': balls})
    opened(browser, tmp_path / 'page.html', page_of_scene(scene, name))
    for tab in ('shots', 'table', 'balls', 'events', 'drill', 'share'):
        open_tab(browser, tab)
    assert browser.run("document.querySelectorAll('img, b b').length") == 0
    assert browser.run('view.outcome.status') == 'OK'
    assert browser.run('Object.keys(view.state.balls)') == ['cue', name]
    assert browser.messages == []


def test_pages_of_a_folder_share_one_file_with_the_core(browser, tmp_path):
    (tmp_path / 'core.js').write_text(core_script())
    text = page_of(COMBINATION, 'x', core='core.js')
    assert len(text) < len(page_of(COMBINATION, 'x')) - 100_000
    opened(browser, tmp_path / 'shot.html', text)
    assert browser.run('view.outcome.message') == COMBINATION.message
    assert browser.messages == []


AROUND = """<!doctype html><meta charset="utf-8"><iframe></iframe><script>
const heard = [];
addEventListener('message', ({ data }) => heard.push(data));
const frame = document.querySelector('iframe');
const say = (message) => frame.contentWindow.postMessage(message, '*');
const last = (type) => heard.findLast((each) => each.type === type);
frame.srcdoc = TEXT;
</script>"""


def in_frame(browser, path, text):
    """Open a page in a frame of another."""
    path.write_text(AROUND.replace('TEXT', json.dumps(text).replace('<', '\\u003c')))
    browser.messages.clear()
    browser.open(path)
    browser.wait_for('frame.contentDocument?.body?.dataset.ready === "true"')


def test_the_page_around_a_frame_drives_it(browser, tmp_path):
    in_frame(browser, tmp_path / 'around.html', page_of(COMBINATION, framed=True))
    browser.wait_for("last('ready') && last('outcome')")
    assert browser.run("last('outcome').outcome.message") == COMBINATION.message
    stroke = {'a': 0, 'b': 0, 'elevation': 0.1, 'azimuth': 0, 'speed': 1}
    browser.run(f"say({{ type: 'set', state: {{ stroke: {json.dumps(stroke)} }} }})")
    browser.wait_for("last('state')?.state.stroke.speed === 1")
    browser.run("say({ type: 'set', state: { stroke: { speed: 'x' } } })")
    browser.wait_for("last('refused')")
    assert browser.run("last('state').state.stroke.speed") == 1
    assert browser.messages == []


def test_a_page_that_was_not_written_for_a_frame_hears_and_tells_nothing(browser, tmp_path):
    in_frame(browser, tmp_path / 'around.html', page_of(COMBINATION))
    browser.run("say({ type: 'set', state: { units: 'us' } })")
    browser.settle()
    assert browser.run('frame.contentWindow.view.state.units') == 'si'
    assert browser.run('heard.length') == 0

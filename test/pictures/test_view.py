"""The page of a shot: what is in it, and what a browser makes of it."""

import json
import re

from browser import Browser, find_browser
import numpy as np
import pytest

from billiard_shot import load_shot, predict, save_shot, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.pictures.orientations import MAX_TURN, orientations, product, rotation
from billiard_shot.pictures.view import page_of, view_data, write_page
from billiard_shot.records import ROWS
from billiard_shot.table.motion import SegmentRecord
from billiard_shot.table.outline import outline_of
from billiard_shot.table.trajectory import Trajectory

COMBINATION = predict(
    Scene.load('frozen_combination'), Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3)
)
MASSE = predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16)))
ONE = np.array([0.0, 0.0, 0.0, 1.0])
needs_browser = pytest.mark.skipif(find_browser() is None, reason='needs Chromium')


# ---- orientations ----


def turned(quaternion, vector):
    """A vector of the ball's frame in the table's."""
    axis, w = quaternion[:3], quaternion[3]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)


def test_products_and_rotations():
    a, b = np.array([0.3, -0.2, 0.9]), np.array([1.1, 0.4, -0.3])
    vector = np.array([0.2, 0.5, -0.7])
    both = product(rotation(a), rotation(b))
    assert turned(both, vector) == pytest.approx(turned(rotation(a), turned(rotation(b), vector)))
    quarter = rotation(np.array([0, 0, np.pi / 2]))
    assert turned(quarter, np.array([1.0, 0, 0])) == pytest.approx([0, 1, 0])
    assert rotation(np.zeros(3)) == pytest.approx(ONE)


def test_a_rolling_ball_turns_by_the_way_it_goes():
    scene = Scene.from_dict({'like': 'pool', 'cloth': {'spin_deceleration': 0}})
    shot = predict(scene, Stroke.from_offsets(0, 0, 0, 0, 0.5))
    ball = shot.trajectory
    times, turns = orientations(ball, ball.duration, ONE)
    roll = next(event.time for event in ball.events if event.kind == 'roll')
    begin = turns[np.argmin(np.abs(times - roll))]
    way = ball.final_position[0] - ball.at(roll).position[0]
    angle = way / scene.ball.radius
    end = product(rotation(np.array([0, angle, 0])), begin)
    assert abs(end @ turns[-1]) == pytest.approx(1.0, abs=1e-9)
    assert angle > 20


@pytest.mark.parametrize('shot', [MASSE, COMBINATION])
def test_orientations_follow_the_spin(shot):
    """Against steps a hundred times as fine, each about the spin in its middle."""
    ball = shot.trajectory
    times, turns = orientations(ball, ball.duration, ONE)
    assert np.linalg.norm(turns, axis=1) == pytest.approx(np.ones(len(turns)))
    cosines = np.abs((turns[1:] * turns[:-1]).sum(axis=1))
    assert (2 * np.arccos(cosines.clip(max=1.0)) <= MAX_TURN + 1e-9).all()
    fine = ONE
    worst = 0.0
    for a, b, turn in zip(times, times[1:], turns[1:], strict=False):
        if a > 0.7:
            break
        h = (b - a) / 100
        for spin in ball.at(a + h * (np.arange(100) + 0.5)).spin:
            fine = product(rotation(h * spin), fine)
        worst = max(worst, 1.0 - abs(fine @ turn))
    assert worst < 1e-8


def test_turning_is_of_fourth_order():
    """Of a spin whose axis turns: halving the step makes the error sixteen times as small."""
    rows = ROWS.records(SegmentRecord, 2)
    rows['motion'], rows['time'] = (1, 0), (0.0, 0.8)
    rows['spin'][0], rows['spin_acceleration'][0] = (1.0, 0.5, -2.0), (-1.5, 2.0, 1.0)
    ball = Trajectory(rows)

    def end(step, monkey):
        monkey.setattr('billiard_shot.pictures.orientations.MAX_TURN', step)
        return orientations(ball, 0.8, ONE)[1][-1]

    with pytest.MonkeyPatch.context() as monkey:
        exact = end(1e-3, monkey)
        errors = [np.linalg.norm(end(step, monkey) - exact) for step in (0.5, 0.25, 0.125)]
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12


# ---- what is in the page ----


def test_it_needs_nothing_but_itself():
    page = page_of(COMBINATION, 'A shot')
    code = page.replace(json.dumps(view_data(COMBINATION, 'A shot'), ensure_ascii=False), '')
    assert not re.search(r'https?:|\bsrc=|\bhref=|url\(|@import|\bfetch\(|XMLHttp|WebSocket', code)
    assert '<!-- ' not in page.replace('<!-- needs', '')
    assert '<title>A shot</title>' in page


def test_no_text_ends_the_script():
    page = page_of(COMBINATION, '</script><b>&')
    assert page.count('</script>') == 2
    assert '<title>&lt;/script>&lt;b>&amp;</title>' in page


def test_data_are_those_of_the_shot():
    data = view_data(COMBINATION, '')
    assert [ball['name'] for ball in data['balls']] == ['cue', '1', '8']
    for ball in data['balls']:
        rows = COMBINATION.run.balls[ball['name']].rows
        times, velocities = zip(*((row[0], row[5:8]) for row in ball['segments']), strict=True)
        assert list(times) == rows['time'].tolist()
        assert list(velocities) == rows['velocity'].tolist()
        assert all(len(row) == 17 for row in ball['segments'])
    assert [event['time'] for event in data['events'][1:]] == [
        event.time for event in COMBINATION.run.events
    ]
    cue = data['cue']
    radius = COMBINATION.scene.ball.radius
    start = COMBINATION.trajectory.at(0).position
    assert np.linalg.norm(np.array(cue['tip']) - start) == pytest.approx(radius)
    assert 2 * cue['swing'] / cue['time'] == pytest.approx(COMBINATION.stroke.speed)
    assert 'falls into a pocket: foot left' in ' '.join(e['text'] for e in data['events'])
    assert view_data(MASSE, '')['table'] is None


def test_a_recorded_shot_gives_the_same_page(tmp_path):
    save_shot(COMBINATION, tmp_path / 'shot.json')
    assert page_of(load_shot(tmp_path / 'shot.json'), 'x') == page_of(COMBINATION, 'x')


def test_command(tmp_path, capsys):
    save_shot(MASSE, tmp_path / 'shot.json')
    page = tmp_path / 'page.html'
    assert main(['view', str(tmp_path / 'shot.json'), '--output', str(page)]) == 0
    assert capsys.readouterr().out == f'{page}\n'
    assert page.read_text() == page_of(MASSE, 'shot')
    options = ['view', '--scene', 'pool_table', '--elevation-deg', '5', '--title', 'T']
    assert main([*options, '--speed', '1', '--output', str(page)]) == 0
    assert '<title>T</title>' in page.read_text()
    assert (
        main([*options, '--a', '0.99', '--b', '0.9', '--speed', '1', '--output', str(page)]) == 1
    )
    assert 'MISS' in capsys.readouterr().err
    assert '<title>T</title>' in page.read_text()  # the page of before
    assert main([*options, '--speed', '1', '-o', str(tmp_path / 'no' / 'page.html')]) == 2
    assert 'in a folder that exists' in capsys.readouterr().err


# ---- what a browser makes of it ----


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp('browser'))
    yield opened
    opened.close()


@pytest.fixture
def page(browser, tmp_path):
    """Open the combination in the browser; it must have nothing to complain about to the end."""
    path = tmp_path / 'shot.html'
    write_page(COMBINATION, path, 'A combination')
    browser.messages.clear()
    browser.open(path)
    browser.settle()
    yield browser
    assert browser.messages == []
    assert browser.requests == [path.as_uri()]


@needs_browser
def test_the_slider_moves_balls_to_where_the_trajectory_says(page):
    slide = (
        "(value) => {{ const s = document.getElementById('slider'); s.value = value;"
        "s.dispatchEvent(new Event('input')); }}"
    )
    turns = {
        name: orientations(
            ball,
            COMBINATION.run.duration,
            np.array(view_data(COMBINATION, '')['balls'][i]['turns'][:4]),
        )
        for i, (name, ball) in enumerate(COMBINATION.run.balls.items())
    }
    for time in (-0.05, 0.0, 0.013, 0.2118, 0.3, 0.9, 1.9, 3.7):
        page.run(f'({slide.format()})({time})')
        shown = page.run("['cue', '1', '8'].map((name) => view.state(name))")
        at = page.run('view.time')
        assert at == pytest.approx(time, abs=1e-9)
        for (name, ball), state in zip(COMBINATION.run.balls.items(), shown, strict=True):
            truth = ball.at(max(at, 0.0))
            assert state['position'] == pytest.approx(truth.position, abs=1e-12)
            assert state['velocity'] == pytest.approx(truth.velocity, abs=1e-12)
            assert state['spin'] == pytest.approx(truth.spin, abs=1e-9)
            assert state['motion'] == truth.motion
            times, found = turns[name]
            before = found[max(np.searchsorted(times, at, 'right') - 1, 0)]
            assert 2 * np.arccos(min(abs(before @ state['turn']), 1.0)) <= MAX_TURN + 1e-3


@needs_browser
def test_balls_are_drawn_where_they_are(page, tmp_path):
    """From above, the pixel at the cue ball's place is white or red; a while later it is cloth."""
    image = pytest.importorskip('PIL.Image', reason='needs Pillow')
    page.run("view.look('top'); ['paths', 'names'].map((x) => document.getElementById(x).click())")
    pixels = []
    for time in (0.0, 1.2):
        page.run(f'view.setTime({time})')
        x, y, _ = page.run("view.project(view.state('cue').position)")
        pixels.append((x, y))
        page.screenshot(tmp_path / f'{time}.png')
    assert np.hypot(*np.subtract(*pixels)) > 50
    first, later = (image.open(tmp_path / f'{time}.png').convert('RGB') for time in (0.0, 1.2))
    for (x, y), there, gone in ((pixels[0], first, later), (pixels[1], later, first)):
        ball = np.array(
            [there.getpixel((int(x) + i, int(y) + j)) for i in (-2, 0, 2) for j in (-2, 0, 2)]
        )
        cloth = np.array(gone.getpixel((int(x), int(y))))
        assert (ball[:, 0] > 120).all()  # white or red
        assert cloth[1] > 1.5 * cloth[0]  # green


@needs_browser
def test_keys_and_mouse(page):
    page.run("document.getElementById('canvas').focus()")
    page.press('End')
    assert page.run('view.time') == pytest.approx(COMBINATION.run.duration)
    page.press('Home')
    begin = page.run('view.time')
    assert begin < 0
    page.press('ArrowRight')
    assert page.run('view.time') == pytest.approx(begin + 0.01)
    page.press('ArrowRight', modifiers=8)
    assert page.run('view.time') == pytest.approx(begin + 0.21)
    page.press('PageDown')
    times = [event['time'] for event in view_data(COMBINATION, '')['events']]
    assert page.run('view.time') in times
    page.press('+')
    assert page.run("document.getElementById('rate').value") == '2'
    for _ in range(4):  # slowly: it must not come to its end before it is told to stop
        page.press('-')
    now = page.run('view.time')
    page.press(' ')
    assert page.run('view.playing')
    page.wait_for(f'view.time > {now}')
    page.press(' ')
    assert not page.run('view.playing')
    before = page.run('({ ...view.camera })')
    page.mouse('mousePressed', 300, 300, button='left', buttons=1, clickCount=1)
    page.mouse('mouseMoved', 400, 340, button='left', buttons=1)
    page.mouse('mouseReleased', 400, 340, button='left', clickCount=1)
    after = page.run('({ ...view.camera })')
    assert after['azimuth'] == pytest.approx(before['azimuth'] - 0.6)
    assert after['elevation'] == pytest.approx(before['elevation'] + 0.24)
    page.mouse('mouseWheel', 300, 300, deltaX=0, deltaY=-200)
    page.wait_for(f'view.camera.distance < {0.9 * after["distance"]}')


@needs_browser
def test_events_are_listed_and_lead_to_their_times(page):
    events = view_data(COMBINATION, '')['events']
    listed = page.run("[...document.querySelectorAll('#events button')].map((b) => b.textContent)")
    assert len(listed) == len(events)
    for event, text in zip(events, listed, strict=True):
        assert text.endswith(event['text'])
    page.run("document.querySelectorAll('#events button')[5].click()")
    assert page.run('view.time') == events[5]['time']
    page.settle()
    now = page.run("document.querySelector('#events .now').textContent")
    assert now == f'{events[5]["time"]:.3f}{events[5]["text"]}'


def choose(browser, field, value):
    browser.run(
        f"(() => {{ const s = document.getElementById('{field}'); s.value = {value!r};"
        "s.dispatchEvent(new Event('change')); })()"
    )
    browser.settle()


def click(browser, x, y):
    for kind in ('mousePressed', 'mouseReleased'):
        browser.mouse(kind, x, y, button='left', buttons=1, clickCount=1)
    browser.settle()


@needs_browser
def test_events_are_filtered_by_ball_and_by_kind(page):
    events = view_data(COMBINATION, '')['events']
    listed = "[...document.querySelectorAll('#events button')].map((b) => b.textContent)"
    choose(page, 'ball', '8')
    of_8 = [event for event in events if '8' in event['balls']]
    assert 0 < len(of_8) < len(events)
    assert len(page.run(listed)) == len(of_8)
    choose(page, 'kind', 'pockets')
    (falls,) = [event for event in of_8 if event['kind'] == 'pocket']
    assert page.run(listed) == [f'{falls["time"]:.3f}{falls["text"]}']
    assert page.run("document.querySelectorAll('#ticks i').length") == 1
    page.run('view.setTime(0)')
    page.press('PageDown')  # to the next event that is listed
    assert page.run('view.time') == falls['time']


@needs_browser
def test_a_ball_that_is_clicked_is_followed(page):
    page.run('view.setTime(0.3)')
    x, y, _ = page.run("view.project(view.state('8').position)")
    click(page, x, y)
    assert page.run('view.followed') == '8'
    assert page.run("document.querySelector('#readout dt').textContent") == '8'
    for time in (0.5, 1.5):
        page.run(f'view.setTime({time})')
        area = page.run('view.freeArea()')
        middle = [(area['left'] + area['right']) / 2, (area['top'] + area['bottom']) / 2]
        at = page.run("view.project(view.state('8').position)")[:2]
        assert at == pytest.approx(middle, abs=0.01)
    click(page, 20, 20)
    assert page.run('view.followed') is None


@needs_browser
def test_each_ball_has_its_name_beside_it(page):
    page.run("view.look('top'); view.setTime(0.33)")
    page.settle()
    for i, name in enumerate(('cue', '1', '8')):
        label = f"document.querySelectorAll('#labels span')[{i}]"
        assert page.run(f'{label}.textContent') == name
        assert page.run(f'{label}.style.visibility') == 'visible'
        box = page.run(f'{label}.getBoundingClientRect().toJSON()')
        x, y, _ = page.run(f"view.project(view.state('{name}').position)")
        assert abs(x - (box['left'] + box['right']) / 2) < 40
        assert abs(y - (box['top'] + box['bottom']) / 2) < 30
    page.run('view.setTime(2)')  # the 8 has fallen
    page.settle()
    assert page.run(f'{label}.style.visibility') == 'hidden'
    page.run('view.setTime(0.33)')
    page.press('n')
    page.settle()
    assert page.run(f'{label}.style.visibility') == 'hidden'


@needs_browser
def test_the_stroke_is_told_and_the_tip_is_where_it_touches(page):
    told = page.run("document.getElementById('stroke').innerText")
    assert [line for line in told.splitlines() if line.strip()][1::2] == [
        '3.00 m/s',
        '5.7°',
        '31.5°',
        '0.20 right',
        '0.30 above',
    ]
    a, b = COMBINATION.stroke.offsets[:2]
    touch = page.run("['cx', 'cy'].map((k) => document.getElementById('touch').getAttribute(k))")
    assert [float(number) for number in touch] == pytest.approx([a, -b])


def test_an_axis_beside_the_centre_touches_a_rounded_tip_nearer_to_it():
    scene = Scene.from_dict({'like': 'pool', 'cue': {'tip_curvature_radius': 0.01}})
    radius = scene.ball.radius
    stroke = Stroke.from_pose((-0.2, 0.3 * radius, radius), (0, 0, 0, 1), 1.0, (0, 0, radius))
    data = view_data(predict(scene, stroke), '')['stroke']
    assert data['a'] == pytest.approx(-0.3)
    assert data['touch'] == pytest.approx((-0.3 / (1 + 0.01 / radius), 0.0))


def test_each_ball_that_moves_has_a_colour_of_its_own():
    shot = predict(Scene.load('blocked'), Stroke.from_offsets(0, 0, 0.1, 0, 4))
    balls = view_data(shot, '')['balls']
    moved = [ball for ball in balls if ball['trails']]
    assert len(moved) == 3
    assert len({ball['path'] for ball in moved}) == 3
    assert all(ball['path'] is None for ball in balls if ball not in moved)


@needs_browser
def test_the_eye_stays_above_cloth_and_cushions(page):
    table = view_data(COMBINATION, '')['table']
    for view in ('corner', 'player', 'top'):
        for distance in (0.12, 0.5, 2.0, 6.0):
            page.run(
                f"view.look('{view}');"
                f'Object.assign(view.camera, {{ elevation: 0, distance: {distance} }})'
            )
            x, y, z = page.run('view.eye')
            outside = (np.abs([x, y]) > np.array(table['size']) / 2).any()
            assert z > (table['height'] if outside else 0) + 0.01


@needs_browser
def test_a_phone_shows_all_balls_and_all_controls(page):
    def resize(width, height):
        page.call(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        page.settle()

    def in_view(places):
        area = page.run('view.freeArea()')
        for place in places:
            x, y, _ = page.run(f'view.project({place})')
            assert area['left'] < x < area['right']
            assert area['top'] < y < area['bottom']

    size = 390, 844
    resize(*size)
    try:
        # A window that changes its size, or opens its panel, shows the whole table again ...
        x, y = outline_of(COMBINATION.scene).frame.tolist()
        for _ in range(2):
            in_view([[i * x, j * y, 0] for i in (-1, 1) for j in (-1, 1)])
            page.run("document.getElementById('panel').click()")
            page.settle()
        # ... but not if somebody has turned it.
        page.mouse('mousePressed', 200, 200, button='left', buttons=1)
        page.mouse('mouseMoved', 230, 200, button='left', buttons=1)
        page.mouse('mouseReleased', 230, 200, button='left')
        turned = page.run('view.camera.azimuth')
        resize(400, 844)
        assert page.run('view.camera.azimuth') == turned
        resize(*size)
        for view in ('corner', 'top'):
            page.run(f"view.look('{view}')")
            area = page.run('view.freeArea()')
            for name in COMBINATION.run.balls:
                x, y, _ = page.run(f"view.project(view.state('{name}').position)")
                assert area['left'] < x < area['right']
                assert area['top'] < y < area['bottom']
        shown = page.run(
            "[...document.querySelectorAll('footer button, footer select, footer input, aside')]"
            '.filter((e) => e.offsetWidth).map((e) => e.getBoundingClientRect().toJSON())'
        )
        assert len(shown) > 8
        for box in shown:
            assert box['left'] >= 0
            assert box['right'] <= size[0]
            assert box['bottom'] <= size[1]
        for button in ('Corner', 'Cue', 'Above'):
            assert button in page.run("document.querySelector('footer').innerText")
    finally:
        resize(1000, 600)


@needs_browser
@pytest.mark.parametrize('name', ['masse', 'break', 'refused', 'carom', 'endless'])
def test_other_shots_load_without_complaints(browser, tmp_path, name):
    shot = {
        'masse': lambda: MASSE,
        'break': lambda: predict(Scene.load('snooker'), Stroke.from_offsets(0, 0.1, 0.1, 0.1, 4)),
        'refused': lambda: predict(Scene.load('nine_ball'), Stroke((1, 0, 0), (1, 0, 0))),
        'carom': lambda: predict(Scene.load('carom'), Stroke.from_offsets(0.3, 0, 0.1, 0.7, 3)),
        'endless': lambda: predict(
            Scene.from_dict({'like': 'pool', 'cloth': {'rolling_resistance': 0}}),
            Stroke.from_offsets(0, 0, 0.1, 0, 1),
        ),
    }[name]()
    (tmp_path / 'shot.html').write_text(page_of(shot, name), encoding='utf-8')
    browser.messages.clear()
    browser.open(tmp_path / 'shot.html')
    for view in ('corner', 'player', 'top'):
        browser.run(f"view.look('{view}'); view.setTime(1.0)")
        browser.settle()
    assert browser.messages == []
    assert browser.run("document.getElementById('trouble').hidden")
    cue = browser.run("view.state('cue').position")
    assert cue == pytest.approx(shot.trajectory.at(browser.run('view.time')).position, abs=1e-12)


@needs_browser
def test_without_webgl_it_says_so_and_still_tells_the_rest(browser, tmp_path):
    write_page(COMBINATION, tmp_path / 'shot.html', 'x')
    script = browser.call(
        'Page.addScriptToEvaluateOnNewDocument',
        source='HTMLCanvasElement.prototype.getContext = () => null',
    )
    browser.messages.clear()
    browser.open(tmp_path / 'shot.html')
    browser.call('Page.removeScriptToEvaluateOnNewDocument', identifier=script['identifier'])
    assert 'no WebGL 2' in browser.run("document.getElementById('trouble').textContent")
    assert browser.run("document.querySelectorAll('#events button').length") > 5
    assert browser.messages == []

"""The page of a shot: what is in it, and what a browser makes of it."""

import copy
import math

from browser import choose, click, find_browser, open_tab, opened
import numpy as np
import pytest

from billiard_shot import load_shot, machine_code, predict, save_shot, Scene, Stroke
from billiard_shot.cli import main
from billiard_shot.pictures.view import page_of, page_of_scene, view_data, write_page
from billiard_shot.table.run.outline import outline_of

COMBINATION = predict(
    Scene.load('frozen_combination'), Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3)
)
MASSE = predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16)))
MAX_TURN = 0.35  # rad, of turning.js
pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
needs_browser = pytest.mark.skipif(find_browser() is None, reason='needs Chromium')


# ---- what is in the page ----


def test_no_text_ends_the_script():
    page = page_of(COMBINATION, '</script><b>&')
    assert page.count('</script>') == page_of(COMBINATION, 'x').count('</script>')
    assert '<title>&lt;/script&gt;&lt;b&gt;&amp;</title>' in page
    assert '<!-- ' not in page


def test_data_are_those_of_the_shot():
    data = view_data(COMBINATION, '')
    assert [ball['name'] for ball in data['balls']] == ['cue', '1', '8']
    stroke = data['start']['stroke']
    assert stroke['normal'] == COMBINATION.stroke.normal
    assert stroke['velocity'] == COMBINATION.stroke.velocity
    assert data['start']['balls'].keys() == {'cue', '1', '8'}
    assert view_data(MASSE, '')['table'] is None


def test_a_recorded_shot_gives_the_same_page(tmp_path):
    save_shot(COMBINATION, tmp_path / 'shot.json')
    data, loaded = (
        copy.deepcopy(view_data(shot, 'x'))
        for shot in (COMBINATION, load_shot(tmp_path / 'shot.json'))
    )
    for page in (data, loaded):
        del page['source']  # a recorded scene has what was derived as given, so that it no longer
        for number in page['equipment']['parameters']:
            del number['paths']  # follows other numbers
    assert loaded == data


def test_a_page_is_small():
    page = page_of_scene('snooker').encode()
    assert len(page) <= 600_000


def test_command(tmp_path, capsys):
    save_shot(MASSE, tmp_path / 'shot.json')
    page = tmp_path / 'page.html'
    assert main(['view', str(tmp_path / 'shot.json'), '--output', str(page)]) == 0
    assert capsys.readouterr().out == f'{page}\n'
    assert '<title>shot</title>' in page.read_text()
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


@pytest.fixture
def page(browser, tmp_path):
    """Open the combination in the browser; it must have nothing to complain about to the end."""
    path = tmp_path / 'shot.html'
    yield opened(browser, path, page_of(COMBINATION, 'A combination'))
    assert browser.messages == []
    others = [url for url in browser.requests if url != path.as_uri()]
    assert {url.split(':')[0] for url in others} <= {'blob', 'data'}


def turned(quaternion, vector):
    """A vector of the ball's frame in the table's."""
    axis, w = np.array(quaternion[:3]), quaternion[3]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)


@needs_browser
def test_the_slider_moves_balls_to_where_the_trajectory_says(page):
    slide = (
        "(value) => {{ const s = document.getElementById('slider'); s.value = value;"
        "s.dispatchEvent(new Event('input')); }}"
    )
    for time in (-0.05, 0.0, 0.013, 0.2118, 0.3, 0.9, 1.9, 3.7):
        page.run(f'({slide.format()})({time})')
        shown = page.run("['cue', '1', '8'].map((name) => view.ball(name))")
        at = page.run('view.time')
        assert at == pytest.approx(time, abs=1e-9)
        for (name, ball), state in zip(COMBINATION.run.balls.items(), shown, strict=True):
            truth = ball.at(max(at, 0.0))
            assert state['position'] == pytest.approx(truth.position, abs=1e-12), name
            assert state['velocity'] == pytest.approx(truth.velocity, abs=1e-12)
            assert state['spin'] == pytest.approx(truth.spin, abs=1e-9)


@needs_browser
def test_balls_turn_as_their_spin_says(page):
    """Against steps a hundred times as fine, each about the spin in its middle."""
    ball = COMBINATION.run.balls['cue']
    times = np.linspace(0.0, 0.3, 8)
    steps = 400
    states = 'view.setTime(t), view.ball("cue").turn'
    turns = page.run(f'{times.tolist()}.map((t) => ({states}))')
    vector = turned(turns[0], np.array([1.0, 0.0, 0.0]))
    for begin, end, turn in zip(times, times[1:], turns[1:], strict=False):
        h = (end - begin) / steps
        for spin in ball.at(begin + h * (np.arange(steps) + 0.5)).spin:
            axis, angle = spin / np.linalg.norm(spin), h * np.linalg.norm(spin)
            along = axis * (axis @ vector)
            vector = (
                along
                + (vector - along) * math.cos(angle)
                + np.cross(axis, vector) * math.sin(angle)
            )
        # between two orientations the page interpolates
        assert turned(turn, np.array([1.0, 0.0, 0.0])) == pytest.approx(vector, abs=2e-2)


@needs_browser
def test_a_rolling_ball_turns_by_the_way_it_goes(browser, tmp_path):
    scene = Scene.from_dict({'like': 'pool', 'cloth': {'spin_deceleration': 0}})
    shot = predict(scene, Stroke.from_offsets(0, 0, 0, 0, 0.5))
    opened(browser, tmp_path / 'shot.html', page_of(shot))
    roll = next(event.time for event in shot.events if event.kind == 'roll')
    begin, end = browser.run(
        f'[{roll}, view.shown.until].map((t) => (view.setTime(t), view.ball("cue")))'
    )
    angle = (end['position'][0] - begin['position'][0]) / scene.ball.radius
    assert angle > 20
    for vector in np.eye(3):
        before, after = (turned(each['turn'], vector) for each in (begin, end))
        x, z = before[0], before[2]
        cosine, sine = math.cos(angle), math.sin(angle)
        rolled = cosine * x + sine * z, before[1], cosine * z - sine * x
        assert after == pytest.approx(rolled, abs=1e-6)


@needs_browser
def test_balls_are_drawn_where_they_are(page, tmp_path):
    """From above, the pixel at the cue ball's place is white or red; a while later it is cloth."""
    image = pytest.importorskip('PIL.Image', reason='needs Pillow')
    page.run("view.look('top'); ['paths', 'names'].map((x) => document.getElementById(x).click())")
    pixels = []
    for time in (0.0, 1.2):
        page.run(f'view.setTime({time})')
        x, y, _ = page.run("view.project(view.ball('cue').position)")
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
@pytest.mark.parametrize(('scheme', 'bright'), [('light', True), ('dark', False)])
def test_the_room_around_the_table_is_bright_by_day(browser, tmp_path, scheme, bright):
    image = pytest.importorskip('PIL.Image', reason='needs Pillow')
    feature = {'name': 'prefers-color-scheme', 'value': scheme}
    browser.call('Emulation.setEmulatedMedia', features=[feature])
    opened(browser, tmp_path / 'shot.html', page_of(COMBINATION))
    browser.screenshot(tmp_path / 'shot.png')
    browser.call('Emulation.setEmulatedMedia', features=[])
    corner = image.open(tmp_path / 'shot.png').convert('RGB').getpixel((4, 4))
    assert (np.array(corner) > 128).all() == bright
    assert min(corner) > 8  # it is not black


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
    times = [0.0, *(event.time for event in COMBINATION.events)]
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
    page.mouse('mousePressed', 60, 60, button='left', buttons=1, clickCount=1)
    page.mouse('mouseMoved', 160, 20, button='left', buttons=1)
    page.mouse('mouseReleased', 160, 20, button='left', clickCount=1)
    after = page.run('({ ...view.camera })')
    assert after['azimuth'] == pytest.approx(before['azimuth'] - 0.6)
    assert after['elevation'] == pytest.approx(before['elevation'] - 0.24)
    page.mouse('mouseWheel', 300, 300, deltaX=0, deltaY=-200)
    page.wait_for(f'view.camera.distance < {0.9 * after["distance"]}')


LISTED = "[...document.querySelectorAll('#events button')].map((b) => b.textContent)"


@needs_browser
def test_events_are_listed_and_lead_to_their_times(page):
    open_tab(page, 'events')
    page.wait_for("document.querySelectorAll('#events button').length")
    events = [(0.0, 'cue strikes'), *((event.time, str(event)) for event in COMBINATION.events)]
    assert page.run(LISTED) == [f'{time:.3f}{text}' for time, text in events]
    page.run("document.querySelectorAll('#events button')[5].click()")
    assert page.run('view.time') == events[5][0]
    page.settle()
    now = page.run("document.querySelector('#events .now').textContent")
    assert now == f'{events[5][0]:.3f}{events[5][1]}'


@needs_browser
def test_events_are_filtered_by_ball(page):
    open_tab(page, 'events')
    page.wait_for("document.querySelectorAll('#events button').length")
    events = COMBINATION.events
    choose(page, 'ball', '8')
    of_8 = [event for event in events if '8' in event.balls]
    assert 0 < len(of_8) < len(events)
    assert len(page.run(LISTED)) == len(of_8)
    assert page.run(LISTED) == [f'{event.time:.3f}{event}' for event in of_8]
    page.run('view.setTime(0)')
    page.press('PageDown')  # to the next event that is listed
    assert page.run('view.time') == of_8[0].time


@needs_browser
def test_a_ball_that_is_clicked_is_followed(page):
    open_tab(page, 'events')
    page.run('view.setTime(0.3)')
    x, y, _ = page.run("view.project(view.ball('8').position)")
    click(page, x, y)
    assert page.run('view.followed') == '8'
    assert page.run("document.querySelector('#readout dt').textContent") == '8'
    for time in (0.5, 1.5):
        page.run(f'view.setTime({time})')
        area = page.run('view.freeArea()')
        middle = [(area['left'] + area['right']) / 2, (area['top'] + area['bottom']) / 2]
        at = page.run("view.project(view.ball('8').position)")[:2]
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
        x, y, _ = page.run(f"view.project(view.ball('{name}').position)")
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
    told = page.run("[...document.querySelectorAll('#stroke [type=number]')].map((b) => b.value)")
    assert [float(number) for number in told] == pytest.approx(
        [3.0, math.degrees(0.1), math.degrees(0.55), 0.2, 0.3], abs=1e-3
    )
    touch = page.run("['cx', 'cy'].map((k) => document.getElementById('touch').getAttribute(k))")
    assert [float(number) for number in touch] == pytest.approx([0.2, -0.3])


def test_an_axis_beside_the_centre_touches_a_rounded_tip_nearer_to_it():
    scene = Scene.from_dict({'like': 'pool', 'cue': {'tip_curvature_radius': 0.01}})
    radius = scene.ball.radius
    stroke = Stroke.from_pose((-0.2, 0.3 * radius, radius), (0, 0, 0, 1), 1.0, (0, 0, radius))
    data = view_data(predict(scene, stroke), '')
    assert data['start']['stroke']['a'] == pytest.approx(-0.3 / (1 + 0.01 / radius))
    assert data['cue']['tip_curvature'] == pytest.approx(0.01 / radius)


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
@pytest.mark.parametrize('size', [(390, 844), (360, 640)])
def test_a_phone_shows_all_balls_and_all_controls(browser, tmp_path, size):
    def resize(width, height):
        browser.call(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        browser.settle()

    def in_view(places):
        area = browser.run('view.freeArea()')
        for place in places:
            x, y, _ = browser.run(f'view.project({place})')
            assert area['left'] < x < area['right']
            assert area['top'] < y < area['bottom']

    resize(*size)
    try:
        page = opened(browser, tmp_path / 'shot.html', page_of(COMBINATION, 'A combination'))
        # A window that changes its size, or opens its panel, shows the whole table again ...
        x, y = outline_of(COMBINATION.scene).frame.tolist()
        for _ in range(2):
            in_view([[i * x, j * y, 0] for i in (-1, 1) for j in (-1, 1)])
            page.run("document.getElementById('panel').click()")
            page.settle()
        # ... but not if somebody has turned it.
        page.mouse('mousePressed', 14, 300, button='left', buttons=1)
        page.mouse('mouseMoved', 44, 300, button='left', buttons=1)
        page.mouse('mouseReleased', 44, 300, button='left')
        turned_to = page.run('view.camera.azimuth')
        resize(size[0] + 10, size[1])
        assert page.run('view.camera.azimuth') == turned_to
        resize(*size)
        for view in ('corner', 'top'):
            page.run(f"view.look('{view}')")
            in_view([page.run(f"view.ball('{name}').position") for name in COMBINATION.run.balls])
        shown = page.run(
            "[...document.querySelectorAll('footer button, footer select, footer input, aside')]"
            '.filter((e) => e.offsetWidth).map((e) => e.getBoundingClientRect().toJSON())'
        )
        assert len(shown) > 8
        for box in shown:
            assert box['left'] >= 0
            assert box['right'] <= size[0]
            assert box['bottom'] <= size[1]
        for text in ('Strike', 'Corner', 'Cue', 'Above'):
            assert text in page.run("document.querySelector('footer').innerText")
        assert browser.messages == []
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
    opened(browser, tmp_path / 'shot.html', page_of(shot, name))
    for view in ('corner', 'player', 'top'):
        browser.run(f"view.look('{view}'); view.setTime(1.0)")
        browser.settle()
    assert browser.messages == []
    assert browser.run("document.getElementById('trouble').hidden")
    cue = browser.run("view.ball('cue').position")
    assert cue == pytest.approx(shot.trajectory.at(browser.run('view.time')).position, abs=1e-12)
    told = browser.run('view.outcome')
    assert told['status'] == shot.status.name
    if not shot.status.refused:
        assert told['message'] == shot.message


@needs_browser
def test_without_webgl_it_says_so_and_still_tells_the_rest(browser, tmp_path):
    write_page(COMBINATION, tmp_path / 'shot.html', 'x')
    script = browser.call(
        'Page.addScriptToEvaluateOnNewDocument',
        source='HTMLCanvasElement.prototype.getContext = () => null',
    )
    opened(browser, tmp_path / 'shot.html', page_of(COMBINATION, 'x'))
    browser.call('Page.removeScriptToEvaluateOnNewDocument', identifier=script['identifier'])
    assert 'no WebGL 2' in browser.run("document.getElementById('trouble').textContent")
    open_tab(browser, 'events')
    browser.wait_for("document.querySelectorAll('#events button').length > 5")
    assert browser.messages == []

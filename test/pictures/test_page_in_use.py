"""What people see of the page: under a thumb, with a keyboard, in a rack, in a link of others."""

from functools import partial
import json
import math
from pathlib import Path
import random
import re
import shutil

from browser import find_browser, open_tab, opened
from firefox import find_firefox, Firefox
import numpy as np
from programs import ran
import pytest

from billiard_shot import machine_code, predict, Scene, Stroke
from billiard_shot.pictures.view import page_of_scene
from billiard_shot.planning.statistics import percent
from billiard_shot.scene.files import scene_names

pytestmark = [
    pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code'),
    pytest.mark.skipif(find_browser() is None, reason='needs Chromium'),
]
SIZES = {
    'desk': (1280, 800),
    'tablet': (820, 1180),
    'phone': (390, 844),
    'lying phone': (844, 390),
}
PAGES = Path(machine_code.__file__).parent / 'pictures' / 'page'
BOX = 'document.getElementById({!r}).getBoundingClientRect().toJSON()'
TEXT = 'document.getElementById({!r}).textContent'


@pytest.fixture(params=SIZES)
def sized(request, browser, tmp_path):
    """Open scene `blocked` on a screen; return the browser, the name, width and height of it."""
    with screen(browser, *SIZES[request.param], touch=request.param != 'desk'):
        opened(browser, tmp_path / 'page.html', page_of_scene('blocked', planner=True))
        yield browser, request.param, *SIZES[request.param]
    assert browser.messages == []


class screen:  # noqa: N801 (used as a function)
    """Let the browser have another screen in a block."""

    def __init__(self, browser, width, height, *, touch):
        self.browser, self.size, self.touch = browser, (width, height), touch

    def __enter__(self):
        self._set(*self.size, self.touch)

    def __exit__(self, *_):
        self._set(1000, 600, False)

    def _set(self, width, height, touch):
        self.browser.call(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=touch,
        )
        self.browser.call('Emulation.setTouchEmulationEnabled', enabled=touch, maxTouchPoints=2)


def finger(browser, kind, *place):
    points = [{'x': place[0], 'y': place[1]}] if place else []
    browser.call('Input.dispatchTouchEvent', type=kind, touchPoints=points)
    browser.settle()


def mouse(browser, kind, *place):
    browser.mouse(kind, *place, button='left', buttons=1, clickCount=1)


def type_into(browser, field, value, event='input'):
    browser.run(
        f"(() => {{ const box = [...document.querySelectorAll('.field')]"
        f'.find((each) => each.innerText.trim().startsWith({field!r}))'
        f".querySelector('[type=number]'); box.focus(); box.value = {value!r};"
        f'box.dispatchEvent(new Event({event!r})); }})()'
    )


def shown_in(browser, field):
    return browser.run(
        "[...document.querySelectorAll('.field')].find((each) => each.innerText.trim()"
        f".startsWith({field!r})).querySelector('[type=number]').value"
    )


# ---- under a thumb ----


def test_the_face_stays_under_the_finger_whatever_is_told(sized):
    browser, name, _, _ = sized
    face, view = browser.run(BOX.format('face')), browser.run('view.eye')
    middle = np.array([face['left'] + face['width'] / 2, face['top'] + face['height'] / 2])
    radius = face['width'] / 2.24
    told = set()
    touch = name != 'desk'
    kinds = ('mousePressed', 'mouseMoved', 'mouseReleased')
    if touch:
        kinds = ('touchStart', 'touchMove', 'touchEnd')
    press, move, release = (partial(finger if touch else mouse, browser, kind) for kind in kinds)
    press(*middle)
    for k in range(12):  # through miscues and misses, so that messages of all lengths come and go
        angle, out = 2.4 * k, 0.08 * k
        place = middle + radius * out * np.array([math.cos(angle), math.sin(angle)])
        move(*np.round(place))
        browser.settle()
        a, b = browser.run('[view.state.stroke.a, view.state.stroke.b]')
        curved = browser.run("Number(document.getElementById('axis').getAttribute('cx'))")
        assert curved == pytest.approx(min(out, 0.9) * math.cos(angle), abs=0.06), (a, b)
        told.add(browser.run(TEXT.format('message') + ' + ' + TEXT.format('why')))
        assert browser.run(BOX.format('face')) == face
        assert browser.run('view.eye') == view
    release(*([] if touch else np.round(place)))
    lengths = sorted(map(len, told))
    assert lengths[-1] > lengths[0] + 40


def test_tip_chance_undo_and_strike_are_on_the_first_screen(sized):
    browser, _, width, height = sized
    for part in ('face', 'likely', 'undo', 'keep', 'go-on', 'play', 'message'):
        box = browser.run(BOX.format(part))
        assert 0 <= box['left'] < box['right'] <= width, part
        assert 0 <= box['top'] < box['bottom'] <= height, part
        at = [(box['left'] + box['right']) / 2, (box['top'] + box['bottom']) / 2]
        inside = f'document.getElementById({part!r}).contains(document.elementFromPoint(...{at}))'
        assert part in ('likely', 'message') or browser.run(inside), part
    # no tab is in a second row, nothing is wider than its panel
    tops = "[...document.querySelectorAll('#tabs button')].map((each) => each.offsetTop)"
    assert len(set(browser.run(tops))) == 1
    assert browser.run("(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth)("
                       "document.querySelector('aside'))") <= 0  # fmt: skip


def test_a_sheet_is_pulled_up_on_a_phone_with_the_table_in_sight(browser, tmp_path):
    with screen(browser, 390, 844, touch=True):
        opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
        hidden = "document.getElementById('more').getBoundingClientRect().height"
        assert browser.run(hidden) == 0
        grip = browser.run(BOX.format('pull'))
        x, y = grip['left'] + grip['width'] / 2, grip['top'] + grip['height'] / 2
        for kind, *at in (('touchStart', x, y), ('touchMove', x, y - 60), ('touchEnd',)):
            finger(browser, kind, *at)
        assert browser.run(hidden) > 150
        area = browser.run('view.freeArea()')
        assert area['bottom'] - area['top'] > 0.3 * 844
        for corner in (-1.27, 0.635), (1.27, -0.635):
            px, py = browser.run(f'view.project([{corner[0]}, {corner[1]}, 0]).slice(0, 2)')
            assert 0 < px < 390
            assert area['top'] < py < area['bottom']
        browser.run("document.getElementById('pull').click()")
        assert browser.run(hidden) == 0


def test_help_tells_of_touch_where_there_is_no_keyboard(browser, tmp_path):
    told = []
    for touch in (True, False):
        with screen(browser, 390, 844, touch=touch):
            opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
            browser.run("document.getElementById('help').click()")
            told.append(browser.run("document.getElementById('keys').innerText"))
    assert 'two fingers' in told[0]
    assert 'space' not in told[0]
    assert 'space' in told[1]


# ---- where a page begins ----


@pytest.mark.parametrize('name', scene_names())
def test_pages_open_with_a_shot_that_succeeds(browser, tmp_path, name):
    opened(browser, tmp_path / 'page.html', page_of_scene(name))
    scene = Scene.load(name)
    outcome, stroke, met = browser.run(
        '[view.outcome, view.state.stroke, view.shown.events.filter(({ kind, balls }) =>'
        "['ball', 'cluster'].includes(kind) && balls[0] === 'cue').flatMap(({ balls }) => balls)]"
    )
    assert outcome['status'] == 'OK'
    assert browser.run(TEXT.format('why')) == ''
    others = [ball for ball in outcome['balls'] if ball != 'cue']
    if others and scene.table.pockets:
        assert 'POCKETED' in [outcome['balls'][ball]['motion'] for ball in others]
        assert outcome['balls']['cue']['motion'] == 'REST'
    elif others:
        assert len(set(met)) == 3  # a carom
    if scene.rack:
        assert 6 <= stroke['speed'] <= 7
        assert browser.run('view.intended') == {}
        assert 'break: a ball falls' in browser.run(TEXT.format('aim-at'))


def test_a_break_is_judged_by_what_falls_and_by_the_cue_ball(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('nine_ball'))
    browser.wait_for('view.estimate?.n > 0')
    n, told = browser.run(f'[view.estimate.n, {TEXT.format("interval")}]')
    assert n == 2000 or f'{n} of 2000 strokes' in told
    assert browser.run('view.estimate.chance') > 0.1
    browser.run('view.aim({ speed: 0.3 })')
    assert browser.run(TEXT.format('why')) == 'no ball falls'
    browser.run('view.aim({ speed: 6.5 })')
    browser.run('view.change({ balls: { ...view.state.balls, 9: [-1, -0.5] } })')
    assert browser.run('view.intended')['ball']  # no longer a rack: judged as a pot


# ---- numbers ----


@pytest.mark.parametrize('value', ['-3', '0', '1e9'])
def test_a_number_that_is_not_allowed_is_not_played(browser, tmp_path, value):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    before = browser.run('view.state.stroke.speed')
    type_into(browser, 'speed', value)
    assert browser.run('view.state.stroke.speed') == before
    assert browser.run(TEXT.format('hint')) == (f'speed must be 0.001 to 100, got {value} (m/s)')
    type_into(browser, 'speed', value, 'change')
    assert float(shown_in(browser, 'speed')) == before


def test_a_field_shows_what_is_played(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    open_tab(browser, 'table')
    browser.run("view.change({ parameters: { 'cloth.rolling_resistance': 0.00995 } })")
    assert shown_in(browser, 'rolling') == '0.00995'
    wide = browser.run(
        "[...document.querySelectorAll('.field [type=number]')].every((each) =>"
        ' each.scrollWidth <= each.clientWidth)'
    )
    assert wide  # no digit is cut off
    slide = (
        "(() => {{ const slider = document.querySelectorAll('#stroke [type=range]')[{}];"
        "slider.value = {}; slider.dispatchEvent(new Event('input')); }})()"
    )
    open_tab(browser, 'aim')
    for number, name, value, played in (
        (0, 'speed', 2.123456, 2.12),
        (2, 'azimuth', 31.98765, math.radians(31.99)),
        (1, 'elevation', 90, math.pi / 2),
    ):
        browser.run(slide.format(number, value))
        assert browser.run(f'view.state.stroke.{name}') == pytest.approx(played, abs=1e-12)


@pytest.mark.skipif(shutil.which('node') is None, reason='needs Node')
def test_page_and_terminal_round_alike():
    draw = random.Random(3)
    values = [0, 1, 0.465, 0.475, 0.005, 0.0025, 0.995, 0.99951, 1e-5, 0.125]
    values += [draw.randint(0, 2000) / 2000 for _ in range(300)]
    script = (PAGES / 'elements.js').read_text()
    script += f'console.log(JSON.stringify({values}.map(percent)));'
    done = ran(['node', '-e', script], check=True)
    assert json.loads(done.stdout) == [f'{percent(value)} %' for value in values]
    assert json.loads(done.stdout)[2] == '46 %'


def test_differences_of_effects_name_ball_and_distance(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    open_tab(browser, 'table')
    browser.wait_for("[...document.querySelectorAll('#effects output')].every((o) => o.value)")
    for text in browser.run(
        "[...document.querySelectorAll('#effects output')].map((o) => o.value)"
    ):
        assert re.fullmatch(
            r'–|refused|(cue ball|ball \d+) (ends elsewhere|by (< 1|\d+) mm)', text
        ), text


# ---- links ----


def test_a_link_leads_to_where_the_page_is_published(browser, tmp_path):
    path = tmp_path / 'page.html'
    opened(browser, path, page_of_scene('blocked', site='https://host.example/table.html'))
    browser.run('view.aim({ speed: 3 })')
    open_tab(browser, 'share')
    link = browser.run("document.getElementById('exported').value")
    assert link.startswith('https://host.example/table.html#')
    assert browser.run(TEXT.format('reach')) == ''
    opened(browser, path, page_of_scene('blocked'), '#' + link.split('#')[1])
    assert browser.run('view.state.stroke.speed') == 3
    open_tab(browser, 'share')
    assert browser.run("document.getElementById('exported').value").startswith('file:')
    assert 'send the file, too' in browser.run(TEXT.format('reach'))


@pytest.mark.parametrize('accepted', [True, False])
def test_a_link_of_another_table_asks_before_it_is_applied(browser, tmp_path, accepted):
    opened(browser, tmp_path / 'one.html', page_of_scene('blocked'))
    browser.run('view.aim({ speed: 3.21 })')
    browser.wait_for('location.hash.length > 1')
    fragment = browser.run('location.hash')
    opened(browser, tmp_path / 'two.html', page_of_scene('jump_cue'))
    before = browser.run('view.state.stroke.speed')
    browser.run(
        f'window.confirm = (text) => {{ window.asked = text; return {str(accepted).lower()}; }};'
        f'location.hash = {fragment!r}'
    )
    browser.wait_for('window.asked')
    assert 'another table' in browser.run('window.asked')
    assert browser.run('view.state.stroke.speed') == (3.21 if accepted else before)


@pytest.mark.parametrize(
    ('fragment', 'why'),
    [
        ('%%%', 'a part of it is missing, or was changed'),
        ('eyJzdHJva2UiOnsi', 'a part of it is missing, or was changed'),
        ('W10', 'its content makes no sense'),
    ],
)
def test_a_damaged_link_says_why_it_is_not_followed(browser, tmp_path, fragment, why):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'), f'#{fragment}')
    assert browser.run(TEXT.format('hint')) == f'The link cannot be followed: {why}.'
    assert browser.messages == []


# ---- with a keyboard, and for screen readers ----


def test_the_tip_and_the_tabs_are_moved_with_keys(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    time = browser.run('view.time')
    browser.run("document.getElementById('face').focus()")
    for key in ('ArrowRight', 'ArrowUp', 'ArrowUp'):
        browser.press(key)
    a, b = browser.run('[view.state.stroke.a, view.state.stroke.b]')
    assert [a, b] == pytest.approx([0.02, 0.04])
    assert '0.02 R to the right, 0.04 R up' in browser.run(
        "document.getElementById('face').ariaLabel"
    )
    browser.run("document.getElementById('tab-aim').focus()")
    browser.press('ArrowRight')
    assert browser.run('document.activeElement.id') == 'tab-shots'
    assert browser.run("document.getElementById('panel-shots').hidden") is False
    assert browser.run('view.time') == time


def test_the_focus_is_seen_on_the_table(browser, tmp_path):
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked'))
    browser.press('Tab')
    assert browser.run('document.activeElement.id') == 'canvas'
    style = "getComputedStyle(document.getElementById('canvas'))"
    assert browser.run(f'{style}.outlineStyle') == 'solid'
    assert browser.run(f'parseFloat({style}.outlineOffset)') < 0  # inside of the window


@pytest.mark.parametrize('mode', ['dark', 'light'])
def test_axe_finds_nothing(browser, tmp_path, mode):
    core = pytest.importorskip('axe_core_python')
    axe = (Path(core.__file__).parent / 'axe.min.js').read_text()
    media = [{'name': 'prefers-color-scheme', 'value': mode}]
    browser.call('Emulation.setEmulatedMedia', features=media)
    opened(browser, tmp_path / 'page.html', page_of_scene('blocked', planner=True))
    browser.run(f'{axe}; 0')
    browser.press('k')
    names = browser.run("[...document.querySelectorAll('#tabs button')].map((e) => e.innerText)")
    for name in names:
        open_tab(browser, name.lower())
        found = browser.run(
            'axe.run().then(({ violations }) => violations.map(({ id, nodes }) =>'
            ' [id, nodes.map(({ html }) => html)]))'
        )
        assert found == [], name
    browser.call('Emulation.setEmulatedMedia', features=[])
    assert len(names) == 8


# ---- in another browser ----


@pytest.mark.skipif(find_firefox() is None, reason='needs Firefox')
def test_firefox_plays_what_python_predicts(tmp_path):
    (tmp_path / 'profile').mkdir()
    page, firefox = tmp_path / 'page.html', Firefox(tmp_path / 'profile')
    try:
        page.write_text(page_of_scene('eight_ball'), encoding='utf-8')
        firefox.open(page)
        stroke, found = firefox.run('[view.state.stroke, view.outcome]')
        shot = predict('eight_ball', Stroke.from_offsets(**stroke))
        assert found['message'] == shot.message
        assert {name: end['position'] for name, end in found['balls'].items()} == {
            name: place.tolist() for name, place in shot.run.final_position.items()
        }
        firefox.run("document.getElementById('play').click()")
        assert firefox.run('view.playing')
    finally:
        firefox.close()

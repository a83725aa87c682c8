"""The page that `explore --plan` serves: plans for it, and nothing for other pages."""

import asyncio
from contextlib import closing, contextmanager, suppress
from functools import partial
from http.client import HTTPConnection
import json
from queue import SimpleQueue
import signal
import socket
import subprocess
import sys
from threading import Barrier, Event, Thread
import time
from urllib.parse import urlsplit

from browser import choose, click, find_browser, open_tab
import numpy as np
import pytest

from billiard_shot import machine_code, plan, Scene
from billiard_shot.cli import main
from billiard_shot.pictures.view import page_of_scene
from billiard_shot.planning.plan import USUAL_SECONDS

pytest.importorskip('tornado', reason='needs the extra live')
from billiard_shot.cli import plan_server

SCENE = Scene.load('frozen_combination')
POT = {'state': {}, 'target': {'pot': '8'}, 'seconds': 600}
PATIENCE = 60  # s
needs_browser = pytest.mark.skipif(
    find_browser() is None or not machine_code.is_loaded(), reason='needs Chromium, machine code'
)


def quickly(monkeypatch, budget=3000):
    monkeypatch.setattr(plan_server, 'plan', partial(plan, budget=budget))


@pytest.fixture
def address():
    """The address of a page that is served in a thread."""
    page = '<p>the page</p>'
    yield from served(page)


@pytest.fixture
def live():
    """The same with the real page."""
    yield from served(page_of_scene(SCENE, planner=True))


def served(page, port=0):
    told = SimpleQueue()

    async def serve():
        told.put((asyncio.get_running_loop(), asyncio.current_task()))
        await plan_server.serve(SCENE, page, port, told.put)

    def run():
        with suppress(asyncio.CancelledError), asyncio.Runner() as runner:
            runner.run(serve())

    thread = Thread(target=run)
    thread.start()
    loop, task = told.get(timeout=PATIENCE)
    yield told.get(timeout=PATIENCE)
    loop.call_soon_threadsafe(task.cancel)
    thread.join(PATIENCE)
    assert not thread.is_alive()


def connection(address):
    return closing(HTTPConnection(urlsplit(address).netloc, timeout=PATIENCE))


def origin_of(address):
    return f'http://{urlsplit(address).netloc}'


def asked(address, request, origin=None, **headers):
    """Status, headers and lines of the answer to a request for a plan."""
    with connection(address) as asking:
        headers |= {'Origin': origin or origin_of(address)}
        asking.request('POST', f'{urlsplit(address).path}plan', json.dumps(request), headers)
        answer = asking.getresponse()
        return answer.status, answer.headers, answer.read().decode().splitlines()


def lines_of(address, request):
    status, _, lines = asked(address, request)
    assert status == 200
    return [json.loads(line) for line in lines]


# ---- plans ----


def test_a_plan_is_that_of_python_and_its_strokes_come_as_they_are_found(address, monkeypatch):
    quickly(monkeypatch)
    *progress, last = lines_of(address, POT)
    truth = plan(SCENE, {'pot': '8'}, budget=3000)
    assert last['result']['message'] == truth.message
    assert [(each['speed'], each['success']) for each in last['result']['ranking']] == [
        (each.stroke.speed, each.success) for each in truth.ranking
    ]
    found = [line['progress'] for line in progress if line['progress']['stroke']]
    assert found
    assert all(0 < each['success'] <= 1 for each in found)
    assert found[0]['stroke'].keys() == {'a', 'b', 'elevation', 'azimuth', 'speed'}


def test_a_plan_is_for_the_state_of_the_page(address, monkeypatch):
    given = []

    def note(scene, target, noise, **options):
        given[:] = scene, target, noise, options['seconds']
        raise ValueError('noted')

    monkeypatch.setattr(plan_server, 'plan', note)
    state = {
        'balls': {'cue': [0.1, 0.2], '8': [0.5, 0.1]},
        'effects': ['throw'],
        'parameters': {'cloth.rolling_resistance': 0.02},
        'noise': {'a': 0.1, 'b': 0, 'elevation': 0, 'azimuth': 0.01, 'speed': 0.5},
    }
    asked = {'state': state, 'target': {'hit': '8'}}
    assert lines_of(address, asked) == [{'refused': 'noted'}]
    assert given[3] == USUAL_SECONDS
    assert lines_of(address, {**asked, 'seconds': 7.5}) == [{'refused': 'noted'}]
    scene, target, noise, seconds = given
    assert seconds == 7.5
    assert scene.balls == {'cue': (0.1, 0.2), '8': (0.5, 0.1)}
    assert scene.effects.throw == 'off'
    assert scene.cloth.rolling_resistance == 0.02
    assert target == {'hit': '8'}
    assert noise.sigmas(scene.ball.radius).tolist() == pytest.approx([0.1, 0, 0, 0.01, 0.5])


@pytest.mark.parametrize(
    ('request_', 'why'),
    [
        ({'state': {}, 'target': {'pot': '9'}}, 'target: pot must be one of 1, 8'),
        (
            {'state': {}, 'target': {'pot': '8'}, 'seconds': -1},
            'seconds must be finite and above 0, got -1',
        ),
        ({'state': {'balls': {'cue': [9, 0]}}, 'target': {'hit': '8'}}, 'balls.cue must be '),
        ({'state': {'parameters': {'cloth.colour': 1}}, 'target': {'hit': '8'}}, 'unknown'),
        ({'state': {'effects': ['wind']}, 'target': {'hit': '8'}}, 'wind'),
    ],
)
def test_a_request_that_makes_no_sense_is_told_why(address, request_, why):
    (line,) = lines_of(address, request_)
    assert why in line['refused']


@pytest.mark.parametrize(
    ('body', 'why'),
    [
        ('{"state": {', 'Expecting'),
        ('"x"', 'a request must have state and target'),
        ('{"target": {"pot": "8"}}', 'a request must have state and target'),
        ('{"state": {}}', 'a request must have state and target'),
        ('{"state": [], "target": {}}', 'state must be an object, got []'),
        ('{"state": {"effects": [7]}, "target": {}}', 'state.effects must be a list of names'),
        ('{"state": {"noise": {"a": "x"}}, "target": {}}', 'state.noise must have a number'),
        ('{"state": {"parameters": []}, "target": {}}', 'state.parameters must have a number'),
    ],
)
def test_a_request_without_the_form_of_one_is_answered_by_400(address, body, why):
    with connection(address) as asking:
        headers = {'Origin': origin_of(address)}
        asking.request('POST', f'{urlsplit(address).path}plan', body, headers)
        answer = asking.getresponse()
        assert answer.status == 400
        assert why in answer.read().decode()


def test_a_search_that_fails_says_why(address, monkeypatch):
    quickly(monkeypatch, budget=200)
    balls = {'cue': [-0.5, 0], '1': [0.4, 0.0], '8': [0.46, 0.0]}
    request = {'state': {'balls': balls}, 'target': {'pot': '8', 'pocket': 'head_left'}}
    result = lines_of(address, request)[-1]['result']
    assert result['status'] == 'NO_PLAN'
    assert result['ranking'] == []
    assert 'no stroke reaches the target' in result['message']


def endless(begun, ended):
    """A search that ends only if it is cancelled."""

    def search(scene, target, noise, progress, cancel, **_):
        begun.set()
        end = time.monotonic() + PATIENCE
        while not cancel() and time.monotonic() < end:
            time.sleep(0.01)
        if cancel():
            ended.set()
        raise ValueError('ended')

    return search


def test_a_page_that_leaves_cancels_its_search(address, monkeypatch):
    begun, ended = Event(), Event()
    monkeypatch.setattr(plan_server, 'plan', endless(begun, ended))
    with connection(address) as asking:
        headers = {'Origin': origin_of(address)}
        asking.request('POST', f'{urlsplit(address).path}plan', json.dumps(POT), headers)
        assert begun.wait(PATIENCE)
        assert not ended.is_set()
    assert ended.wait(PATIENCE)


def test_two_pages_are_served_at_the_same_time(address, monkeypatch):
    both = Barrier(2, timeout=PATIENCE)

    def search(scene, target, *_, **__):
        both.wait()
        raise ValueError(f'for {target}')

    monkeypatch.setattr(plan_server, 'plan', search)
    answers = SimpleQueue()
    for target in ('1', '2'):
        request = {'state': {}, 'target': target}
        Thread(
            target=lambda asking: answers.put(lines_of(address, asking)), args=[request]
        ).start()
    found = [answers.get(timeout=PATIENCE)[0]['refused'] for _ in '12']
    assert sorted(found) == ['for 1', 'for 2']


# ---- other pages ----


def test_the_page_cannot_be_framed_kept_or_read(address):
    with connection(address) as asking:
        asking.request('GET', urlsplit(address).path)
        answer = asking.getresponse()
        assert (answer.status, answer.read()) == (200, b'<p>the page</p>')
    assert answer.headers['Content-Security-Policy'] == "frame-ancestors 'none'"
    assert answer.headers['X-Frame-Options'] == 'DENY'
    assert answer.headers['Cross-Origin-Opener-Policy'] == 'same-origin'
    assert answer.headers['Cross-Origin-Resource-Policy'] == 'same-origin'
    assert answer.headers['Cache-Control'] == 'no-store'
    assert not any(name.startswith('Access-Control') for name in answer.headers)


FOREIGN = {
    'another origin': {'Origin': 'https://evil.example'},
    'a file or a frame in a sandbox': {'Origin': 'null'},
    'another port': {'Origin': 'http://127.0.0.1:1'},
    'another name': {'Host': 'localhost'},
    'a name bound to this address': {'Host': 'evil.example', 'Origin': 'http://evil.example'},
    'no origin': {'Origin': ''},
}


@pytest.mark.parametrize('headers', FOREIGN.values(), ids=FOREIGN.keys())
@pytest.mark.parametrize('method', ['GET', 'POST', 'OPTIONS', 'PUT'])
def test_other_pages_are_refused(address, monkeypatch, headers, method):
    begun = Event()
    monkeypatch.setattr(plan_server, 'plan', endless(begun, Event()))
    port = urlsplit(address).port
    headers = {
        name: f'{text}:{port}' if name == 'Host' else text for name, text in headers.items()
    }
    path = urlsplit(address).path + ('' if method == 'GET' else 'plan')
    with connection(address) as asking:
        asking.request(method, path, json.dumps(POT), headers)
        answer = asking.getresponse()
        read = answer.read()
    if method == 'GET' and headers == {'Origin': ''}:
        return  # that of a person
    assert answer.status == 403
    assert b'the page' not in read
    assert not any(name.startswith('Access-Control') for name in answer.headers)
    assert not begun.is_set()


@pytest.mark.parametrize('path', ['/', '//', '/x/', '/{}x/', '/%C3%A4/', '/{}/../x/', '/{}/x'])
def test_the_token_is_needed(address, path):
    token = urlsplit(address).path.strip('/')
    assert len(token) >= 32
    for method, name in (('GET', ''), ('POST', 'plan')):
        with connection(address) as asking:
            headers = {'Origin': origin_of(address)}
            asking.request(method, path.format(token) + name, json.dumps(POT), headers)
            answer = asking.getresponse()
            assert answer.status == 404
            assert b'the page' not in answer.read()


def test_the_usual_port_is_not_named(monkeypatch):
    with socket.create_server(('127.0.0.1', 0)) as free:
        port = free.getsockname()[1]
    monkeypatch.setattr(plan_server, 'USUAL_PORT', port)
    server = served('the page', port)
    address = next(server)
    assert address.startswith('http://127.0.0.1/')
    with closing(HTTPConnection('127.0.0.1', port, timeout=PATIENCE)) as asking:
        asking.request('GET', urlsplit(address).path, headers={'Host': '127.0.0.1'})
        assert asking.getresponse().read() == b'the page'
    next(server, None)


def test_each_start_has_another_token(address):
    others = served('')
    assert urlsplit(next(others)).path != urlsplit(address).path
    next(others, None)


def test_a_request_that_is_too_large_is_refused(address):
    with connection(address) as asking:
        asking.putrequest('POST', f'{urlsplit(address).path}plan')
        asking.putheader('Origin', origin_of(address))
        asking.putheader('Content-Length', str(2 * plan_server.LARGEST_REQUEST))
        asking.endheaders()
        assert asking.getresponse().status in (400, 413)


# ---- the command ----


@contextmanager
def ended(process):
    """End a process in any case: a test that fails would wait for it without end."""
    try:
        yield
    finally:
        process.kill()


@pytest.mark.skipif(sys.platform == 'win32', reason='needs signals')
def test_ctrl_c_ends_it_also_during_a_search():
    command = [sys.executable, '-m', 'billiard_shot', 'explore', 'snooker', '--plan']
    with (
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # shells let processes in the background ignore it, and so all that these start
            preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
        ) as server,
        ended(server),
    ):
        address = server.stdout.readline().strip()
        with connection(address) as asking:
            headers = {'Origin': origin_of(address)}
            path = f'{urlsplit(address).path}plan'
            request = {'state': {}, 'target': {'safe': 'any', 'chance': 0}}
            asking.request('POST', path, json.dumps(request), headers)
            assert b'progress' in asking.getresponse().readline()
            server.send_signal(signal.SIGINT)
            _, said = server.communicate(timeout=PATIENCE)
    assert (server.returncode, said) == (0, '')


@pytest.mark.parametrize(
    ('options', 'why'),
    [
        (['--port', '65536'], '--port must be a whole number, at most 65535, got 65536'),
        (['-o', 'table.html'], '--output must not be given together with --plan'),
        (['--site', 'https://host/'], '--site must not be given together with --plan'),
    ],
)
def test_wrong_options(options, why, capsys):
    assert main(['explore', 'paper', '--plan', *options]) == 2
    assert why in capsys.readouterr().err


@pytest.mark.parametrize(
    ('options', 'why'),
    [
        (['--port', '8000'], '--port needs --plan'),
        (['--site', 'here'], "--site must be an address, such as https://host/table.html, got '"),
    ],
)
def test_options_without_a_meaning_are_refused(options, why, capsys, tmp_path):
    page = tmp_path / 'page.html'
    assert main(['explore', 'paper', '-o', str(page), *options]) == 2
    assert why in capsys.readouterr().err
    assert not page.exists()


def test_without_tornado_the_command_names_the_extra(monkeypatch, capsys):
    monkeypatch.delitem(sys.modules, 'billiard_shot.cli.plan_server')
    monkeypatch.setitem(sys.modules, 'tornado.httpserver', None)
    assert main(['explore', 'paper', '--plan']) == 2
    assert "pip install 'billiard_shot[live]'" in capsys.readouterr().err


# ---- in a browser ----


def opened(browser, address):
    browser.messages.clear()
    browser.open(address)
    browser.wait_for('document.body.dataset.ready === "true"')
    open_tab(browser, 'plan')


def press_search(browser):
    browser.run("document.getElementById('search').click()")


SAID = "document.getElementById('planned').textContent"
ROWS = "[...document.querySelectorAll('#plans b')].map((b) => b.textContent)"


@needs_browser
def test_plans_are_tried_and_changed_in_the_page(browser, live, monkeypatch):
    quickly(monkeypatch)
    opened(browser, live)
    choose(browser, 'goal-ball', '8')
    browser.run("document.getElementById('seconds').value = '600'")
    press_search(browser)
    browser.wait_for("document.getElementById('search').textContent === 'Plan'")
    truth = plan(SCENE, {'pot': '8'}, budget=3000)
    assert browser.run(SAID) == truth.message
    assert len(browser.run(ROWS)) == len(truth.ranking)
    before = browser.run('view.state.balls')
    browser.run("document.querySelectorAll('#plans button')[0].click()")
    assert browser.run('view.outcome.message') == truth.best.shot.message
    assert browser.run('view.state.target') == {'ball': '8'}
    browser.run('view.aim({ speed: view.state.stroke.speed + 1 })')
    browser.run('view.change({ balls: { ...view.state.balls, cue: [0, 0.3] } })')
    browser.run("document.querySelectorAll('#plans button')[0].click()")
    assert browser.run('view.outcome.message') == truth.best.shot.message
    assert browser.run('view.state.balls') == before
    assert browser.messages == []
    origin = origin_of(live)
    assert all(url.startswith((origin, 'blob:', 'data:')) for url in browser.requests)


@needs_browser
@pytest.mark.parametrize(
    ('goal', 'places'),
    [('rest', [(0.3, 0.2)]), ('pass', [(0.3, 0.2)]), ('gate', [(0.2, -0.1), (0.2, 0.1)])],
)
def test_places_of_a_goal_are_clicked(browser, live, monkeypatch, goal, places):
    asked = []

    def note(scene, target, noise, **options):
        asked.append(target)
        raise ValueError('noted')

    monkeypatch.setattr(plan_server, 'plan', note)
    opened(browser, live)
    choose(browser, 'goal', goal)
    press_search(browser)
    browser.wait_for(f"{SAID} === 'noted'")
    assert asked.pop() == {goal: []}
    height = SCENE.ball.radius
    for place in [(-0.9, 0.4), *places]:  # only the last ones count
        click(browser, *browser.run(f'view.project([{place[0]}, {place[1]}, {height}])')[:2])
    assert browser.run('view.followed') is None
    press_search(browser)
    browser.wait_for(f"{SAID} === 'noted'")
    browser.wait_for("document.getElementById('search').textContent === 'Plan'")
    ((name, found),) = asked.pop().items()
    assert name == goal
    expected = places if goal == 'gate' else places[0]
    within = 0.005  # m: pointers are on whole pixels
    assert np.array(found) == pytest.approx(np.array(expected), abs=within)
    assert browser.messages == []


@needs_browser
def test_a_search_is_cancelled_in_the_page_and_a_failure_is_told(browser, live, monkeypatch):
    begun, ended = Event(), Event()
    monkeypatch.setattr(plan_server, 'plan', endless(begun, ended))
    opened(browser, live)
    press_search(browser)
    assert begun.wait(PATIENCE)
    press_search(browser)
    browser.wait_for(f"{SAID} === 'Cancelled.'")
    assert ended.wait(PATIENCE)
    with monkeypatch.context() as broken:  # such as for a lack of memory
        broken.setattr(plan_server, 'as_json', lambda result: 1 / 0)
        broken.setattr(plan_server, 'plan', partial(plan, budget=100))
        press_search(browser)
        browser.wait_for(f"{SAID} === 'The search has ended without a result.'")
    monkeypatch.setattr(plan_server, 'plan', plan)
    choose(browser, 'goal', 'hit')
    press_search(browser)
    browser.wait_for(f"{SAID}.includes('hit must be')")


@needs_browser
def test_a_page_of_another_origin_gets_nothing(browser, live, tmp_path, monkeypatch):
    """Even if it knew the address: no frame, no text, no plan."""
    begun = Event()
    monkeypatch.setattr(plan_server, 'plan', endless(begun, Event()))
    hostile = tmp_path / 'hostile.html'
    hostile.write_text(
        f'<script>const address = {json.dumps(live)};'
        'const tried = (what) => what.then((x) => x.type, (error) => error.name);'
        '</script>',
        encoding='utf-8',
    )
    browser.open(hostile)
    assert browser.run('tried(fetch(address))') == 'TypeError'
    post = "tried(fetch(address + 'plan', {{ method: 'POST', body: '{{}}', mode: '{}' }}))"
    assert browser.run(post.format('cors')) == 'TypeError'
    assert browser.run(post.format('no-cors')) in ('TypeError', 'opaque')
    assert not begun.is_set()
    browser.messages.clear()
    browser.run(
        "new Promise((done) => { const frame = document.createElement('iframe');"
        'frame.onload = done; frame.src = address; document.body.append(frame); }).then(() => 0)'
    )
    assert 'frame-ancestors' in json.dumps(browser.messages)

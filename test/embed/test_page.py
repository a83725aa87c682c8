"""The core in pages: WebAssembly gives the bits of the library; the module in JavaScript."""

import base64
import gzip
import hashlib
import json
import math
from pathlib import Path

from browser import Browser, find_browser
from node_js import needs_node, NODE
import numpy as np
from programs import ran
import pytest

from billiard_shot import machine_code, predict, predict_batch, Scene, shots, Stroke
from billiard_shot.compiler.build import PAGES
from billiard_shot.embed.scenes import core_folder, export_scene, MODULE
from billiard_shot.planning.statistics import wilson_interval
from billiard_shot.scene.player import OFFSETS
from billiard_shot.shot.play import (
    Accuracy,
    DEFAULT_SHOT_TOLERANCE,
    play_by,
    prepared_scene,
    task_of,
)
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates
from billiard_shot.table.run.task import run_with_events

pytestmark = pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
needs_browser = pytest.mark.skipif(find_browser() is None, reason='needs Chromium')


def in_node(scene, **asked):
    """What node.mjs answers for a scene as it is exported."""
    done = ran(
        [NODE, Path(__file__).with_name('node.mjs')],
        input=json.dumps({'folder': str(core_folder(PAGES)), 'scene': scene, **asked}),
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# ---- the same bits ----


def drawn(scene, count):
    """Random tables and strokes, some that are refused, and some that are none."""
    setting, draw = prepared_scene(scene), np.random.default_rng(count)
    present = draw.random((count, len(setting.names))) < draw.choice([0.5, 1.0], (count, 1))
    present[:, 0] = True
    position = np.repeat(setting.starts['position'], count, axis=0)
    low, high = (-0.6, -0.6, -0.05, -math.pi, 0.3), (0.6, 0.6, 1.2, math.pi, 9.0)
    offsets = draw.uniform(low, high, (count, 5))
    offsets[::25, 0] = 2.0
    offsets[7::50, 4] = np.nan
    offsets[9::50, 1] = np.inf
    return TableStates(setting.names, position, present=present), offsets


def played_in_node(scene, tables, offsets):
    """Digests of what the page writes for strokes at tables."""
    balls = [
        {name: place[:2] for name, place, there in zip(tables.names, *table, strict=True) if there}
        for table in zip(tables.position.tolist(), tables.present.tolist(), strict=True)
    ]
    rows = [[str(each).replace('inf', 'Infinity') for each in row] for row in offsets.tolist()]
    return in_node(scene, strokes=list(zip(balls, rows, strict=True)))


def played(scene, tables, offsets):
    """Digests of what the library writes, and the statuses."""
    digests, statuses = [], set()
    for i in range(len(offsets)):
        prepared, table = prepared_scene(scene), tables.take(slice(i, i + 1))
        vectors = vectors_of(offsets[i : i + 1])
        task = task_of(prepared, *vectors, table, Accuracy(DEFAULT_SHOT_TOLERANCE))
        found = play_by(run_with_events, prepared.model, task)
        made, (events, members) = hashlib.sha256(), found.events
        for rows in (found.balls, found.tables, found.cues, found.segments, events, members):
            made.update(rows.tobytes())
        digests.append(made.hexdigest())
        statuses.add(int(found.tables['status'][0]))
    return digests, statuses


@needs_node
@pytest.mark.parametrize(
    ('name', 'count'),
    [
        ('paper', 200),
        ('pool_table', 200),
        ('frozen_combination', 200),
        ('blocked', 200),
        ('carom', 200),
        ('nine_ball', 120),
        ('eight_ball', 80),
    ],
)
def test_webassembly_gives_the_bits_of_the_library(name, count):
    scene = Scene.load(name)
    tables, offsets = drawn(scene, count)
    digests, statuses = played(scene, tables, offsets)
    assert played_in_node(export_scene(scene), tables, offsets) == digests
    assert {0, 100, 101, 103} <= statuses


@needs_node
def test_a_break_has_the_same_bits_also_if_its_record_outgrows_its_room():
    scene = Scene.load('nine_ball')
    tables = TableStates(prepared_scene(scene).names, prepared_scene(scene).starts['position'])
    way = np.subtract(scene.balls['1'], scene.cue_ball[:2])
    offsets = np.array([[0.0, 0.1, 0.05, math.atan2(way[1], way[0]), 9.0]])
    digests, _ = played(scene, tables, offsets)
    exported = export_scene(scene)
    assert played_in_node(exported, tables, offsets) == digests
    arguments = exported['entries']['play_tables']
    arguments['tables']['segments']['shape'] = arguments['tables']['events']['shape'] = [1]
    arguments['room']['participants']['shape'] = [1, 2]
    assert played_in_node(exported, tables, offsets) == digests


# ---- the module ----

BLOCKED = Scene.load('blocked')
TIMES = [-1, 0, 0.3, 1.1, 2.7, 99]
STROKE = {'a': 0.1, 'elevation': 0.05, 'azimuth': 0.12, 'speed': 4.0}


def events_of(run):
    return [[each.time, each.kind, list(each.balls), each.place] for each in run.events]


@needs_node
def test_events_have_the_names_of_python():
    _, offsets = drawn(BLOCKED, 150)
    asked, expected = [], []
    for offset in offsets[np.isfinite(offsets).all(axis=1)].tolist():
        shot = predict(BLOCKED, Stroke.from_offsets(*offset))
        if not shot.status.refused:
            expected.append(events_of(shot.run))
            asked.append(dict(zip(OFFSETS, offset, strict=True)))
    script = f"""
    return {json.dumps(asked)}.map((stroke) => table.shoot(table.scene.places, stroke).events
      .map(({{ time, kind, balls, place }}) => [time, kind, balls, place]));"""
    assert in_node(export_scene(BLOCKED), script=script) == expected
    kinds = {kind for events in expected for _, kind, _, _ in events}
    assert {'land', 'bounce', 'roll', 'spin_end', 'rest', 'ball', 'cushion', 'pocket'} <= kinds


@needs_node
def test_a_double_hit_reaches_no_target():
    balls = {'cue': [1.0, 0.42], '8': [1.04395, 0.46395]}
    script = f"""
    const balls = {json.dumps(balls)};
    const stroke = {{ elevation: Math.PI / 22.5, azimuth: Math.PI / 4, speed: 2 }};
    const shot = table.shoot(balls, stroke);
    const noise = {{ a: 0, b: 0, elevation: 0, azimuth: 0, speed: 0 }};
    const found = await table.chance(balls, stroke, {{ ball: '8' }}, noise, 3);
    return [shot.doubleHit, shot.balls[8].pocket, shot.reaches({{ ball: '8' }}), found.chance];"""
    scene = Scene.from_dict({'like': 'pool_table', 'balls': balls})
    assert in_node(export_scene(scene), script=script) == [True, 'foot_left', False, 0]


@needs_node
def test_a_shot_tells_what_happened():
    script = f"""
    const shot = table.shoot(table.scene.places, {json.dumps(STROKE)});
    const events = shot.events.map(({{ time, kind, balls, place }}) => [time, kind, balls, place]);
    const path = {TIMES}.map((time) => shot.at(time));
    return {{ ...shot, events, path, segments: shot.segments }};"""
    found = in_node(export_scene(BLOCKED), script=script)
    shot = predict(BLOCKED, Stroke.from_offsets(**STROKE))
    run = shot.run
    assert (found['status'], found['duration']) == (shot.status.name, run.duration)
    assert found['error'] == shot.error_estimate
    assert {name: end['position'] for name, end in found['balls'].items()} == {
        name: place.tolist() for name, place in run.final_position.items()
    }
    pocketed = {name: end['pocket'] for name, end in found['balls'].items() if 'pocket' in end}
    assert pocketed == run.pocketed
    assert found['events'] == events_of(run)
    assert {len(balls) for _, _, balls, _ in found['events']} == {1, 2}
    for time, states in zip(TIMES, found['path'], strict=True):
        for name, state in run.at(time).items():
            assert states[name]['motion'] == Motion(int(state.motion)).name
            for vector in ('position', 'velocity', 'spin'):
                assert states[name][vector] == getattr(state, vector).tolist()
    for name, ball in run.balls.items():
        assert [each['time'] for each in found['segments'][name]] == ball.rows['time'].tolist()


@needs_node
def test_a_table_that_takes_memory_over_plays_as_a_new_one():
    script = f"""
    const play = (each) => each.shoot(each.scene.places, {json.dumps(STROKE)}).balls;
    const first = play(table);
    table.play({{ cue: [-1, 0.3] }}, {{ speed: 7 }});
    return [first, play(new core.Table(table.scene, table))];"""
    first, again = in_node(export_scene(BLOCKED), script=script)
    assert again == first


@needs_node
def test_a_stroke_is_also_given_by_its_vectors():
    stroke = Stroke((-2, -1, 12), (4, 0, -16))
    given = {'normal': stroke.normal, 'velocity': stroke.velocity}
    script = f'return table.shoot(table.scene.places, {json.dumps(given)}).balls;'
    found = in_node(export_scene('paper'), script=script)
    end = predict(Scene.load('paper'), stroke).final_position['cue']
    assert found['cue']['position'] == end.tolist()


@needs_node
def test_direct_shots_are_those_of_python():
    balls = {'cue': (-0.3, 0.1), '1': (0.2, 0.3), '8': (0.7, -0.2)}
    script = f'return table.shots({json.dumps(balls)}, ["1", "8"]);'
    found = in_node(export_scene(BLOCKED), script=script)
    names = prepared_scene(BLOCKED).names
    position = np.array([[(*balls[name], BLOCKED.ball.radius) for name in names]])
    expected = shots(BLOCKED, TableStates(names, position), legal=['1', '8'])
    assert len(expected) > 2
    assert [(each['ball'], each['pocket'], each['chance']) for each in found] == [
        (names[ball], POCKET_NAMES[pocket], chance)
        for ball, pocket, chance in zip(
            expected.ball, expected.pocket, expected.chance, strict=True
        )
    ]
    strokes = [
        [each['stroke'][name] for name in ('elevation', 'azimuth', 'speed')] for each in found
    ]
    assert strokes == expected.offsets[:, 2:].tolist()
    assert in_node(export_scene(BLOCKED), script='return table.shots({ cue: [0, 0] });') == []


CHANCE = """
const places = { cue: [-0.4, 0], 8: [0.6, 0.2] };
const [shot] = table.shots(places).sort((a, b) => b.chance - a.chance);
const found = await table.chance(places, shot.stroke, shot, undefined, 500, 7);
const strokes = table.drawn(shot.stroke, table.scene.noise, 500, 7);
table.close();
return JSON.stringify({ ...found, strokes: strokes.map(Object.values), pocket: shot.pocket });
"""


def check_chance(found):
    scene = Scene.from_dict({'like': 'blocked', 'balls': {'cue': [-0.4, 0], '8': [0.6, 0.2]}})
    batch = predict_batch(scene, offsets=found['strokes'])
    falls = batch.pocket[:, batch.names.index('8')] == POCKET_NAMES.index(found['pocket'])
    successes = int((falls & (batch.pocket[:, 0] < 0) & ~batch.off_table[:, 0]).sum())
    assert 0 < successes < 500
    assert found['chance'] == successes / 500
    assert found['interval'] == pytest.approx(wilson_interval(successes, 500), rel=1e-12)
    errors = np.std(found['strokes'], axis=0)
    assert errors == pytest.approx(scene.noise.sigmas(scene.ball.radius), rel=0.15)


@needs_node
def test_chances_are_shares_of_strokes_as_python_predicts_them():
    check_chance(json.loads(in_node(export_scene(BLOCKED), script=CHANCE)))


@needs_node
@pytest.mark.parametrize(
    ('call', 'said'),
    [
        (
            'shoot({ cue: [0, 0] }, { speed: 0 })',
            'stroke.speed must be 1e-12 to 1000000000000, got 0 (m/s)',
        ),
        ('shoot({ cue: [0, 0] }, { speed: NaN })', 'stroke.speed must be 1e-12 to'),
        ('shoot({ cue: [0, 0] }, { speed: 1, azimuth: 7 })', 'stroke.azimuth must be -6.28'),
        ('shoot({ cue: [0, 0] }, { speed: 1, spin: 1 })', 'stroke must be a or b or'),
        (
            'shoot({ cue: [0, "1"] }, { speed: 1 })',
            'balls.cue[1] must be -0.6858 to 0.6858, got 1 (m)',
        ),
        (
            'shoot({ cue: [0, 0] }, { normal: [0, 0, 1], velocity: [0, 0] })',
            'the length of stroke.velocity must be 3, got 2',
        ),
        (
            'shoot({ cue: [0, 0] }, { normal: [0, 0, NaN], velocity: [1, 0, 0] })',
            'stroke.normal must be -1',
        ),
        ('shots({ cue: [0, 0, 0.03] })', 'the length of balls.cue must be 2, got 3'),
        ('shoot({ 8: [0, 0] }, { speed: 1 })', 'balls.cue[0] must be'),
        ('shoot({ cue: [0, 0], 9: [1, 0] }, { speed: 1 })', 'balls must be cue or 1 or 8, got 9'),
        (
            'shoot({ cue: [0, 0], 8: [0.05, 0] }, { speed: 1 })',
            'distance of 8 and cue must be 0.057',
        ),
        ('shots({ cue: [2, 0] })', 'balls.cue[0] must be -1.3208 to 1.3208, got 2 (m)'),
        ('chance({ cue: [0, 0] }, { speed: 1 }, { ball: "8" })', 'target.ball must be cue, got 8'),
        (
            'chance({ cue: [0, 0] }, { speed: 1 }, { ball: "cue" }, table.scene.noise, 1.5)',
            'n must be 1 to Infinity',
        ),
        (
            'chance({ cue: [0, 0] }, { speed: 1 }, { ball: "cue", pocket: "x" })',
            'target.pocket must be',
        ),
        (
            'chance({ cue: [0, 0] }, { speed: 1 }, { ball: "cue" }, { a: 1 })',
            'noise.b must be 0 to',
        ),
    ],
)
def test_what_makes_no_sense_is_refused(call, said):
    script = f'try {{ await table.{call}; }} catch (error) {{ return String(error); }}'
    assert in_node(export_scene(BLOCKED), script=script).startswith(f'RangeError: {said}')


@needs_node
def test_scenes_without_pockets_and_of_other_versions_are_refused():
    script = 'try { table.shots({ cue: [0, 0] }); } catch (error) { return String(error); }'
    assert in_node(export_scene('paper'), script=script) == (
        'RangeError: scene must have a table with pockets'
    )
    script = """
    const other = { ...table.scene, sources: 'x' };
    try { new core.Table(other); } catch (error) { return String(error); }"""
    said = 'RangeError: the version that exported the scene must be '
    assert in_node(export_scene('paper'), script=script).startswith(said)


@pytest.mark.parametrize('name', ['paper', 'snooker', 'eight_ball'])
def test_a_scene_for_a_page_is_small(name):
    text = json.dumps(export_scene(name), separators=(',', ':'), allow_nan=False)
    assert len(gzip.compress(text.encode(), mtime=0)) <= 10_000


@needs_browser
def test_a_page_that_is_a_file_plays_shots_and_estimates_chances(tmp_path):
    """The module, WebAssembly and the scene are in the page; its workers run the module, too."""
    folder = core_folder(PAGES)
    wasm = base64.b64encode((folder / 'wasm32.wasm').read_bytes()).decode()
    page = tmp_path / 'page.html'
    page.write_text(f"""<!doctype html><meta charset="utf-8">
<script type="text/plain" id="module">{(MODULE / 'core.mjs').read_text()}</script>
<script type="module">
const text = document.getElementById('module').textContent;
const module = new Blob([text], {{ type: 'text/javascript' }});
const {{ load }} = await import(URL.createObjectURL(module));
const wasm = Uint8Array.from(atob('{wasm}'), (each) => each.charCodeAt(0));
const description = {(folder / 'description.json').read_text()};
const core = await load({{ wasm, description, workers: 2 }});
globalThis.table = new core.Table({json.dumps(export_scene(BLOCKED))});
</script>""")
    browser = Browser(tmp_path / 'profile')
    try:
        browser.open(page)
        browser.wait_for('Boolean(globalThis.table)')
        end = browser.run(
            f'table.shoot(table.scene.places, {json.dumps(STROKE)}).balls.cue.position'
        )
        check_chance(json.loads(browser.run(f'(async () => {{ {CHANCE} }})()')))
        assert browser.messages == []
    finally:
        browser.close()
    shot = predict(BLOCKED, Stroke.from_offsets(**STROKE))
    assert end == shot.run.final_position['cue'].tolist()

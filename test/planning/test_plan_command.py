"""`billiard-shot plan`, as people call it."""

import json
import re

import pytest

from billiard_shot import load_shot, plan, Scene
from billiard_shot.cli import main

FAST = ['--budget', '5000']


def test_ranking(capsys):
    assert main(['plan', 'frozen_combination', '--pot', '8', *FAST]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith('OK: ')
    head = next(i for i, line in enumerate(lines) if line.split()[:2] == ['success', '95'])
    assert '95 % CI' in ' '.join(lines[:head])
    assert lines[head].endswith('kind')
    assert lines[head + 2].startswith('1  ')
    assert lines[head + 2].endswith('  combination')
    assert any(line.startswith('1, played exactly: 8 into foot left') for line in lines)
    assert 'strokes simulated in' in lines[-1]
    assert max(map(len, lines)) <= 80


def test_files_of_any_rank(tmp_path, capsys):
    shot, page = tmp_path / 'shot.json', tmp_path / 'shot.html'
    command = ['plan', 'frozen_combination', '--pot', '8', *FAST, '--json']
    assert main([*command, '--rank', '2', '-o', str(shot), '--view', str(page)]) == 0
    ranking = json.loads(capsys.readouterr().out)['ranking']
    assert load_shot(shot).stroke.velocity == pytest.approx(ranking[1]['velocity'])
    assert f'"velocity": {json.dumps(ranking[1]["velocity"])}' in page.read_text()
    assert main([*command, '--rank', '99', '-o', str(shot)]) == 2
    assert re.search(
        r'--rank must be at most \d+, the strokes found, got 99', capsys.readouterr().err
    )


def test_json_says_what_plan_says(capsys):
    assert (
        main(
            [
                'plan',
                'blocked',
                '--hit',
                '8',
                '--seed',
                '3',
                '--json',
                *FAST,
                '--noise',
                'tournament',
                '--noise-scale',
                '0.5',
            ]
        )
        == 0
    )
    said = json.loads(capsys.readouterr().out)
    scene = Scene.load('blocked')
    alone = plan(scene, {'hit': '8'}, scene.noise.times(0.5), int(FAST[1]), 3)
    assert said['status'] == 'OK'
    assert said['simulations'] == alone.simulations
    assert [each['success'] for each in said['ranking']] == [
        each.success for each in alone.ranking
    ]
    best = said['ranking'][0]
    assert (
        best['a'],
        best['b'],
        best['elevation'],
        best['azimuth'],
        best['speed'],
    ) == pytest.approx(alone.best.stroke.offsets)
    assert said['noise']['azimuth_deg'] == pytest.approx(0.0625)


@pytest.mark.parametrize(
    'target',
    [
        ['--rest', '0.3', '0.2', '--radius', '0.2'],
        ['--pass', '0.3', '0.2'],
        ['--gate', '0', '-0.1', '0', '0.1'],
    ],
)
def test_pictures(target, tmp_path, capsys):
    picture = tmp_path / 'plan.png'
    assert main(['plan', 'pool_table', *target, *FAST, '--picture', str(picture)]) == 0
    assert picture.read_bytes()[:4] == b'\x89PNG'
    assert capsys.readouterr().err == ''


@pytest.mark.parametrize(
    ('words', 'code', 'said'),
    [
        (['pool_table'], 2, 'target is missing; give one of --rest, --pass, --gate, --hit, --pot'),
        (['pool_table', '--pot', '8'], 2, 'pot needs a ball; the scene has only the cue ball'),
        (
            ['blocked', '--pot', '8', '--budget', '0'],
            2,
            'budget must be a whole number, at least 1, got 0',
        ),
        (
            ['blocked', '--pot', '8', '--view', 'no/a.html'],
            2,
            '--view must be in a folder that exists, got no/a.html',
        ),
        (
            ['blocked', '--pot', '8', '--speed-max', '-1'],
            2,
            'speed_max must be a finite number above 0, got -1',
        ),
        (
            ['blocked', '--pot', '8', '--noise-scale', '-1'],
            2,
            '--noise-scale must be a finite number at least 0, got -1',
        ),
        (
            ['blocked', '--pot', '8', '--azimuth-half-range-deg', '-1'],
            2,
            'azimuth_half_range_deg must be ',
        ),
        (
            ['blocked', '--hit', '8', '--direction-tolerance-deg', '-1'],
            2,
            'direction_tolerance_deg must be ',
        ),
        (['blocked', '--pot', '8', '--pass', '0.1', '0.1'], 2, 'one of the keys'),
        (
            [
                'blocked',
                '--hit',
                '8',
                '--azimuth-deg',
                '180',
                '--azimuth-half-range-deg',
                '1',
                '--budget',
                '200',
                '--speed-max',
                '0.2',
            ],
            1,
            'NO_PLAN: no stroke reaches the target',
        ),
    ],
)
def test_what_cannot_be_is_said(words, code, said, capsys):
    assert main(['plan', *words]) == code
    assert said in capsys.readouterr().err

"""
Sizes and times of the core in a page: until it starts, and for a shot in Node.

    python benchmarks/page.py
"""

import gzip
import json
from pathlib import Path
import shutil
import subprocess
from time import perf_counter

import numpy as np
from tools.timing import QUICK, Report

from billiard_shot import Scene
from billiard_shot.compiler.build import PAGES
from billiard_shot.embed.scenes import core_folder, export_scene, packed_scene
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.table.run.task import play_tables

NODE = shutil.which('node')
SIZE = 100.0  # kB of WebAssembly, compressed
SCENE = 10.0  # kB, compressed
START = 30.0  # ms until a table can be played on
SLOWER = 2.0  # times the library
ROUNDS = 20 if QUICK else 100  # the best of each stroke counts: others use the machine, too
STROKES = 50

PROGRAM = """
import { readFileSync } from 'node:fs';
const { module, folder, scene, strokes, rounds } = JSON.parse(readFileSync(0, 'utf-8'));
const { load } = await import(module);
const wasm = readFileSync(`${folder}/wasm32.wasm`);
const description = JSON.parse(readFileSync(`${folder}/description.json`, 'utf-8'));
let [table, start] = [null, Infinity];
for (let round = 0; round < 5; round++) {
  const begin = performance.now();
  table = new (await load({ wasm, description })).Table(scene);
  start = Math.min(start, performance.now() - begin);
}
const best = strokes.map(() => Infinity);
for (let round = 0; round < rounds; round++) {
  strokes.forEach((stroke, i) => {
    const begin = performance.now();
    table.shoot(scene.places, stroke);
    best[i] = Math.min(best[i], performance.now() - begin);
  });
}
console.log(JSON.stringify([start, best]));
"""


def in_library(scene, strokes):
    """Return the best times of strokes [ms], each one call of the entry."""
    (arguments,) = (each for entry, each in packed_scene(scene).items() if entry is play_tables)
    run, best = play_tables.current(), np.full(len(strokes), np.inf)
    given, tables = arguments['strokes'], arguments['tables']
    for _ in range(ROUNDS):
        for i, (normal, velocity) in enumerate(zip(*vectors_of(strokes), strict=True)):
            given.normals[0], given.velocities[0] = normal, velocity
            begin = perf_counter()
            for written in (tables.cues, tables.balls, tables.ends):
                written.view(np.uint8).fill(0)
            run(*arguments.values())
            best[i] = min(best[i], perf_counter() - begin)
    return 1e3 * best


def main():
    """Measure everything."""
    report = Report('The core in a page')
    if NODE is None:
        report.note('Node is not installed: nothing was measured')
        report.end()
    folder, draw = core_folder(PAGES), np.random.default_rng(1)
    wasm = (folder / 'wasm32.wasm').read_bytes()
    report.row('WebAssembly', len(wasm) / 1e3, 'kB')
    report.row('    compressed', len(gzip.compress(wasm)) / 1e3, 'kB', SIZE)
    low, high = (-0.4, -0.4, 0.02, -0.3, 0.5), (0.4, 0.4, 0.6, 0.3, 6.0)
    strokes = draw.uniform(low, high, (STROKES, 5))
    for balls, name in ((1, 'pool_table'), (2, 'two'), (10, 'nine_ball')):
        two = {'like': 'pool_table', 'balls': {'cue': [-0.5, 0.0], '1': [0.4, 0.0]}}
        scene = Scene.from_dict(two) if name == 'two' else Scene.load(name)
        exported = export_scene(scene)
        given = {
            'module': str(Path(__file__).parents[1] / 'billiard_shot/embed/web/core.mjs'),
            'folder': str(folder),
            'scene': exported,
            'strokes': [
                dict(zip(exported['noise'], each, strict=True)) for each in strokes.tolist()
            ],
            'rounds': ROUNDS,
        }
        done = subprocess.run(
            [NODE, '--input-type=module', '-e', PROGRAM],
            input=json.dumps(given), text=True, capture_output=True, check=True,
        )  # fmt: skip
        start, best = json.loads(done.stdout)
        library = in_library(scene, strokes)
        text = json.dumps(exported, separators=(',', ':')).encode()
        report.row(f'a scene of {balls}, compressed', len(gzip.compress(text)) / 1e3, 'kB', SCENE)
        report.row('    from its files to a table', start, 'ms', START)
        report.row('    a shot in Node', float(np.mean(best)), 'ms')
        report.row('    a shot in the library', float(library.mean()), 'ms')
        limit = SLOWER if balls == 2 else None
        report.row('    ratio', float(np.mean(best) / library.mean()), 'x', limit)
    report.end()


if __name__ == '__main__':
    main()

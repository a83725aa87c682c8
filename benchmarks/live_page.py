"""
The page to play on, in a browser without a window that draws in software: times, and the file.

    python benchmarks/live_page.py
"""

import gzip
from pathlib import Path
import sys
import tempfile

from tools.timing import QUICK, Report

sys.path.append(str(Path(__file__).parents[1] / 'test'))
from browser import Browser, find_browser, opened

from billiard_shot import Scene
from billiard_shot.pictures.view import page_of_scene

SIZE, COMPRESSED = 600.0, 250.0  # kB
FIRST_PICTURE = 1000.0  # ms from the begin of loading until the table with the path is drawn
PATH, SLOW_PATH = 16.0, 33.0  # ms from a drag to the new path: median, 95 %
RATE = 30.0  # pictures a second while something is dragged
CHANCE = {2: 300.0, 16: 600.0}  # ms, by the number of balls
STEPS = 30 if QUICK else 100  # of a drag
PLACES = {  # of balls (x, y) [m], by the number of balls
    2: {'cue': [-0.5, 0.0], '1': [0.4, 0.1]},
    16: {'cue': [-1.0, 0.0]}
    | {str(5 * k + j + 1): [-0.5 + 0.34 * j, -0.4 + 0.4 * k] for k in range(3) for j in range(5)},
}

# Since the page was asked for, until a picture is drawn that was begun after all else. A browser
# that draws in software may draw a picture some time after it was asked for.
SHOWN = """(async () => {
  const picture = () => new Promise((done) => requestAnimationFrame(done));
  const gl = document.getElementById('canvas').getContext('webgl2');
  const drawn = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  while (gl.getSyncParameter(drawn, gl.SYNC_STATUS) !== gl.SIGNALED) {
    await new Promise((done) => setTimeout(done, 1));
  }
  await picture();
  return performance.now();
})()"""
DRAG = """(async () => {
  const [paths, pictures] = [[], []];
  let last = performance.now();
  for (let i = 0; i < STEPS; i++) {
    const begin = performance.now();
    view.aim({ azimuth: view.state.stroke.azimuth + 5e-4 }, 'azimuth');
    paths.push(performance.now() - begin);
    await new Promise((done) => requestAnimationFrame(done));
    pictures.push(performance.now() - last);
    last = performance.now();
  }
  const sorted = (values) => values.sort((a, b) => a - b);
  const quantile = (values, part) => sorted(values)[Math.floor(part * values.length)];
  return [quantile(paths, 0.5), quantile(paths, 0.95), 1000 / quantile(pictures, 0.5)];
})()"""
ESTIMATE = """(async () => {
  const strokes = view.tableFor(view.state).drawn(view.state.stroke, view.state.noise, 2000, 1);
  const begin = performance.now();
  await view.tableFor(view.state).sample(view.state.balls, strokes.slice(0, 200));
  const first = performance.now() - begin;
  await view.tableFor(view.state).sample(view.state.balls, strokes);
  return [first, performance.now() - begin - first];
})()"""


def main():
    """Measure everything."""
    report = Report('The page to play on')
    if find_browser() is None:
        report.note('Chromium is not installed: nothing was measured')
        report.end()
    for balls, places in PLACES.items():
        text = page_of_scene(Scene.from_dict({'like': 'pool_table', 'balls': places}))
        report.row(f'the file, {balls} balls', len(text.encode()) / 1e3, 'kB', SIZE)
        report.row('    compressed', len(gzip.compress(text.encode())) / 1e3, 'kB', COMPRESSED)
        with tempfile.TemporaryDirectory() as folder:
            browser = Browser(Path(folder) / 'profile', 1280, 800)
            opened(browser, Path(folder) / 'page.html', text)
            shown = browser.run(SHOWN)
            report.row('    first picture', shown, 'ms', FIRST_PICTURE)
            path, slow, rate = browser.run(DRAG.replace('STEPS', str(STEPS)))
            report.row('    from a drag to the path', path, 'ms', PATH)
            report.row('    in 95 % of all steps', slow, 'ms', SLOW_PATH)
            report.row('    pictures a second', rate, '', -RATE)
            browser.run(ESTIMATE)  # the workers start
            first, chance = browser.run(ESTIMATE)
            report.row('    200 strokes with errors', first, 'ms')
            report.row('    2,000 strokes with errors', chance, 'ms', CHANCE[balls])
            browser.close()
    report.end()


if __name__ == '__main__':
    main()

// Answers test_page.py in Node: reads JSON from standard input, writes JSON to standard output.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { load } from '../../billiard_shot/embed/web/core.mjs';

const { folder, scene, strokes, script } = JSON.parse(readFileSync(0, 'utf-8'));
const wasm = readFileSync(`${folder}/wasm32.wasm`);
const description = JSON.parse(readFileSync(`${folder}/description.json`, 'utf-8'));
const core = await load({ wasm, description });
const table = new core.Table(scene);

/** Play a stroke, also one that `shoot` would refuse; return a digest of all that is written. */
function digest([balls, offsets]) {
  const [a, b, elevation, azimuth, speed] = offsets.map(Number);
  const { counts } = table.play(balls, { a, b, elevation, azimuth, speed });
  const { play_tables: call } = table.calls;
  const hash = createHash('sha256');
  ['balls', 'ends', 'cues'].forEach((each) => hash.update(call.rows(`tables.${each}`).bytes));
  ['tables.segments', 'tables.events', 'room.participants'].forEach((path, k) => {
    hash.update(call.rows(path).copy(counts[k]).bytes);
  });
  return hash.digest('hex');
}

const run = new Function('core', 'table', `return (async () => { ${script} })()`);
console.log(JSON.stringify(strokes ? strokes.map(digest) : await run(core, table)));

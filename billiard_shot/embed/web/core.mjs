/**
 * The compiled core of billiard_shot in a browser, or in Node: no Python, no server, no import.
 *
 *     const core = await load();
 *     const table = new core.Table(scene); // of `billiard-shot export SCENE -o scene.json`
 *     const shot = table.shoot({ cue: [-0.5, 0], 1: [0.4, 0.1] }, { azimuth: 0.1, speed: 2 });
 *     shot.status; shot.balls[1].pocket; shot.at(0.5).cue.position;
 *
 * Lengths are in m, times in s, angles in rad, `a` and `b` in ball radii; the frame is `table`.
 * Equal arguments give the results that Python has, to the last bit. Two things stay in Python:
 * words that explain a status, of which a caller sees the name, such as `CUE_THROUGH_BALL`; and how
 * far results of law `energetic` jump, which `error` and `status` do not tell here.
 *
 * @typedef {Record<string, number[]>} Balls where balls lie (x, y), by names; the others are absent
 * @typedef {Record<string, number>} Stroke as of `Stroke.from_offsets`; what is not given is 0
 * @typedef {Record<string, number>} Noise standard deviations of normal errors of a stroke
 * @typedef {{ball: string, pocket?: string}} Target a ball that is to fall; the cue ball must not
 */

const WORD = 8; // bytes of a number, and of a word of a table of arguments
const PAGE = 65536; // bytes by which a memory of WebAssembly grows
const RECORD = ['tables.segments', 'tables.events', 'room.participants'];
const OFFSETS = ['a', 'b', 'elevation', 'azimuth', 'speed'];
const Z95 = 1.959963984540054; // quantile of a two-sided 95 % interval
const WORKER = 'billiard_shot'; // name of the workers that run this file
const CORES = globalThis.Worker ? navigator.hardwareConcurrency : 0;

const READ = {
  f8: (view, at) => view.getFloat64(at, true),
  i8: (view, at) => Number(view.getBigInt64(at, true)),
  b1: (view, at) => view.getUint8(at) !== 0,
};
const WRITE = {
  f8: (view, at, value) => view.setFloat64(at, Number(value), true),
  i8: (view, at, value) => view.setBigInt64(at, BigInt(value), true),
  b1: (view, at, value) => view.setUint8(at, Number(value)),
};
const numbers = (kind) => ({ size: WORD, fields: [{ name: '', kind, shape: [], offset: 0 }] });
const product = (shape) => shape.reduce((a, b) => a * b, 1);
const nameOf = (names, number) => Object.keys(names).find((name) => names[name] === number);

/** Records, or numbers, one after the other in memory. */
class Rows {
  constructor(buffer, start, length, layout) {
    Object.assign(this, { length, layout });
    this.bytes = new Uint8Array(buffer, start, length * layout.size);
    this.view = new DataView(buffer, start, length * layout.size);
  }

  /** Return a row: a number, or a record as an object. */
  get(row) {
    const values = {};
    for (const { name, kind, shape, offset } of this.layout.fields) {
      const at = row * this.layout.size + offset;
      const read = (k) => READ[kind](this.view, at + WORD * k);
      values[name] = shape.length ? Array.from({ length: shape[0] }, (_, k) => read(k)) : read(0);
    }
    return '' in values ? values[''] : values;
  }

  all() {
    return Array.from({ length: this.length }, (_, row) => this.get(row));
  }

  /** Write a number, or some fields of a record. */
  set(row, values) {
    for (const { name, kind, offset } of this.layout.fields) {
      const at = row * this.layout.size + offset;
      const given = name ? (values[name] ?? []) : values;
      [given].flat().forEach((value, k) => WRITE[kind](this.view, at + WORD * k, value));
    }
  }

  fill(rows) {
    rows.forEach((row, i) => this.set(i, row));
  }

  /** Return the first rows, in memory of their own. */
  copy(length) {
    return new Rows(this.bytes.slice(0, length * this.layout.size).buffer, 0, length, this.layout);
  }
}

/** An instance of the core, and its memory: taken once, never given back. */
class Heap {
  constructor({ module, description }) {
    const { exports } = new WebAssembly.Instance(module);
    Object.assign(this, { description, exports, memory: exports.memory });
    this.end = exports.__heap_base.value;
  }

  /** Take so many bytes, all zero. */
  take(size) {
    this.end = Math.ceil(this.end / WORD) * WORD + size;
    const missing = this.end - this.memory.buffer.byteLength;
    if (missing > 0) this.memory.grow(Math.ceil(missing / PAGE));
    return this.end - size;
  }
}

/** An entry of the core, and its table of arguments, as the description of the core has it. */
class Call {
  constructor(heap, name, values) {
    // `places`: slot, shape, start and layout of each array, by its path, such as `tables.balls`
    Object.assign(this, { heap, name, places: {} });
    const entry = heap.description.entries[name];
    this.table = heap.take(WORD * entry.words);
    this.write(entry.arguments, values, '');
  }

  /** Call the entry, and return what it returns. */
  run() {
    return Number(this.heap.exports[this.name](this.table));
  }

  rows(path) {
    const { start, shape, layout } = this.places[path];
    return new Rows(this.heap.memory.buffer, start, product(shape), layout);
  }

  /** Write arguments, as Python exports them; `before`: of their paths. */
  write(given, values, before) {
    for (const { name, kind, slot, fields, of } of given) {
      const path = before + name;
      const value = values[name];
      if (kind === 'tuple') {
        this.write(fields, value, `${path}.`);
      } else if (kind === 'array') {
        const layout = this.heap.description.records[of] ?? numbers(of);
        this.place(path, { slot, shape: value.shape, layout });
        this.rows(path).fill(value.values ?? []);
      } else {
        this.words(slot, kind, [value]);
      }
    }
  }

  /** Write words of the table from a slot on. */
  words(slot, kind, values) {
    const { buffer } = this.heap.memory;
    new Rows(buffer, this.table + WORD * slot, values.length, numbers(kind)).fill(values);
  }

  /** Take memory for an array, all zero. */
  place(path, array) {
    const start = this.heap.take(product(array.shape) * array.layout.size);
    this.words(array.slot, 'i8', [start, ...array.shape]);
    this.places[path] = { ...array, start };
  }
}

/** A shot that was played. */
class Shot {
  constructor({ scene, constants }, end, outcomes, record) {
    Object.assign(this, { scene, constants, record });
    this.status = nameOf(constants.Status, end.status);
    this.error = end.error; // m, estimate for the trajectory of the cue ball
    this.duration = end.duration; // s, until all balls rest
    this.balls = {}; // how each ball ends
    outcomes.forEach((ball, i) => {
      const motion = nameOf(constants.Motion, ball.motion);
      const named = { ...ball, motion, pocket: scene.pockets[ball.pocket] };
      if (motion !== 'ABSENT') this.balls[scene.names[i]] = named;
    });
  }

  /** Segments of each ball in the order of time. */
  get segments() {
    const { Motion, Cause } = this.constants;
    const found = Object.fromEntries(Object.keys(this.balls).map((name) => [name, []]));
    for (const row of this.record[0].all()) {
      Object.assign(row, { motion: nameOf(Motion, row.motion), cause: nameOf(Cause, row.cause) });
      found[this.scene.names[row.ball]]?.push(row);
    }
    return Object.defineProperty(this, 'segments', { value: found }).segments; // read once
  }

  /** Events in the order of time, with the balls that take part. */
  get events() {
    const { names, pockets } = this.scene;
    const members = this.record[2].all(); // number of an event and a ball in turn
    return this.record[1].all().map((event, number) => {
      const cause = nameOf(this.constants.Cause, event.cause);
      const pair = cause === 'BALL' ? [event.ball, event.other] : [event.ball];
      const group = members.filter((_, k) => k % 2 && members[k - 1] === number);
      const balls = ['CLUSTER', 'CUE'].includes(cause) ? group : pair;
      const pocket = cause === 'POCKET' ? pockets[event.other] : undefined;
      return { ...event, cause, balls: balls.map((ball) => names[ball]), pocket };
    });
  }

  /** State of each ball at a time [s]: `position`, `velocity`, `spin` and `motion`. */
  at(time) {
    const states = Object.entries(this.segments).map(([name, rows]) => {
      const row = rows.findLast((each) => each.time <= time) ?? rows[0];
      const dt = Math.max(time - row.time, 0);
      const { velocity: v, acceleration: a, motion } = row;
      const position = row.position.map((x, k) => x + (v[k] + 0.5 * a[k] * dt) * dt);
      const velocity = v.map((x, k) => x + a[k] * dt);
      const spin = row.spin.map((x, k) => x + row.spin_acceleration[k] * dt);
      return [name, { position, velocity, spin, motion }];
    });
    return Object.fromEntries(states);
  }
}

/** A scene on which strokes are played; see `load`. */
class Table {
  constructor(core, scene) {
    oneOf('the version that exported the scene', scene.sources, [core.description.sources]);
    Object.assign(this, { core, scene, constants: core.description.constants });
    const heap = new Heap(core);
    const call = ([name, values]) => [name, new Call(heap, name, values)];
    this.calls = Object.fromEntries(Object.entries(scene.entries).map(call));
    this.workers = [];
  }

  /** Play a stroke at the cue ball. @param {Balls} balls @param {Stroke} stroke */
  shoot(balls, stroke) {
    this.check(balls, stroke);
    const outcome = this.play(balls, stroke);
    const { play_tables: call } = this.calls;
    const record = RECORD.map((path, k) => call.rows(path).copy(outcome.counts[k]));
    return new Shot(this, outcome.end, call.rows('tables.balls').all(), record);
  }

  /** Find direct shots, also for some balls only. @param {Balls} balls @param {string[]} legal */
  shots(balls, legal = this.scene.names.slice(1)) {
    const { names, pockets } = this.scene;
    if (!pockets.length) throw new RangeError('scene must have a table with pockets');
    this.check(balls);
    const { NO_BALL, PRESENT, LEGAL } = this.constants.BallKind;
    const find = this.calls.find_direct_shots;
    find.rows('places').fill(names.flatMap((name) => balls[name] ?? [0, 0]));
    const kind = (name) => (legal.includes(name) ? LEGAL : PRESENT);
    find.rows('kinds').fill(names.map((name) => (balls[name] ? kind(name) : NO_BALL)));
    const found = find.rows('shots').copy(find.run()).all();
    return found.map(({ table, elevation, azimuth, speed, ...shot }) => ({
      ...shot,
      ball: names[shot.ball],
      pocket: pockets[shot.pocket],
      stroke: { elevation, azimuth, speed },
    }));
  }

  /**
   * Estimate the chance of a target, with its 95 % interval, by n strokes with errors of a seed.
   * @param {Balls} balls @param {Stroke} stroke @param {Target} target @param {Noise} noise
   */
  async chance(balls, stroke, target, noise = this.scene.noise, n = 1000, seed = 1) {
    const { ranges, pockets } = this.scene;
    this.check(balls, stroke);
    within('n', Number.isInteger(n) ? n : NaN, [1, Infinity, 'a whole number of strokes']);
    OFFSETS.forEach((name) => within(`noise.${name}`, noise[name], ranges[name].with(0, 0)));
    oneOf('target.ball', target.ball, Object.keys(balls));
    oneOf('target.pocket', target.pocket, [undefined, ...pockets]);
    const given = [balls, this.drawn(stroke, noise, n, seed), target];
    const chance = (await (this.core.workers ? this.shared(...given) : this.count(...given))) / n;
    // E. B. Wilson, J. Am. Stat. Assoc. 22, 1927
    const square = Z95 ** 2 / n;
    const middle = (chance + square / 2) / (1 + square);
    const half = (Z95 / (1 + square)) * Math.sqrt((chance * (1 - chance) + square / 4) / n);
    return { chance, interval: [Math.max(middle - half, 0), Math.min(middle + half, 1)] };
  }

  /** Draw n strokes as a player with errors executes them; elevations may exceed the vertical. */
  drawn(stroke, noise, n, seed) {
    const random = generator(seed);
    const normal = () => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());
    return Array.from({ length: n }, () => {
      const drawn = (name) => [name, (stroke[name] ?? 0) + noise[name] * normal()];
      const played = Object.fromEntries(OFFSETS.map(drawn));
      return { ...played, speed: Math.max(played.speed, this.scene.slowest) };
    });
  }

  /** Count strokes that reach a target. */
  count(balls, strokes, target) {
    const { POCKETED, OFF_TABLE } = this.constants.Motion;
    const ball = this.scene.names.indexOf(target.ball);
    const pocket = this.scene.pockets.indexOf(target.pocket); // -1: any
    return strokes.filter((stroke) => {
      this.play(balls, stroke);
      const [cue, end] = [0, ball].map((i) => this.calls.play_tables.rows('tables.balls').get(i));
      const falls = end.motion === POCKETED && [-1, end.pocket].includes(pocket);
      return falls && ![POCKETED, OFF_TABLE].includes(cue.motion);
    }).length;
  }

  /** Let workers count strokes that reach a target. */
  async shared(balls, strokes, target) {
    const { workers } = this.core;
    const text = await (await fetch(import.meta.url)).text();
    while (this.workers.length < workers) {
      // of the text: a page that is a file, or on another host, may not load it by its name
      const source = `data:text/javascript,${encodeURIComponent(text)}`;
      const worker = new Worker(source, { type: 'module', name: WORKER });
      worker.postMessage({ core: this.core, scene: this.scene });
      this.workers.push(worker);
    }
    const counts = this.workers.map((worker, i) => {
      const { port1, port2: port } = new MessageChannel();
      const part = strokes.filter((_, k) => k % workers === i);
      worker.postMessage({ given: [balls, part, target], port }, [port]);
      return new Promise((resolve, reject) => {
        port1.onmessage = ({ data }) => resolve(data);
        worker.onerror = ({ message }) => reject(new Error(`a worker failed: ${message}`));
      });
    });
    return (await Promise.all(counts)).reduce((a, b) => a + b, 0);
  }

  /** End the workers of `chance`. */
  close() {
    this.workers.splice(0).forEach((worker) => worker.terminate());
  }

  /** Throw a RangeError for what makes no sense. */
  check(balls, stroke = { speed: 1 }) {
    const { names, ranges, apart } = this.scene;
    Object.keys(stroke).forEach((name) => oneOf('stroke', name, OFFSETS));
    OFFSETS.forEach((name) => within(`stroke.${name}`, stroke[name] ?? 0, ranges[name]));
    Object.entries({ [names[0]]: [], ...balls }).forEach(([name, [x, y, ...more]], i, all) => {
      oneOf('balls', name, names);
      [x, y].forEach((each, k) => within(`balls.${name}[${k}]`, each, ranges['xy'[k]]));
      oneOf(`the length of balls.${name}`, 2 + more.length, [2]);
      for (const [other, [u, v]] of all.slice(0, i)) {
        within(`distance of ${other} and ${name}`, Math.hypot(x - u, y - v), apart);
      }
    });
  }

  /** Play a stroke, without checks; return how it ended, and how many rows its record has. */
  play(balls, stroke) {
    const { play_tables: call, write_strokes: vectors } = this.calls;
    const place = (name) => (balls[name] ? [...balls[name], this.scene.radius] : [0, 0, 0]);
    const start = (name) => ({ position: place(name), absent: !balls[name] });
    call.rows('tables.starts').fill(this.scene.names.map(start));
    vectors.rows('offsets').fill(OFFSETS.map((name) => stroke[name] ?? 0));
    vectors.run();
    call.rows('strokes.normals').bytes.set(vectors.rows('normals').bytes);
    call.rows('strokes.velocities').bytes.set(vectors.rows('velocities').bytes);
    for (;;) {
      ['cues', 'balls', 'ends'].forEach((each) => call.rows(`tables.${each}`).bytes.fill(0));
      call.run();
      const progress = call.rows('simulation.progress').get(0);
      const counts = [progress.segments, progress.events, 2 * progress.participants];
      const full = RECORD.filter((path, k) => counts[k] > call.rows(path).length);
      if (!full.length) return { end: call.rows('tables.ends').get(0), counts };
      for (const path of full) {
        const [rows, ...others] = call.places[path].shape;
        call.place(path, { ...call.places[path], shape: [2 * rows, ...others] });
      }
    }
  }
}

function oneOf(name, value, allowed) {
  if (allowed.includes(value)) return;
  throw new RangeError(`${name} must be ${allowed.join(' or ')}, got ${value}`);
}

function within(name, value, [low, high, unit]) {
  if (typeof value === 'number' && value >= low && value <= high) return;
  throw new RangeError(`${name} must be ${low} to ${high}, got ${value} (${unit})`);
}

/** Make a generator of numbers from 0 to 1: mulberry32 of T. Ettinger. */
function generator(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let mixed = Math.imul(seed ^ (seed >>> 15), seed | 1);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

/**
 * Load the core, from core.wasm and description.json beside this file unless they are given.
 * @param {{wasm?: BufferSource, description?: object, workers?: number}} options workers: of chances
 */
export async function load({ wasm, description, workers = CORES } = {}) {
  const module = await WebAssembly.compile(wasm ?? (await read('core.wasm')));
  description ??= JSON.parse(new TextDecoder().decode(await read('description.json')));
  return { Table: Table.bind(null, { module, description, workers }) };
}

async function read(name) {
  const url = new URL(name, import.meta.url);
  if (url.protocol === 'file:') return (await import('node:fs/promises')).readFile(url);
  return (await fetch(url)).arrayBuffer();
}

if (globalThis.name === WORKER) {
  let table;
  globalThis.onmessage = ({ data: { core, scene, given, port } }) => {
    table ??= new Table(core, scene);
    port?.postMessage(table.count(...given));
  };
}

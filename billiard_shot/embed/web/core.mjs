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
 * @typedef {Record<string, number>} Stroke as of `Stroke.from_offsets`; what is not given is 0.
 *     Or the vectors `normal` and `velocity` of a `Stroke`
 * @typedef {Record<string, number>} Noise standard deviations of normal errors of a stroke
 * @typedef {{ball?: string, pocket?: string}} Target a ball that is to fall, by default any, as in a
 *     break; the cue ball must not
 */

const WORD = 8; // bytes of a number, and of a word of a table of arguments
const PAGE = 65536; // bytes by which a memory of WebAssembly grows
const STROKES = ['strokes.normals', 'strokes.velocities'];
const RECORD = ['tables.segments', 'tables.events', 'room.participants'];
const OFFSETS = ['a', 'b', 'elevation', 'azimuth', 'speed'];
const VECTORS = ['normal', 'velocity'];
const FINITE = [-1e12, 1e12, '1 or m/s'];
const REFUSED = 100; // the first status of strokes that are refused
const END = 4; // numbers of the end of a ball in a sample
const BEGIN = ['ROLL', 'SPIN', 'REST']; // motions whose beginnings are events
const Z95 = 1.959963984540054; // quantile of a two-sided 95 % interval
const WORKER = 'billiard_shot'; // name of the workers that run this file
const CORES = globalThis.Worker ? navigator.hardwareConcurrency : 0;

const READ = { // word number `at`; the bytes of a browser are in the order of WebAssembly
  f8: ({ doubles }, at) => doubles[at],
  i8: ({ integers }, at) => Number(integers[at]),
  b1: ({ bytes }, at) => bytes[WORD * at] !== 0,
};
const WRITE = {
  f8: ({ doubles }, at, value) => { doubles[at] = value; },
  i8: ({ integers }, at, value) => { integers[at] = BigInt(value); },
  b1: ({ bytes }, at, value) => { bytes[WORD * at] = value; },
};
const numbers = (kind) => ({ size: WORD, fields: [{ name: '', kind, shape: [], offset: 0 }] });
const product = (shape) => shape.reduce((a, b) => a * b, 1);
const byNumber = (names) => Object.fromEntries(Object.entries(names).map((each) => each.reverse()));

/** Records, or numbers, one after the other in memory. */
class Rows {
  constructor(buffer, start, length, layout) {
    const size = length * layout.size;
    Object.assign(this, { length, layout, bytes: new Uint8Array(buffer, start, size) });
    this.doubles = new Float64Array(buffer, start, size / WORD);
    this.integers = new BigInt64Array(buffer, start, size / WORD);
  }

  /** Return a row: a number, or a record as an object. */
  get(row) {
    const values = {};
    for (const { name, kind, shape, offset } of this.layout.fields) {
      const at = (row * this.layout.size + offset) / WORD;
      const read = (k) => READ[kind](this, at + k);
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
      const at = (row * this.layout.size + offset) / WORD;
      const given = name ? (values[name] ?? []) : values;
      [given].flat().forEach((value, k) => WRITE[kind](this, at + k, value));
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

/** An instance of the core, and its memory, which is taken until all of it is given back. */
class Heap {
  constructor({ module, description }) {
    const { exports } = new WebAssembly.Instance(module);
    Object.assign(this, { description, exports, memory: exports.memory });
    this.end = exports.__heap_base.value;
  }

  /** Give all memory back. */
  clear() {
    const begin = this.exports.__heap_base.value;
    new Uint8Array(this.memory.buffer, begin, this.end - begin).fill(0);
    this.end = begin;
    return this;
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
    Object.assign(this, { heap, name, places: {}, slots: {} });
    const entry = heap.description.entries[name];
    this.table = heap.take(WORD * entry.words);
    this.write(entry.arguments, values, '');
  }

  /** Call the entry, and return what it returns. */
  run() {
    return Number(this.heap.exports[this.name](this.table));
  }

  rows(path) {
    const { buffer } = this.heap.memory; // another one if the memory has grown
    const place = this.places[path];
    if (place.rows?.bytes.buffer !== buffer) {
      place.rows = new Rows(buffer, place.start, product(place.shape), place.layout);
    }
    return place.rows;
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
        this.slots[path] = { slot, kind };
        this.put(path, value);
      }
    }
  }

  /** Write words of the table from a slot on. */
  words(slot, kind, values) {
    const { buffer } = this.heap.memory;
    new Rows(buffer, this.table + WORD * slot, values.length, numbers(kind)).fill(values);
  }

  /** Write an argument that is a number. */
  put(path, value) {
    const { slot, kind } = this.slots[path];
    this.words(slot, kind, [value]);
  }

  /** Take memory for an array, all zero. */
  place(path, array) {
    const start = this.heap.take(product(array.shape) * array.layout.size);
    this.words(array.slot, 'i8', [start, ...array.shape]);
    this.places[path] = { ...array, start, rows: null };
  }
}

const isGone = ({ motion }) => motion === 'POCKETED' || motion === 'OFF_TABLE';

/**
 * Whether balls end as a target wants it, the cue ball on the table, and the cue hit it once; `endOf`
 * tells by name how balls end.
 */
function isReached({ ball, pocket }, [cue, ...others], endOf, doubleHit) {
  const falls = (end) => end?.motion === 'POCKETED' && [undefined, end.pocket].includes(pocket);
  const wanted = ball === undefined ? others : [ball];
  return wanted.some((name) => falls(endOf(name))) && !isGone(endOf(cue)) && !doubleHit;
}

/** What happens between two motions of a ball. */
function kindsOf(before, after, cause) {
  if (cause !== 'OWN' && cause !== 'RELEASE') return [cause.toLowerCase()];
  if (after === before) return cause === 'RELEASE' ? [] : [after === 'FLIGHT' ? 'bounce' : 'spin_end'];
  return [...(before === 'FLIGHT' ? ['land'] : []), ...(BEGIN.includes(after) ? [after.toLowerCase()] : [])];
}

/** A shot that was played. */
class Shot {
  #record; // segments, events and who takes part in them

  constructor({ scene, meanings }, end, cue, outcomes, record) {
    Object.assign(this, { scene, meanings });
    this.#record = record;
    this.status = meanings.Status[end.status];
    this.refused = end.status >= REFUSED; // nothing was played
    this.error = end.error; // m, estimate for the trajectory of the cue ball
    this.duration = end.duration; // s, until all balls rest
    this.doubleHit = end.double_hit; // the cue hit the ball again, in the strike or later
    this.cue = cue; // after the strike: its speed, how often it hit the ball, a miscue
    const ends = outcomes.map((ball, i) => {
      const motion = meanings.Motion[ball.motion];
      return [scene.names[i], { ...ball, motion, pocket: scene.pockets[ball.pocket] }];
    });
    // how each ball ends
    this.balls = Object.fromEntries(ends.filter(([, { motion }]) => motion !== 'ABSENT'));
  }

  /** Whether the shot reaches a target. @param {Target} target */
  reaches(target) {
    return isReached(target, this.scene.names, (name) => this.balls[name], this.doubleHit);
  }

  /** Segments of each ball in the order of time. */
  get segments() {
    const { Motion, Cause } = this.meanings;
    const found = Object.fromEntries(Object.keys(this.balls).map((name) => [name, []]));
    for (const row of this.#record[0].all()) {
      Object.assign(row, { motion: Motion[row.motion], cause: Cause[row.cause] });
      found[this.scene.names[row.ball]]?.push(row);
    }
    return Object.defineProperty(this, 'segments', { value: found }).segments; // read once
  }

  /**
   * Events in the order of time, with the names that Python has: `kind`, `balls`, `place` (a pocket or
   * cushion, else empty), and the kinetic energies of these balls, `before` and `after` [J].
   */
  get events() {
    const { names, pockets, cushions } = this.scene;
    const { Motion, Cause } = this.meanings;
    const members = this.#record[2].all(); // number of an event and a ball in turn
    return this.#record[1].all().flatMap((event, number) => {
      const { time, ball, other, energy_before: before, energy_after: after } = event;
      const cause = Cause[event.cause];
      const group = members.filter((_, k) => k % 2 && members[k - 1] === number);
      const several = ['CLUSTER', 'CUE'].includes(cause);
      const balls = (several ? group : cause === 'BALL' ? [ball, other] : [ball]).map((i) => names[i]);
      const place = { POCKET: pockets[other], CUSHION: cushions[other] }[cause] ?? '';
      const kinds = kindsOf(Motion[event.motion_before], Motion[event.motion_after], cause);
      return kinds.map((kind, k) => ({ time, kind, balls, place, before: k ? after : before, after }));
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

/** How strokes end; see `Table.sample`. */
class Sample {
  constructor({ scene, meanings }, count, ends) {
    Object.assign(this, { scene, meanings, count, ends });
    this.width = END * scene.names.length + 1; // numbers of a stroke: of the balls, and a double hit
  }

  /** The strokes of this sample and of another one. @param {Sample} other */
  and(other) {
    const ends = new Float64Array(this.ends.length + other.ends.length);
    ends.set(this.ends);
    ends.set(other.ends, this.ends.length);
    return new Sample(this, this.count + other.count, ends);
  }

  /** How a ball ends in a stroke: `position` (x, y) [m], `motion` and `pocket`. */
  end(name, stroke) {
    const { names, pockets } = this.scene;
    const at = stroke * this.width + END * names.indexOf(name);
    const [x, y, motion, pocket] = this.ends.subarray(at, at + END);
    return { position: [x, y], motion: this.meanings.Motion[motion], pocket: pockets[pocket] };
  }

  /** How a ball ends in each stroke. */
  ball(name) {
    return Array.from({ length: this.count }, (_, stroke) => this.end(name, stroke));
  }

  /** Places (x, y) where a ball rests [m]. */
  rests(name) {
    return this.ball(name).filter((end) => !isGone(end)).map(({ position }) => position);
  }

  /** The share of strokes that reach a target, with its 95 % interval. @param {Target} target */
  chance(target) {
    let reached = 0;
    for (let stroke = 0; stroke < this.count; stroke++) {
      const doubleHit = this.ends[(stroke + 1) * this.width - 1];
      reached += isReached(target, this.scene.names, (name) => this.end(name, stroke), doubleHit);
    }
    const [n, chance] = [this.count, reached / this.count];
    // E. B. Wilson, J. Am. Stat. Assoc. 22, 1927
    const square = Z95 ** 2 / n;
    const middle = (chance + square / 2) / (1 + square);
    const half = (Z95 / (1 + square)) * Math.sqrt((chance * (1 - chance) + square / 4) / n);
    return { chance, interval: [Math.max(middle - half, 0), Math.min(middle + half, 1)] };
  }
}

/** A scene on which strokes are played; see `load`. It takes the memory of a `used` table over. */
class Table {
  constructor(core, scene, used) {
    oneOf('the version that exported the scene', scene.sources, [core.description.sources]);
    Object.assign(this, { core, scene, constants: core.description.constants });
    const meaning = ([kind, names]) => [kind, byNumber(names)];
    this.meanings = Object.fromEntries(Object.entries(this.constants).map(meaning));
    used?.close();
    this.heap = used ? used.heap.clear() : new Heap(core);
    const call = ([name, values]) => [name, new Call(this.heap, name, values)];
    this.calls = Object.fromEntries(Object.entries(scene.entries).map(call));
    this.workers = [];
  }

  /** Play a stroke at the cue ball. @param {Balls} balls @param {Stroke} stroke */
  shoot(balls, stroke) {
    this.check(balls, stroke);
    const outcome = this.play(balls, stroke);
    const { play_tables: call } = this.calls;
    const record = RECORD.map((path, k) => call.rows(path).copy(outcome.counts[k]));
    const [cue, outcomes] = ['cues', 'balls'].map((each) => call.rows(`tables.${each}`).all());
    return new Shot(this, outcome.end, cue[0], outcomes, record);
  }

  /** The status with which a stroke would be refused, or OK; nothing is played. */
  refusal(balls, stroke) {
    const { play_tables: call } = this.calls;
    call.put('window.until', -Infinity);
    try {
      return this.meanings.Status[this.play(balls, stroke).end.status];
    } finally {
      call.put('window.until', Infinity);
    }
  }

  /** Find direct shots, also for some balls only. @param {Balls} balls @param {string[]} legal */
  shots(balls, legal = this.scene.names.slice(1)) {
    const { names, pockets } = this.scene;
    if (!pockets.length) throw new RangeError('scene must have a table with pockets');
    this.check(balls);
    const { NO_BALL, PRESENT, LEGAL } = this.constants.BallKind;
    const find = this.calls.find_direct_shots;
    const there = (name) => Object.hasOwn(balls, name); // also if its name is `constructor`
    find.rows('places').fill(names.flatMap((name) => (there(name) ? balls[name] : [0, 0])));
    const kind = (name) => (legal.includes(name) ? LEGAL : PRESENT);
    find.rows('kinds').fill(names.map((name) => (there(name) ? kind(name) : NO_BALL)));
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
    const { pockets } = this.scene;
    this.check(balls, stroke);
    within('n', Number.isInteger(n) ? n : NaN, [1, Infinity, 'a whole number of strokes']);
    this.checkNoise(noise);
    if (target.ball !== undefined) oneOf('target.ball', target.ball, Object.keys(balls));
    oneOf('target.pocket', target.pocket, [undefined, ...pockets]);
    return (await this.sample(balls, this.drawn(stroke, noise, n, seed))).chance(target);
  }

  /** Play strokes, without checks; workers share them. */
  async sample(balls, strokes) {
    const { workers } = this.core;
    const ends = workers ? await this.shared(balls, strokes) : this.ends(balls, strokes);
    return new Sample(this, strokes.length, ends);
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

  /**
   * Play strokes: for each one and each ball the place (x, y), the motion and the pocket at its end;
   * after these whether the cue hit the ball again.
   */
  ends(balls, strokes) {
    this.lay(balls);
    const { play_tables: call } = this.calls;
    const found = new Float64Array(strokes.length * (this.scene.names.length * END + 1));
    let at = 0;
    for (const stroke of strokes) {
      const { end } = this.strike(stroke);
      const { layout, length, doubles, integers } = call.rows('tables.balls');
      const [place, motion, pocket] = ['position', 'motion', 'pocket'].map((name) =>
        layout.fields.find((field) => field.name === name).offset / WORD);
      for (let row = 0; row < length * layout.size / WORD; row += layout.size / WORD) {
        found[at++] = doubles[row + place];
        found[at++] = doubles[row + place + 1];
        found[at++] = Number(integers[row + motion]);
        found[at++] = Number(integers[row + pocket]);
      }
      found[at++] = end.double_hit;
    }
    return found;
  }

  /** Let workers play strokes, each a stretch of them. */
  async shared(balls, strokes) {
    const { workers } = this.core;
    const text = await (await fetch(import.meta.url)).text();
    while (this.workers.length < workers) {
      // of the text: a page that is a file, or on another host, may not load it by its name
      const source = `data:text/javascript,${encodeURIComponent(text)}`;
      const worker = new Worker(source, { type: 'module', name: WORKER });
      worker.postMessage({ core: this.core, scene: this.scene });
      this.workers.push(worker);
    }
    const size = Math.ceil(strokes.length / workers);
    const parts = this.workers.map((worker, i) => {
      const { port1, port2: port } = new MessageChannel();
      const part = strokes.slice(i * size, (i + 1) * size);
      worker.postMessage({ given: [balls, part], port }, [port]);
      return new Promise((resolve, reject) => {
        port1.onmessage = ({ data }) => resolve(data);
        worker.onerror = ({ message }) => reject(new Error(`a worker failed: ${message}`));
      });
    });
    const width = this.scene.names.length * END + 1;
    const found = new Float64Array(strokes.length * width);
    (await Promise.all(parts)).forEach((part, i) => found.set(part, i * size * width));
    return found;
  }

  /** End the workers of `chance`. */
  close() {
    this.workers.splice(0).forEach((worker) => worker.terminate());
  }

  /** Throw a RangeError for what makes no sense. */
  check(balls, stroke = { speed: 1 }) {
    const { names, ranges, apart } = this.scene;
    this.checkStroke(stroke);
    Object.entries({ [names[0]]: [], ...balls }).forEach(([name, [x, y, ...more]], i, all) => {
      oneOf('balls', name, names);
      [x, y].forEach((each, k) => within(`balls.${name}[${k}]`, each, ranges['xy'[k]]));
      oneOf(`the length of balls.${name}`, 2 + more.length, [2]);
      for (const [other, [u, v]] of all.slice(0, i)) {
        within(`distance of ${other} and ${name}`, Math.hypot(x - u, y - v), apart);
      }
    });
  }

  checkStroke(stroke) {
    if (stroke.normal && stroke.velocity) {
      for (const name of VECTORS) {
        oneOf(`the length of stroke.${name}`, stroke[name].length, [3]);
        stroke[name].forEach((x) => within(`stroke.${name}`, x, FINITE));
      }
      return;
    }
    Object.keys(stroke).forEach((name) => oneOf('stroke', name, OFFSETS));
    OFFSETS.forEach((name) => within(`stroke.${name}`, stroke[name] ?? 0, this.scene.ranges[name]));
  }

  checkNoise(noise) {
    const { ranges } = this.scene;
    OFFSETS.forEach((name) => within(`noise.${name}`, noise[name], ranges[name].with(0, 0)));
  }

  /** Play a stroke, without checks; return how it ended, and how many rows its record has. */
  play(balls, stroke) {
    this.lay(balls);
    return this.strike(stroke);
  }

  lay(balls) {
    const there = (name) => Object.hasOwn(balls, name);
    const place = (name) => (there(name) ? [...balls[name], this.scene.radius] : [0, 0, 0]);
    const { REST, ABSENT } = this.constants.Motion;
    const start = (name) => ({ position: place(name), motion: there(name) ? REST : ABSENT });
    this.calls.play_tables.rows('tables.starts').fill(this.scene.names.map(start));
  }

  strike(stroke) {
    const { play_tables: call, write_strokes: vectors } = this.calls;
    if (stroke.normal) {
      VECTORS.forEach((name, k) => call.rows(STROKES[k]).doubles.set(stroke[name]));
    } else {
      OFFSETS.forEach((name, k) => { vectors.rows('offsets').doubles[k] = stroke[name] ?? 0; });
      vectors.run();
      STROKES.forEach((path) => call.rows(path).bytes.set(vectors.rows(path.slice(8)).bytes));
    }
    for (;;) {
      ['cues', 'balls', 'ends'].forEach((each) => call.rows(`tables.${each}`).bytes.fill(0));
      call.run();
      const end = call.rows('tables.ends').get(0);
      const counts = [end.segments, end.events, 2 * end.participants];
      const full = RECORD.filter((path, k) => counts[k] > call.rows(path).length);
      if (!full.length) return { end, counts };
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
    port?.postMessage(given && table.ends(...given));
  };
}

// The state in the address of the page, and as text for files and for other programs.

const SHOT = ['balls', 'stroke', 'effects', 'parameters']; // all that a shot depends on
const LINKED = [...SHOT, 'level', 'noise', 'target', 'units', 'drill', 'kept'];
const LONGEST = 2000; // characters of a link's fragment
let initial = null; // the state that a page begins with

const fieldsOf = (given, names) => Object.fromEntries(names.map((name) => [name, given[name]]));

/** Fields of these names that differ from those of another. */
const changedFields = (given, other, names) => fieldsOf(given, names.filter(
  (name) => JSON.stringify(given[name]) !== JSON.stringify(other[name])));

/**
 * The fragment of an address that brings the state back: what differs from the beginning. Shots that
 * are kept are left out if they do not fit in.
 */
function linkOf(given) {
  const kept = given.kept.map((each) => changedFields(each, given, SHOT));
  const whole = packed({ ...given, kept });
  return whole.length <= LONGEST ? whole : packed({ ...given, kept: [] });
}

function packed(given) {
  const changed = changedFields(given, initial, LINKED);
  if (!Object.keys(changed).length) return '';
  const bytes = new TextEncoder().encode(JSON.stringify({ page: data.id, ...changed }));
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** What a fragment says, and whether it comes from another page; throws if it makes no sense. */
function readLink(fragment) {
  let given = null;
  try {
    const letters = atob(fragment.replaceAll('-', '+').replaceAll('_', '/'));
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    given = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
  } catch {
    throw new RangeError('a part of it is missing, or was changed');
  }
  return { changes: acceptable(given), isForeign: given.page !== data.id };
}

/** Fields of a state that came from elsewhere; throws if one makes no sense. */
function acceptable(given) {
  const must = (good, what) => {
    if (!good) throw new RangeError(`${what} makes no sense`);
  };
  const isObject = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
  must(isObject(given), 'its content');
  const taken = fieldsOf(given, LINKED.filter((name) => Object.hasOwn(given, name)));
  const next = { ...state, kept: [], ...taken };
  const finite = (value) => typeof value === 'number' && Number.isFinite(value);
  const table = tableFor({ effects: [], parameters: {} });
  const isEffect = (name) => Object.hasOwn(data.equipment.effects, name);
  const checkShot = (shot) => {
    for (const name of ['balls', 'stroke', 'parameters']) must(isObject(shot[name]), name);
    must(Object.values(shot.balls).every(Array.isArray), 'balls');
    table.check(shot.balls, shot.stroke);
    OFFSETS.forEach((name) => must(finite(shot.stroke[name]), `stroke.${name}`));
    must(Array.isArray(shot.effects) && shot.effects.every(isEffect), 'effects');
    for (const [name, value] of Object.entries(shot.parameters)) {
      const known = data.equipment.parameters.find((each) => each.name === name);
      must(known && finite(value) && value >= known.range[0] && value <= known.range[1], name);
    }
  };
  checkShot(next);
  must(Array.isArray(next.kept) && next.kept.length <= MOST_KEPT && next.kept.every(isObject), 'kept');
  const kept = next.kept.map((each) => fieldsOf({ ...next, ...each }, SHOT));
  kept.forEach(checkShot);
  must(isObject(next.noise), 'noise');
  table.checkNoise(next.noise);
  must(finite(next.level) && next.level >= 0 && next.level <= Math.PI / 2, 'level');
  if (next.target !== null) {
    const { ball } = isObject(next.target) ? next.target : { ball: null };
    must(ball === undefined || Object.hasOwn(next.balls, ball), 'target');
    must([undefined, ...data.scene.pockets].includes(next.target.pocket), 'target');
  }
  must(Object.hasOwn(UNITS, next.units), 'units');
  const { drill } = next;
  const isCounted = isObject(drill) && Number.isInteger(drill.tries) && Number.isInteger(drill.successes);
  must(drill === null || (isCounted && next.target), 'drill');
  return 'kept' in taken ? { ...taken, kept } : taken;
}

const writeLink = afterQuiet(400, () => {
  const link = linkOf(state);
  const address = link && link.length <= LONGEST ? `#${link}` : location.pathname + location.search;
  try {
    history.replaceState(null, '', address);
  } catch { /* a page without an address of its own, in a frame */ }
});

function followLink() {
  const fragment = location.hash.slice(1);
  if (!fragment || fragment === linkOf(state)) return;
  try {
    const { changes, isForeign } = readLink(fragment);
    const question = 'This link is of another table, or of another start. Apply it to this one?';
    if (!isForeign || window.confirm(question)) change(changes);
  } catch (error) {
    giveHint(`The link cannot be followed: ${error.message}.`);
  }
}

// ---- texts ----

const EXPORTS = { // what, file, text
  link: ['Link', '', () => `${data.site || location.href.split('#')[0]}#${linkOf(state)}`],
  scene: ['Scene', 'scene.yaml', () => yaml(sceneAsData())],
  stroke: ['Stroke', 'stroke.yaml', () => `- {${strokeParts((name, x) => `${name}: ${scalar(x)}`).join(', ')}}\n`],
  python: ['Python', 'shot.py', pythonText],
  command: ['Command', 'shot.sh', () => `billiard-shot predict scene.yaml ${strokeParts(
    (name, x) => `--${name.replace('_', '-')} ${[x].flat().join(' ')}`).join(' ')}\n`],
  ros: ['ROS 2', 'shot-ros.sh', rosText],
};

/** The scene as a scene file has it, with what was changed. */
function sceneAsData() {
  const scene = structuredClone(data.source);
  scene.balls = state.balls;
  for (const name of state.effects) scene.effects[name] = data.equipment.effects[name].on ? 'off' : 'auto';
  for (const [name, value] of Object.entries(state.parameters)) {
    const path = name.split('.');
    path.slice(0, -1).reduce((place, key) => (place[key] ??= {}), scene)[path.at(-1)] = value;
  }
  return scene;
}

/** The parts of the stroke as stroke files and options have them; vectors if it came so. */
function strokeParts(write) {
  const { normal, velocity, a, b, elevation, azimuth, speed } = state.stroke;
  const parts = normal ? { normal, velocity }
    : { a, b, elevation_deg: elevation * DEGREES, azimuth_deg: azimuth * DEGREES, speed };
  return Object.entries(parts).map(([name, value]) => write(name, value));
}

function pythonText() {
  const { normal, velocity } = state.stroke;
  const stroke = normal ? `Stroke(${JSON.stringify(normal)}, ${JSON.stringify(velocity)})`
    : `Stroke.from_offsets(${OFFSETS.map((name) => `${name}=${state.stroke[name]}`).join(', ')})`;
  const scene = JSON.stringify(sceneAsData()).replaceAll(/\b(true|false|null)\b(?=[,}\]])/g,
    (word) => ({ true: 'True', false: 'False', null: 'None' })[word]);
  return `from billiard_shot import predict, Scene, Stroke\n\nscene = Scene.from_dict(${scene})\n`
    + `shot = predict(scene, ${stroke})\nprint(shot)\n`;
}

function rosText() {
  const { a, b, elevation, azimuth, speed } = state.stroke;
  const { right, up, along } = axesOf(state.stroke);
  const ball = [...state.balls.cue, data.scene.radius];
  const axis = add(scale(right, a * CURVED), up, b * CURVED);
  const tip = add(add(ball, axis, data.scene.radius), along, -2 * data.scene.radius);
  const turn = product(rotation([0, 0, azimuth]), rotation([0, elevation, 0]));
  const vector = (values) => `{${values.map((x, i) => `${'xyzw'[i]}: ${scalar(x)}`).join(', ')}}`;
  return 'ros2 service call /predict_shot billiard_shot_msgs/srv/PredictShot \\\n'
    + `  "{cue_pose: {position: ${vector(tip)}, orientation: ${vector(turn)}}, speed: ${scalar(speed)}, `
    + `ball_position: ${vector(ball)}}"\n`;
}

/** A number as YAML 1.1 has it, with a point before an exponent; other values as JSON. */
function scalar(value) {
  if (Array.isArray(value)) return `[${value.map(scalar).join(', ')}]`;
  const text = JSON.stringify(value);
  return typeof value === 'number' ? text.replace(/^(-?\d+)e/, '$1.0e') : text;
}

function yaml(values, indent = '') {
  return Object.entries(values).map(([key, value]) => {
    const name = /^[A-Za-z_]\w*$/.test(key) ? key : JSON.stringify(key);
    const nested = typeof value === 'object' && value !== null && !Array.isArray(value);
    if (!nested) return `${indent}${name}: ${scalar(value)}\n`;
    const inner = yaml(value, `${indent}  `);
    return inner ? `${indent}${name}:\n${inner}` : `${indent}${name}: {}\n`;
  }).join('');
}

function fillExports() {
  fill('export', Object.entries(EXPORTS).map(([key, [text]]) => [text, key]));
  element('export').addEventListener('change', showExport);
  element('copy').addEventListener('click', async () => {
    const text = element('exported');
    text.select();
    try {
      await navigator.clipboard.writeText(text.value);
    } catch {
      document.execCommand('copy'); // where the clipboard asks for more, such as in a file
    }
  });
  element('download').addEventListener('click', () => {
    const file = URL.createObjectURL(new Blob([element('exported').value], { type: 'text/plain' }));
    make('a', '', { href: file, download: EXPORTS[element('export').value][1] }).click();
    setTimeout(() => URL.revokeObjectURL(file), 1000);
  });
}

function showExport() {
  const [, file, text] = EXPORTS[element('export').value];
  element('exported').value = text();
  element('download').hidden = !file;
  update(element('reach'), { textContent: file ? '' : reachOfLink() });
}

/** Why a link does not work for everybody; empty if it does. */
function reachOfLink() {
  const { protocol, hostname } = location;
  if (data.site || (protocol.startsWith('http') && !['127.0.0.1', 'localhost'].includes(hostname))) return '';
  return protocol === 'file:' ? 'The link opens the file on this machine. For somebody else, send the file, too.'
    : 'The link works only here. For somebody else, send the scene and the stroke.';
}

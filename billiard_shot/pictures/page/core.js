// The compiled core, and tables to play on with the equipment of a state.

const WORKERS = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, 2), 8);
const MOST_TABLES = 30; // that are kept: effects are compared on as many
const IN_THE_WAY = ['CUE_THROUGH_CLOTH', 'CUE_THROUGH_BALL', 'CUE_THROUGH_CUSHION'];
const RAISE = 0.5 / DEGREES; // by which the cue is raised until nothing is in its way
const STEEPEST = 89.5 / DEGREES;
let core = null;
const tables = new Map(); // by their equipment

async function openCore() {
  const { module, wasm, description } = billiardShotCore;
  const { load } = await import(URL.createObjectURL(new Blob([module], { type: 'text/javascript' })));
  const described = await unpacked(description).then((packed) => new Response(packed).json());
  core = await load({ wasm: await unpacked(wasm), description: described, workers: WORKERS });
}

async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).arrayBuffer();
}

/** The table with the effects and parameters of a state. */
function tableFor({ effects, parameters }) {
  const key = JSON.stringify([[...effects].sort(), parameters]);
  if (!tables.has(key)) {
    const [oldest, used] = tables.size >= MOST_TABLES ? tables.entries().next().value : [];
    tables.delete(oldest);
    tables.set(key, new core.Table(sceneWith(effects, parameters), used));
  }
  return tables.get(key);
}

function sceneWith(effects, parameters) {
  const { play_tables: play, ...others } = structuredClone(data.scene.entries);
  const put = (path, value) => {
    path.slice(0, -1).reduce((place, key) => place[key], play)[path.at(-1)] = value;
  };
  for (const { name, paths } of data.equipment.parameters) {
    if (Object.hasOwn(parameters, name)) paths.forEach((path) => put(path, parameters[name]));
  }
  for (const [name, { change: entries }] of Object.entries(data.equipment.effects)) {
    if (effects.includes(name)) entries.forEach(([path, value]) => put(path, value));
  }
  if (others.find_direct_shots) { // on the same cloth; pockets open as wide as before
    const { params, numbers } = play.layout;
    Object.assign(others.find_direct_shots.layout, { params, numbers });
  }
  return { ...data.scene, entries: { play_tables: play, ...others } };
}

/** The stroke at the lowest elevation from `level` on at which nothing is in the way of the cue. */
function raised(balls, stroke, level) {
  const table = tableFor(state);
  let elevation = level;
  for (let step = Math.floor(level / RAISE) + 1; elevation <= STEEPEST; step++) {
    if (!IN_THE_WAY.includes(table.refusal(balls, { ...stroke, elevation }))) return { ...stroke, elevation };
    elevation = step * RAISE;
  }
  return { ...stroke, elevation: level };
}

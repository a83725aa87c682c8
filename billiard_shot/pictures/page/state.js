// What the reader can change: one plain object, which only `change` replaces; with undo.

const data = JSON.parse(element('data').textContent);
const OFFSETS = ['a', 'b', 'elevation', 'azimuth', 'speed'];

/**
 * `balls`: where they lie (x, y) [m]; `stroke`: its offsets, at first also the vectors of a shot of
 * Python; `level`: the elevation to which the cue returns if nothing is in its way; `noise`: errors of
 * the player; `effects`: those that are not as in the scene; `parameters`: numbers that are not;
 * `target`: a ball and a pocket, or null for those that the shot suggests; `kept`: up to two shots
 * to compare with; `drill`: a start, and how often it succeeded; `played`: the stroke that errors
 * made of the last try.
 */
let state = {
  balls: data.scene.places, stroke: { a: 0, b: 0, elevation: 0, azimuth: 0, speed: 2 }, level: 0,
  noise: data.scene.noise, effects: [], parameters: {}, target: null, units: 'si', kept: [],
  drill: null, played: null,
};
const past = [];
const future = [];
const MOST_STEPS = 200; // that can be undone
const watchers = [];
let dragged = null; // the kind of the last change: further ones of this kind are the same step

const offsetsOf = (stroke) => Object.fromEntries(OFFSETS.map((name) => [name, stroke[name]]));

/** Change the state; changes of one `kind` that follow each other are undone together. */
function change(changes, kind = null) {
  if (!kind || kind !== dragged) past.push(state);
  past.splice(0, past.length - MOST_STEPS);
  dragged = kind;
  future.length = 0;
  show({ ...state, played: null, ...changes });
}

function endOfDrag() {
  dragged = null;
}

const undo = () => takeStep(past, future);
const redo = () => takeStep(future, past);

function takeStep(from, to) {
  if (!from.length) return;
  to.push(state);
  endOfDrag();
  show(from.pop());
}

function show(next) {
  const before = state;
  state = next;
  watchers.forEach((watcher) => watcher(before));
}

/** Call a function after each change of some fields, with the state before. */
function watch(names, act) {
  watchers.push((before) => names.some((name) => state[name] !== before[name]) && act(before));
}

/** Change the stroke; the cue is raised as far as it needs. */
function aim(changes, kind, others = {}) {
  const level = changes.elevation ?? state.level;
  const stroke = { ...offsetsOf(state.stroke), ...changes };
  change({ ...others, level, stroke: raised(others.balls ?? state.balls, stroke, level) }, kind);
}

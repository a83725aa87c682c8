// What is where at a time, the camera, and all that people can press.

const data = JSON.parse(document.getElementById('data').textContent);
const element = (id) => document.getElementById(id);
const RATES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4];
const [REST, , , , , POCKETED, OFF] = [0, 1, 2, 3, 4, 5, 6];
const MOTIONS = ['rests', 'slides', 'rolls', 'spins', 'flies', 'in a pocket', 'off the table'];
const MARKS = { // colours of events on the slider
  strike: '#ffffff', cushion: '#009e73', ball: '#cc79a7', cluster: '#cc79a7', pocket: '#e69f00',
  off: '#d55e00', roll: '#0072b2', bounce: '#9aa6b0', land: '#9aa6b0',
};
const BEGIN = data.events.length ? -data.cue.time - 0.1 : 0;
const END = Math.max(data.until, 0.01);

// ---- the shot: what is where at a time ----

// State of a ball at a time [s]: what its trajectory says.
function stateOf(ball, time) {
  const { segments } = ball;
  const t = Math.max(time, 0);
  const row = segments[Math.max(countUpTo(t, segments.length, (i) => segments[i][0]) - 1, 0)];
  const dt = row[1] === REST || row[1] >= POCKETED ? 0 : t - row[0];
  const part = (from) => row.slice(from, from + 3);
  const acceleration = part(8);
  return {
    motion: row[1],
    since: t - row[0],
    position: add(add(part(2), part(5), dt), acceleration, dt * dt / 2),
    velocity: add(part(5), acceleration, dt),
    spin: add(part(11), part(14), dt),
  };
}

function turnOf({ times, turns }, time) {
  const next = clamp(countUpTo(time, times.length, (i) => times[i]), 1, times.length);
  const quaternion = (i) => turns.slice(4 * i, 4 * i + 4);
  if (next === times.length) return quaternion(times.length - 1);
  const part = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return slerp(quaternion(next - 1), quaternion(next), Math.max(part, 0));
}

// A ball as it is drawn; one that is gone falls out of sight.
function shownBall(ball, time) {
  const { motion, since, position } = stateOf(ball, time);
  const shown = { place: position, turn: turnOf(ball, time), opacity: 1 };
  if (motion === POCKETED) {
    const hole = nearestHole(position);
    const way = 1 - Math.exp(-12 * since);
    shown.place = [position[0] + way * (hole[0] - position[0]) * 0.6,
      position[1] + way * (hole[1] - position[1]) * 0.6, position[2] - 4.9 * since * since];
  }
  if (motion === OFF) shown.opacity = clamp(1 - 2 * since, 0, 1);
  if (shown.place[2] < -0.13) shown.opacity = 0;
  return shown;
}

function nearestHole([x, y]) {
  const distance = (hole) => Math.hypot(hole[0] - x, hole[1] - y);
  return data.table.holes.reduce((a, b) => (distance(a) < distance(b) ? a : b));
}

// The cue speeds up evenly, strikes at 0, goes on for a moment, and is taken away.
function shownCue(time) {
  const { tip, direction, swing, time: swingTime, after } = data.cue;
  let ahead = after * 0.06;
  if (time < 0) ahead = -swing * (1 - clamp(1 + time / swingTime, 0, 1) ** 2);
  else if (time < 0.12) ahead = after * (time - time * time / 0.24);
  return { tip: add(tip, direction, ahead), opacity: clamp(2 - 2.5 * time, 0, 1) };
}

// ---- the camera ----

const centre = data.balls.find(({ name }) => name === 'cue') || data.balls[0];
const points = data.trails.flatMap(({ points: line }) => line);
const range = (axis) => {
  const values = [centre.segments[0][2 + axis], ...points.filter((_, i) => i % 3 === axis)];
  return [Math.min(...minmax(values)), Math.max(...minmax(values))];
};
data.middle = [0, 1].map((axis) => (range(axis)[0] + range(axis)[1]) / 2);
data.half = [0, 1].map((axis) => Math.max((range(axis)[1] - range(axis)[0]) / 2, 0.25) + 0.15);
data.extent = Math.max(3, ...[0, 1].map((axis) => range(axis)[1] - range(axis)[0])) + 3;

function minmax(values) { // Math.min(...values) has a limit
  return values.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)],
    [Infinity, -Infinity]);
}

const camera = { azimuth: 0, elevation: 0, distance: 1, target: [0, 0, 0] };
const FIELD = 0.62; // rad, its angle of view from below to above

// What has to be in view: corners of the table, or of all that moves on an endless cloth.
const corners = [-1, 1].flatMap((i) => [-1, 1].map((j) => (data.table
  ? [i * data.table.frame[0], j * data.table.frame[1], 0]
  : [data.middle[0] + i * data.half[0], data.middle[1] + j * data.half[1], 0])));

function look(view) {
  const [dx, dy, dz] = data.cue.direction;
  const level = Math.hypot(dx, dy);
  const middle = data.table ? [0, 0, 0] : [...data.middle, 0];
  if (view === 'player') {
    const ahead = level > 1e-6 ? [dx / level, dy / level, 0] : [0, 0, 0];
    Object.assign(camera, {
      azimuth: level > 1e-6 ? Math.atan2(-dy, -dx) : Math.PI, distance: 1.9,
      elevation: clamp(Math.asin(-dz) + 0.2, 0.28, 1.2),
      target: add(stateOf(centre, 0).position, ahead, 0.35),
    });
  } else {
    const angles = view === 'top' ? [-Math.PI / 2, Math.PI / 2] : [-1.95, 0.78];
    Object.assign(camera, { azimuth: angles[0], elevation: angles[1], target: middle });
    camera.distance = fitting(element('follow').checked);
  }
  draw();
}

// The least distance from which all corners are seen; of something to follow, its surroundings.
function fitting(follows) {
  if (follows) return 1.8;
  const { clientWidth, clientHeight } = element('canvas');
  const room = [20, 20, clientWidth - panelWidth() - 20, clientHeight - 84];
  for (camera.distance = 0.6; camera.distance < 60; camera.distance *= 1.02) {
    const seen = corners.map(project);
    if (seen.every(([x, y]) => x > room[0] && x < room[2] && y > room[1] && y < room[3])) break;
  }
  return camera.distance;
}

const panelWidth = () => {
  const { offsetWidth } = document.querySelector('aside');
  return offsetWidth ? offsetWidth + 20 : 0;
};

// The side panel covers a part of the window: the middle of the rest is where the target is.
function cameraNow() {
  const canvas = element('canvas');
  const { azimuth, elevation, distance } = camera;
  const target = element('follow').checked ? stateOf(centre, time).position : camera.target;
  const c = Math.cos(elevation);
  const eye = add(target, [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(elevation)], distance);
  const up = [-Math.sin(elevation) * Math.cos(azimuth), -Math.sin(elevation) * Math.sin(azimuth), c];
  const width = canvas.clientWidth;
  const projection = perspective(FIELD, width / canvas.clientHeight, 0.01 * distance + 0.005, 12 * distance + 5);
  projection[8] = panelWidth() / width; // moves the picture to the left by half the panel
  projection[9] = -60 / canvas.clientHeight;
  return { matrix: multiply(projection, lookAt(eye, target, up)), eye, target, distance };
}

// Where a place [m] is on the canvas, in pixels of the page.
function project(place) {
  const { matrix } = cameraNow();
  const [x, y, , w] = [0, 1, 2, 3].map((row) => matrix[row] * place[0] + matrix[4 + row] * place[1]
    + matrix[8 + row] * place[2] + matrix[12 + row]);
  const canvas = element('canvas');
  return [(0.5 + 0.5 * x / w) * canvas.clientWidth, (0.5 - 0.5 * y / w) * canvas.clientHeight];
}

// ---- time ----

let time = BEGIN;
let playing = false;
let last = 0;
let renderer = null;

function setTime(value) {
  time = clamp(value, BEGIN, END);
  element('slider').value = time;
  draw();
}

function play(on) {
  if (on && time >= END) setTime(BEGIN);
  playing = on;
  element('play').textContent = on ? '❚❚' : '▶';
  if (on) {
    last = performance.now();
    requestAnimationFrame(step);
  }
}

function step(now) {
  if (!playing) return;
  const elapsed = Math.min(now - last, 100) / 1000;
  last = now;
  setTime(time + elapsed * Number(element('rate').value));
  if (time >= END) play(false);
  else requestAnimationFrame(step);
}

function changeRate(by) {
  const select = element('rate');
  select.selectedIndex = clamp(select.selectedIndex + by, 0, RATES.length - 1);
}

function nextEvent(by) {
  const times = [BEGIN, ...data.events.map((event) => event.time), END];
  const found = by > 0 ? times.find((t) => t > time + 1e-6) : times.findLast((t) => t < time - 1e-6);
  if (found !== undefined) setTime(found);
}

// ---- the page ----

let asked = false;

function draw() {
  if (asked || !renderer) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    renderer.draw(cameraNow(), data.balls.map((ball) => shownBall(ball, time)), shownCue(time),
      element('paths').checked);
    describe();
  });
}

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1').replace('-', '−');

function describe() {
  const { motion, position, velocity, spin } = stateOf(centre, time);
  const vector = (values, digits) => values.map((x) => fixed(x, digits).padStart(digits + 3)).join('  ');
  const rows = [
    [`${centre.name} ball`, time < 0 ? 'waits' : MOTIONS[motion]],
    ['place (m)', vector(position, 3)],
    ['velocity (m/s)', vector(time < 0 ? [0, 0, 0] : velocity, 2)],
    ['spin (rad/s)', vector(time < 0 ? [0, 0, 0] : spin, 1)],
    ['speed (m/s)', fixed(time < 0 ? 0 : Math.hypot(...velocity), 3)],
  ];
  element('readout').replaceChildren(...rows.flatMap(([name, text]) => [make('dt', name), make('dd', text)]));
  element('clock').textContent = `${fixed(time, 3)} s`;
  const now = countUpTo(time + 1e-9, data.events.length, (i) => data.events[i].time) - 1;
  element('events').querySelectorAll('button').forEach((button, i) => {
    button.classList.toggle('past', i <= now);
    const entered = i === now && !button.classList.contains('now');
    button.classList.toggle('now', i === now);
    if (entered) button.scrollIntoView({ block: 'nearest' });
  });
}

function make(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

function fillPage() {
  document.querySelector('h1').textContent = data.title;
  element('message').textContent = data.message;
  Object.assign(element('slider'), { min: BEGIN, max: END, value: BEGIN });
  element('events').replaceChildren(...data.events.map((event) => {
    const item = document.createElement('li');
    const button = document.createElement('button');
    button.append(make('span', fixed(event.time, 3)), event.text);
    button.addEventListener('click', () => setTime(event.time));
    item.append(button);
    return item;
  }));
  element('ticks').replaceChildren(...data.events.filter(({ kind }) => MARKS[kind]).map((event) => {
    const tick = document.createElement('i');
    tick.style.left = `${100 * (event.time - BEGIN) / (END - BEGIN)}%`;
    tick.style.background = MARKS[event.kind];
    return tick;
  }));
  element('rate').replaceChildren(...RATES.map((rate) => {
    const option = make('option', `${rate}×`);
    option.value = rate;
    return option;
  }));
  element('rate').value = 1;
  const names = { slide: 'slides', roll: 'rolls', flight: 'flies' };
  const seen = new Map(data.trails.map(({ motion, colour }) => [motion, colour]));
  element('key').replaceChildren(...[...seen].map(([motion, colour]) => {
    const item = document.createElement('li');
    const swatch = document.createElement('i');
    swatch.style.background = motion === 'flight'
      ? 'repeating-linear-gradient(90deg, #fff 0 4px, transparent 4px 7px)'
      : colour;
    item.append(swatch, names[motion]);
    return item;
  }));
  element('follow').checked = !data.table && data.extent > 9;
}

function listen() {
  const canvas = element('canvas');
  const fingers = new Map();
  const toggles = { f: 'follow', p: 'paths' };
  const keys = {
    ' ': () => play(!playing), ArrowLeft: (fast) => setTime(time - (fast ? 0.2 : 0.01)),
    ArrowRight: (fast) => setTime(time + (fast ? 0.2 : 0.01)), Home: () => setTime(BEGIN),
    End: () => setTime(END), PageUp: () => nextEvent(-1), PageDown: () => nextEvent(1),
    '+': () => changeRate(1), '=': () => changeRate(1), '-': () => changeRate(-1),
    1: () => look('corner'), 2: () => look('player'), 3: () => look('top'),
    '?': () => element('keys').showModal(),
  };
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || element('keys').open) return;
    const toggle = toggles[event.key.toLowerCase()];
    const act = toggle ? () => element(toggle).click() : keys[event.key];
    if (!act || (event.target.tagName === 'SELECT' && event.key !== ' ')) return;
    event.preventDefault();
    act(event.shiftKey);
  });
  element('slider').addEventListener('input', (event) => {
    play(false);
    setTime(Number(event.target.value));
  });
  element('play').addEventListener('click', () => play(!playing));
  element('help').addEventListener('click', () => element('keys').showModal());
  for (const name of Object.values(toggles)) element(name).addEventListener('change', draw);
  document.querySelectorAll('[data-view]').forEach((button) => {
    button.addEventListener('click', () => look(button.dataset.view));
  });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  for (const name of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
  }
  canvas.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    const other = [...fingers.values()].find(({ pointerId }) => pointerId !== event.pointerId);
    if (other) {
      const gap = ({ clientX, clientY }) => Math.hypot(clientX - other.clientX, clientY - other.clientY);
      zoom(gap(before) / Math.max(gap(event), 1));
    } else if (event.shiftKey || event.buttons & 6) pan(dx, dy);
    else turn(dx, dy);
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(Math.exp(0.0012 * event.deltaY));
  }, { passive: false });
  new ResizeObserver(draw).observe(canvas);
}

function turn(dx, dy) {
  camera.azimuth -= 0.006 * dx;
  camera.elevation = clamp(camera.elevation + 0.006 * dy, 0.02, Math.PI / 2);
  draw();
}

function zoom(factor) {
  camera.distance = clamp(camera.distance * factor, 0.12, 60);
  draw();
}

function pan(dx, dy) {
  const size = 2 * Math.tan(FIELD / 2) * camera.distance / element('canvas').clientHeight;
  const [c, s] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth)];
  const lift = Math.max(Math.sin(camera.elevation), 0.3);
  camera.target = add(camera.target,
    [size * (dx * s - dy * c / lift), size * (-dx * c - dy * s / lift), 0]);
  draw();
}

function start() {
  fillPage();
  listen();
  try {
    renderer = new Renderer(element('canvas'), data);
  } catch (error) {
    element('trouble').textContent = error.message;
    element('trouble').hidden = false;
    describe();
    return;
  }
  look('corner');
  setTime(BEGIN);
}

// For other programs, and for the tests: what is shown, and where.
window.view = {
  get time() { return time; }, get playing() { return playing; }, setTime, play, look, project, camera,
  state: (name) => {
    const ball = data.balls.find((one) => one.name === name);
    return { ...stateOf(ball, time), turn: turnOf(ball, time) };
  },
};

start();

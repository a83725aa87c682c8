// Time, the page, and all that people can press.

const RATES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4];
const MOTIONS = ['rests', 'slides', 'rolls', 'spins', 'flies', 'in a pocket', 'off the table'];

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
  const times = [BEGIN, ...listed.map((event) => event.time), END];
  const found = by > 0 ? times.find((t) => t > time + 1e-6) : times.findLast((t) => t < time - 1e-6);
  if (found !== undefined) setTime(found);
}

// ---- the page ----

const FAINT = 0.3; // opacity of the paths of others, if a ball is followed
let asked = false;

function draw() {
  if (asked || !renderer) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    const balls = data.balls.map((ball) => shownBall(ball, time));
    const paths = data.balls.map((ball) =>
      (!element('paths').checked ? 0 : followed && followed !== ball ? FAINT : 1));
    const view = cameraNow();
    renderer.draw(view, balls, shownCue(time), paths);
    placeLabels(balls, view);
    describe();
  });
}

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1').replace('-', '−');

function describe() {
  const ball = followed || cueBall;
  const { motion, position, velocity, spin } = stateOf(ball, time);
  const vector = (values, digits) => values.map((x) => fixed(x, digits).padStart(digits + 3)).join('  ');
  const rows = [
    [ball.name === 'cue' ? 'cue ball' : ball.name, time < 0 ? 'waits' : MOTIONS[motion]],
    ['position (m)', vector(position, 3)],
    ['velocity (m/s)', vector(time < 0 ? [0, 0, 0] : velocity, 2)],
    ['spin (rad/s)', vector(time < 0 ? [0, 0, 0] : spin, 1)],
    ['speed (m/s)', fixed(time < 0 ? 0 : Math.hypot(...velocity), 3)],
  ];
  element('readout').replaceChildren(...rows.flatMap(([name, text]) => [make('dt', name), make('dd', text)]));
  element('clock').textContent = `${fixed(time, 3)} s`;
  markEvents();
}

function fillPage() {
  document.querySelector('h1').textContent = data.title;
  element('message').textContent = data.message;
  Object.assign(element('slider'), { min: BEGIN, max: END, value: BEGIN });
  fill('rate', RATES.map((rate) => [`${rate}×`, rate]));
  element('rate').value = 1;
  fillChoices();
  fillStroke();
  listEvents();
  const motions = new Set(data.balls.flatMap(({ trails }) => trails.map(({ motion }) => motion)));
  const names = { roll: 'rolls', slide: 'slides', flight: 'flies' };
  element('key').replaceChildren(...Object.keys(names).filter((motion) => motions.has(motion)).map((motion) => {
    const item = document.createElement('li');
    const line = document.createElement('i');
    line.className = motion;
    item.append(line, names[motion]);
    return item;
  }));
}

const STILL = 4; // pixels that the pointer may move in a click

function listen() {
  const canvas = element('canvas');
  const fingers = new Map();
  let pressed = null; // the press that is a click, unless the pointer moves
  const toggles = { n: 'names', p: 'paths', i: 'panel' };
  const keys = {
    ' ': () => play(!playing), ArrowLeft: (fast) => setTime(time - (fast ? 0.2 : 0.01)),
    ArrowRight: (fast) => setTime(time + (fast ? 0.2 : 0.01)), Home: () => setTime(BEGIN),
    End: () => setTime(END), PageUp: () => nextEvent(-1), PageDown: () => nextEvent(1),
    '+': () => changeRate(1), '=': () => changeRate(1), '-': () => changeRate(-1),
    1: () => look('corner'), 2: () => look('player'), 3: () => look('top'),
    f: () => follow(followed ? null : cueBall), '?': () => element('keys').showModal(),
  };
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || element('keys').open) return;
    const toggle = toggles[event.key.toLowerCase()];
    const act = toggle ? () => element(toggle).click() : keys[event.key.toLowerCase()] || keys[event.key];
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
  for (const name of ['names', 'paths']) element(name).addEventListener('change', draw);
  element('panel').addEventListener('click', () => {
    document.querySelector('aside').classList.toggle('away');
    fitAgain();
  });
  for (const name of ['ball', 'kind']) element(name).addEventListener('change', listEvents);
  element('follow').addEventListener('change', ({ target: { value } }) =>
    follow(data.balls.find(({ name }) => name === value) || null));
  document.querySelectorAll('[data-view]').forEach((button) => {
    button.addEventListener('click', () => look(button.dataset.view));
  });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
    pressed = fingers.size === 1 && event.button === 0 ? event : null;
  });
  canvas.addEventListener('pointerup', (event) => {
    fingers.delete(event.pointerId);
    if (pressed) follow(ballAt(event.clientX, event.clientY));
    pressed = null;
  });
  canvas.addEventListener('pointercancel', (event) => fingers.delete(event.pointerId));
  canvas.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    if (pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < STILL) return;
    pressed = null;
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
  new ResizeObserver(fitAgain).observe(canvas);
}

function fitAgain() {
  if (kept) look(kept);
  else draw();
}

function turn(dx, dy) {
  kept = null;
  camera.azimuth -= 0.006 * dx;
  camera.elevation = clamp(camera.elevation + 0.006 * dy, 0, Math.PI / 2);
  draw();
}

function zoom(factor) {
  kept = null;
  camera.distance = clamp(camera.distance * factor, 0.12, 60);
  draw();
}

function pan(dx, dy) {
  follow(null);
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
  document.querySelector('aside').classList.toggle('away', window.innerWidth <= 700);
  look('corner');
  if (!data.table && data.extent > 9) follow(cueBall);
  setTime(BEGIN);
}

// For other programs, and for the tests: what is shown, and where.
window.view = {
  get time() { return time; }, get playing() { return playing; }, setTime, play, look, project, camera,
  follow: (name) => follow(data.balls.find((one) => one.name === name) || null),
  get eye() { return cameraNow().eye; }, get followed() { return followed && followed.name; }, freeArea,
  state: (name) => {
    const ball = data.balls.find((one) => one.name === name);
    return { ...stateOf(ball, time), turn: turnOf(ball, time) };
  },
};

start();

// Time, the page, and all that people can press.

const RATES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4];
const MOTIONS = ['rests', 'slides', 'rolls', 'spins', 'flies', 'in a pocket', 'off the table'];
const MARKS = { // colours of events on the slider
  strike: '#ffffff', cushion: '#009e73', ball: '#cc79a7', cluster: '#cc79a7', pocket: '#e69f00',
  off: '#d55e00', roll: '#0072b2', bounce: '#9aa6b0', land: '#9aa6b0',
};

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

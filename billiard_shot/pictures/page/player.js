// The shot that is shown, its time, and all that people can press.

const RATES = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 4];
const MOTIONS = {
  REST: 'rests', SLIDE: 'slides', ROLL: 'rolls', SPIN: 'spins', FLIGHT: 'flies',
  POCKETED: 'in a pocket', OFF_TABLE: 'off the table',
};
const TABS = ['aim', 'shots', 'plan', 'table', 'balls', 'events', 'drill', 'share'];

let shown = null; // see `played`
let time = 0;
let playing = false;
let last = 0;
let renderer = null;
let tab = 'aim';

const begin = () => (shown.refused ? 0 : -shown.cue.time - 0.1);
const end = () => Math.max(shown.until, 0.01);

// ---- the shot ----

/** Play the stroke of the state, and show it from its beginning. */
function replay() {
  shown = played(state);
  shown.cue = cueOf(shown);
  playing = false;
  showPlaying();
  drawPaths();
  update(element('slider'), { min: begin(), max: end() });
  setTime(begin());
  tellStory();
  forgetEstimate();
  afterReplay();
}

const afterReplay = afterQuiet(100, () => {
  colourLabels();
  listEvents();
  showKey();
  compareEffects();
  if (tab === 'shots') listShots();
  if (tab === 'balls') listBalls();
  if (tab === 'share') showExport();
  writeLink();
  tell('outcome', outcomeNow());
});

function drawPaths() {
  if (!renderer) return;
  const { radius } = data.scene;
  shown.balls.forEach((ball, i) => {
    const lines = ball.there && ball.moved ? linesOf(ball, shown.until) : [];
    if (i === 0) lines.push(...ghostsOf(shown).map((place) => circle(place, radius)));
    renderer.setLines(`ball ${i}`, pointsOfLines(lines, LIFT - radius));
  });
  renderer.setLines('ring', pointsOfLines([circle(ringPlace(), RING * radius)], 2 * LIFT - radius));
}

function tellStory() {
  const text = sentenceOf(shown);
  update(element('message'), { textContent: text.charAt(0).toUpperCase() + text.slice(1) });
  element('message').classList.toggle('refused', shown.refused);
  const target = targetNow();
  update(element('why'), { textContent: target && !shown.refused ? whyMissed(shown, target) : '' });
}

// ---- time ----

function setTime(value) {
  time = clamp(value, begin(), end());
  update(element('slider'), { value: time });
  draw();
}

function play(on) {
  if (on && time >= end()) setTime(begin());
  playing = on && !shown.refused;
  showPlaying();
  if (playing) {
    last = performance.now();
    requestAnimationFrame(step);
  }
}

function showPlaying() {
  update(element('play'), { textContent: playing ? '❚❚' : '▶ Strike' });
}

function step(now) {
  if (!playing) return;
  const elapsed = Math.min(now - last, 100) / 1000;
  last = now;
  setTime(time + elapsed * Number(element('rate').value));
  if (time < end()) requestAnimationFrame(step);
  else {
    play(false);
    giveHint(state.drill ? 'Strike plays the next try.' : '↺ leads back to the start; Go on plays from here.');
  }
}

function changeRate(by) {
  const select = element('rate');
  select.selectedIndex = clamp(select.selectedIndex + by, 0, RATES.length - 1);
}

function nextEvent(by) {
  const times = [begin(), ...listed.map((event) => event.time), end()];
  const found = by > 0 ? times.find((t) => t > time + 1e-6) : times.findLast((t) => t < time - 1e-6);
  if (found !== undefined) setTime(found);
}

// ---- the page ----

const FAINT = 0.3; // opacity of the paths of others, if a ball is followed
let asked = false;

function draw() {
  if (asked || !shown) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    drawNow();
  });
}

function drawNow() {
  describe();
  if (!renderer) return;
  const balls = data.balls.map((_, number) => shownBall(shown, number, time));
  const paths = element('paths').checked;
  const lines = paths ? shown.balls.map(({ path }, i) => ({
    name: `ball ${i}`, colour: path ?? '#ffffff', width: path === PALE ? 1 : 2.2,
    opacity: followed !== null && followed !== i ? FAINT : 1,
  })) : [];
  const ring = { name: 'ring', colour: '#f0e442', width: 2.4, opacity: editable() && !playing ? 1 : 0 };
  const goal = { name: 'goal', colour: '#f0e442', width: 2.4, opacity: tab === 'plan' ? 1 : 0 };
  const view = cameraNow();
  const others = paths ? keptLines() : [];
  renderer.draw(view, balls, shownCue(shown, time), [...others, ...lines, ring, goal], paths ? clouds() : []);
  placeLabels(balls, view);
}

function describe() {
  const number = followed ?? 0;
  const { name, there, segments } = shown.balls[number];
  const { motion, position, velocity, spin } = stateAt(segments, time);
  const moves = time >= 0 && !shown.refused;
  const vector = (values, digits) => values.map((x) => fixed(x, digits).padStart(digits + 3)).join('  ');
  const rows = [
    [ballInWords(name), !there ? 'not on the table' : moves ? MOTIONS[motion] : 'waits'],
    ['position (m)', vector(position, 3)],
    ['velocity (m/s)', vector(moves ? velocity : [0, 0, 0], 2)],
    ['spin (rad/s)', vector(moves ? spin : [0, 0, 0], 1)],
    ['speed (m/s)', fixed(moves ? Math.hypot(...velocity) : 0, 3)],
  ];
  if (tab === 'events') {
    const parts = rows.flatMap(([what, text]) => [make('dt', what), make('dd', text)]);
    element('readout').replaceChildren(...parts);
    markEvents();
  }
  update(element('clock'), { textContent: `${fixed(time, 3)} s` });
  element('again').disabled = time <= begin();
  element('go-on').disabled = shown.refused || !shown.balls.every(({ segments: all }) => !isEndless(all));
}

function showKey() {
  const motions = new Set(shown.balls.flatMap(({ segments }) => segments.map(({ motion }) => motion)));
  const names = { ROLL: 'rolls', SLIDE: 'slides', FLIGHT: 'flies' };
  element('key').replaceChildren(...Object.keys(names).filter((motion) => motions.has(motion)).map((motion) =>
    make('li', [make('i', '', { className: motion.toLowerCase() }), names[motion]])));
}

/** Show the numbers of the panel that is open again. */
function showFields() {
  for (const { root, show: showField } of fields) if (!root.closest('[hidden]')) showField();
}

function openTab(name) {
  tab = name;
  for (const each of TABS) {
    update(element(`tab-${each}`), { ariaSelected: each === name, tabIndex: each === name ? 0 : -1 });
    element(`panel-${each}`).hidden = each !== name;
  }
  ({ shots: listShots, table: compareEffects, balls: listBalls, share: showExport })[name]?.();
  showFields();
  draw();
}

function fillPage() {
  document.querySelector('h1').textContent = data.title;
  fill('rate', RATES.map((rate) => [`${rate}×`, rate]));
  element('rate').value = 1;
  element('tabs').replaceChildren(...TABS.map((name) => {
    const made = button(name, () => openTab(name), { id: `tab-${name}`, role: 'tab' });
    made.setAttribute('aria-controls', `panel-${name}`);
    return made;
  }));
  element('tabs').addEventListener('keydown', (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return;
    event.stopPropagation();
    const there = TABS.filter((name) => !element(`tab-${name}`).hidden);
    const next = there.at((there.indexOf(tab) + by) % there.length);
    openTab(next);
    element(`tab-${next}`).focus();
  });
  fillChoices();
  fillStroke();
  fillErrors();
  fillEquipment();
  fillPlanner();
  fillExports();
}

function listen() {
  const toggles = { n: 'names', p: 'paths', i: 'panel' };
  const keys = {
    ' ': strike, ArrowLeft: (fast) => setTime(time - (fast ? 0.2 : 0.01)),
    ArrowRight: (fast) => setTime(time + (fast ? 0.2 : 0.01)), Home: () => setTime(begin()),
    End: () => setTime(end()), PageUp: () => nextEvent(-1), PageDown: () => nextEvent(1),
    '+': () => changeRate(1), '=': () => changeRate(1), '-': () => changeRate(-1),
    1: () => look('corner'), 2: () => look('player'), 3: () => look('top'),
    ',': () => turnCue(0.1), '.': () => turnCue(-0.1), '<': () => turnCue(1), '>': () => turnCue(-1),
    k: keepShot, g: () => element('go-on').click(),
    f: () => follow(followed === null ? 0 : null), '?': () => element('keys').showModal(),
  };
  const turnCue = (degrees) => aim({ azimuth: turned(state.stroke.azimuth + degrees / DEGREES) }, 'azimuth');
  document.addEventListener('keydown', (event) => {
    if (event.altKey || element('keys').open) return;
    const typing = event.target.matches('input:not(#slider):not([type=checkbox]), textarea, select');
    if (event.ctrlKey || event.metaKey) {
      const key = event.key.toLowerCase();
      if (typing || !['y', 'z'].includes(key)) return;
      event.preventDefault();
      if (key === 'y' || event.shiftKey) redo();
      else undo();
      return;
    }
    const toggle = toggles[event.key.toLowerCase()];
    const act = toggle ? () => element(toggle).click() : keys[event.key.toLowerCase()] || keys[event.key];
    if (!act || typing || (event.key === ' ' && event.target.matches('button, summary'))) return;
    event.preventDefault();
    act(event.shiftKey);
  });
  element('slider').addEventListener('input', (event) => {
    play(false);
    setTime(Number(event.target.value));
  });
  const clicks = {
    play: strike, again: () => setTime(begin()), help: () => element('keys').showModal(),
    undo, redo, keep: keepShot,
    'go-on': goOn, 'begin-drill': beginDrill, 'end-drill': () => change({ drill: null }),
    panel: () => showPanel(isAway()),
  };
  for (const [name, act] of Object.entries(clicks)) element(name).addEventListener('click', () => act());
  for (const name of ['names', 'paths']) element(name).addEventListener('change', draw);
  element('ball').addEventListener('change', listEvents);
  element('follow').addEventListener('change', ({ target: { value } }) => followNamed(value));
  element('units').addEventListener('change', ({ target: { value } }) => change({ units: value }));
  document.querySelectorAll('[data-view]').forEach((each) => {
    each.addEventListener('click', () => look(each.dataset.view));
  });
  window.addEventListener('hashchange', followLink);
  matchMedia('(prefers-color-scheme: light)').addEventListener('change', () => {
    renderer?.readRoom();
    draw();
  });
}

// ---- the panel: at the side; below the table in a narrow window, where only its head stays if it is away ----

const PULL = 24; // pixels by which its handle is pulled
const isAway = () => document.body.classList.contains('away');

function showPanel(on) {
  document.body.classList.toggle('away', !on);
  for (const id of ['pull', 'panel']) element(id).setAttribute('aria-expanded', on);
  fitAgain();
}

function listenToHandle() {
  const handle = element('pull');
  let from = null; // where it was touched; null once it is pulled
  handle.addEventListener('pointerdown', ({ pointerId, clientY }) => {
    handle.setPointerCapture(pointerId);
    from = clientY;
  });
  handle.addEventListener('pointermove', ({ clientY, buttons }) => {
    if (!buttons || from === null || Math.abs(clientY - from) < PULL) return;
    showPanel(clientY < from);
    from = null;
  });
  handle.addEventListener('click', ({ detail }) => (detail && from === null) || showPanel(isAway()));
}

function followNamed(name) {
  const number = data.balls.findIndex((ball) => ball.name === name);
  follow(number < 0 ? null : number);
}

function showState() {
  showStroke();
  showEffects();
  showDrill();
  showFields();
  element('units').value = state.units;
  element('undo').disabled = !past.length;
  element('redo').disabled = !future.length;
}

function giveHint(text) {
  update(element('hint'), { textContent: text, hidden: !text });
}

function trouble(text) {
  element('trouble').textContent = text;
  element('trouble').hidden = false;
}

async function start() {
  fillPage();
  const opened = openCore();
  try {
    renderer = new Renderer(element('canvas'), data);
  } catch (error) {
    trouble(error.message);
  }
  try {
    await opened;
  } catch (error) {
    trouble(`This browser cannot run the page: ${error.message}`);
    return;
  }
  if (data.start) state = { ...state, ...data.start, level: data.start.stroke.elevation };
  else {
    const stroke = firstStroke(state.balls);
    state = { ...state, stroke, level: stroke.elevation };
  }
  initial = state;
  watch(['balls', 'stroke', 'played', 'effects', 'parameters'], replay);
  watch(['noise', 'target'], forgetEstimate);
  watch(['noise'], showNameOfErrors);
  watch(['kept', 'units'], showKept);
  watch(['units', 'target'], tellStory);
  watchers.push(showState, writeLink, () => tell('state', publicState()), () => {
    giveHint('');
  });
  replay();
  listen();
  listenToPointer();
  listenToHandle();
  openTab('aim');
  showState();
  showPanel(window.innerWidth > 700);
  look('corner');
  if (!data.table && Math.max(...corners().flat()) > 9) follow(0);
  followLink();
  listenToFrame();
  document.body.dataset.ready = 'true';
}

// For other programs, and for the tests: what is shown, and where.
window.view = {
  get time() { return time; }, get playing() { return playing; }, get state() { return state; },
  get shown() { return shown; }, get estimate() { return estimate; }, get ring() { return ringPlace(); },
  get intended() { return targetNow(); },
  get eye() { return cameraNow().eye; },
  get followed() { return followed === null ? null : data.balls[followed].name; },
  setTime, play, look, project, camera, freeArea, change, aim, undo, openTab, tableFor, follow: followNamed,
  get outcome() { return outcomeNow(); },
  ball: (name) => {
    const number = data.balls.findIndex((ball) => ball.name === name);
    return { ...stateAt(shown.balls[number].segments, time), turn: turnAt(shown, number, time) };
  },
};

await start();

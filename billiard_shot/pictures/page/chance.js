// A moment after a change: how likely the shot is with the errors of the player, and where balls end.

const STROKES = 2000;
const COUNTED = [200, 500, 1000, 1500, STROKES]; // after so many strokes the chance is shown
const SEED = 1;
const QUIET = 150; // ms without a change
const CLOUDS = { cue: '#ffffff', target: '#e69f00' };
const ERRORS = [ // name, label, kind, range
  ['speed', 'speed', 'speed', [0, 0.3]],
  ['azimuth', 'direction', 'angle', [0, 1 / DEGREES]],
  ['elevation', 'elevation', 'angle', [0, 1 / DEGREES]],
  ['a', 'side', 'offset', [0, 0.1]],
  ['b', 'height', 'offset', [0, 0.1]],
];
let estimates = 0; // that were begun
let estimate = null; // the last: `chance` and `interval` if there is a target, and `spread`
let running = null; // the table whose workers play

/** What a shot is judged by: a ball and a pocket; in a break any ball may fall. */
const targetNow = () => state.target ?? (isRack(state.balls) ? {} : intended(shown));

function forgetEstimate() {
  estimates += 1;
  estimate = null;
  running?.close();
  running = null;
  for (const name of Object.keys(CLOUDS)) renderer?.setDots(name, []);
  showChance();
  estimateSoon();
}

const estimateSoon = afterQuiet(QUIET, async () => {
  estimates += 1;
  const [number, target, table] = [estimates, targetNow(), tableFor(state)];
  if (shown.refused) return;
  if (renderer && !renderer.isDone()) { // workers would take the processors from what draws
    estimateSoon();
    return;
  }
  running = table;
  const strokes = table.drawn(offsetsOf(state.stroke), state.noise, STROKES, SEED);
  let sample = null;
  for (const n of COUNTED) {
    const part = await table.sample(state.balls, strokes.slice(sample?.count ?? 0, n));
    if (number !== estimates) return;
    sample = sample?.and(part) ?? part;
    estimate = { n, target, ...(target && sample.chance(target)) };
    setClouds(sample, target);
    showChance();
    draw();
  }
  running = null;
  tell('estimate', estimate);
});

function setClouds(sample, target) {
  const places = (name) => sample.rests(name).flatMap(([x, y]) => [x, y, 2 * LIFT]);
  renderer?.setDots('cue', places('cue'));
  renderer?.setDots('target', target?.ball ? places(target.ball) : []);
}

const clouds = () => Object.entries(CLOUDS)
  .map(([name, colour]) => ({ name, colour, width: 2, opacity: 0.35 }));

const inWords = ({ ball, pocket }) => (ball === undefined ? 'break: a ball falls, the cue ball stays'
  : `${ballInWords(ball)} into ${placeInWords(pocket ?? 'any pocket')}`);

function showChance() {
  const target = targetNow();
  update(element('aim-at'), { textContent: target ? inWords(target) : '' });
  const known = estimate?.interval;
  update(element('chance'), { textContent: known ? percent(estimate.chance) : '' });
  update(element('interval'), { textContent: known
    ? `${between(known)}, ${estimate.n < STROKES ? `${estimate.n} of ` : ''}${STROKES} strokes` : '' });
  element('bar').style.width = known ? `${100 * estimate.chance}%` : '0';
}

function fillErrors() {
  element('errors').replaceChildren(...ERRORS.map(([name, label, kind, range]) => field(
    label, kind, range, () => state.noise[name],
    (value) => change({ noise: { ...state.noise, [name]: value } }, `error of ${name}`),
    [0, 10 * range[1]],
  )));
  fill('errors-of', [['own', ''], ...Object.keys(data.noises).map((name) => [name, name])]);
  element('errors-of').addEventListener('change', ({ target }) => {
    if (target.value) change({ noise: data.noises[target.value] });
  });
  showNameOfErrors();
}

/** Select the name of the errors, if they have one. */
function showNameOfErrors() {
  const isNow = ([, noise]) => ERRORS.every(([name]) => noise[name] === state.noise[name]);
  element('errors-of').value = Object.entries(data.noises).find(isNow)?.[0] ?? '';
}

// Plans of the server, if it has a planner: strokes that reach a target, as the search finds them.

const GOALS = [
  ['Pot', 'pot'], ['Hit first', 'hit'], ['Play safe on', 'safe'], ['Break with', 'break'],
  ['Stop at', 'rest'], ['Pass through', 'pass'], ['Pass between', 'gate'],
];
const CLICKS = { // what to click for goals that are places of the cue ball
  rest: 'Click the cloth where the cue ball is to stop.',
  pass: 'Click a place that the cue ball is to pass through.',
  gate: 'Click two places that the cue ball is to pass between.',
};
const AROUND = { rest: 0.1, pass: 0.02 }; // m by which the planner lets the cue ball be off
let marked = []; // places that were clicked
let search = null; // what cancels the one that runs

function fillPlanner() {
  element('tab-plan').hidden = !data.planner;
  const places = (names) => names.map((name) => [placeInWords(name), name]);
  fill('goal', GOALS);
  fill('goal-ball', [['any ball', 'any'], ...places(data.scene.names.slice(1))]);
  fill('goal-pocket', [['any pocket', 'any'], ...places([...data.scene.pockets])]);
  element('goal').addEventListener('change', ({ target: { value: goal } }) => {
    element('goal-pocket').hidden = goal !== 'pot';
    element('goal-ball').hidden = goal in CLICKS;
    element('planned').textContent = CLICKS[goal] ?? '';
    mark([]);
  });
  element('search').addEventListener('click', () => (search ? search.abort() : plan()));
}

function mark(places) {
  const goal = element('goal').value;
  marked = places.slice(goal === 'gate' ? -2 : -1);
  const lines = goal === 'gate' ? [{ points: marked.flatMap(([x, y]) => [x, y, 0]), motion: 'ROLL' }]
    : marked.map((place) => circle(place, AROUND[goal]));
  renderer?.setLines('goal', pointsOfLines(lines, goal === 'gate' ? LIFT : LIFT - data.scene.radius));
  draw();
}

/** Take a click for a place of the goal, if the goal has places. */
function takeClick(x, y) {
  const isTaken = tab === 'plan' && element('goal').value in CLICKS;
  if (isTaken) mark([...marked, placeAt(x, y, data.scene.radius).slice(0, 2)]);
  return isTaken;
}

function goalNow() {
  const [goal, ball, pocket] = ['goal', 'goal-ball', 'goal-pocket'].map((id) => element(id).value);
  if (!(goal in CLICKS)) return { [goal]: ball, ...(goal === 'pot' && { pocket }) };
  return { [goal]: goal === 'gate' ? marked : marked[0] ?? [] };
}

/** Ask for a plan, and show the strokes of each line of the answer. */
async function plan() {
  const [goal, { balls, effects, parameters }] = [goalNow(), state];
  const { pot: ball, pocket } = goal;
  const known = ball && ball !== 'any';
  const start = { balls, effects, parameters, target: known ? { ball, ...(pocket !== 'any' && { pocket }) } : null };
  const request = { state: publicState(), target: goal, seconds: element('seconds').valueAsNumber };
  search = new AbortController();
  element('search').textContent = 'Cancel';
  element('plans').replaceChildren();
  try {
    let end = 'The search has ended without a result.';
    for await (const { progress, refused, result } of answers(request, search.signal)) {
      if (progress) element('planned').textContent = showProgress(progress, start);
      else end = refused ?? showPlans(result, start);
    }
    element('planned').textContent = end;
  } catch (error) {
    element('planned').textContent = search.signal.aborted ? 'Cancelled.' : `There is no answer: ${error.message}`;
  }
  search = null;
  element('search').textContent = 'Plan';
}

/** Yield the lines of the answer to a request. */
async function* answers(request, signal) {
  const response = await fetch('plan', { method: 'POST', body: JSON.stringify(request), signal });
  if (!response.ok) throw new Error(`${response.status} ${response.statusText}`);
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  for (let rest = ''; ;) {
    const { done, value } = await reader.read();
    if (done) return;
    const lines = (rest + value).split('\n');
    rest = lines.pop();
    yield* lines.map((line) => JSON.parse(line));
  }
}

function showProgress({ simulations, budget, success, stroke }, start) {
  const list = element('plans');
  const found = JSON.stringify(stroke);
  if (stroke && found !== list.lastChild?.dataset.found) {
    list.append(planned('so far', stroke, `about ${percent(success)}`, start));
    list.lastChild.dataset.found = found;
  }
  return `${simulations} of at most ${budget} strokes`;
}

function showPlans({ message, ranking }, start) {
  element('plans').replaceChildren(...ranking.map(({ kind, success, interval, warning, ...stroke }) =>
    planned(kind, stroke, `${percent(success)} (${between(interval)})`, start, warning)));
  return message;
}

/** A line that tries a stroke from the places that it was found for. */
function planned(kind, stroke, chance, start, warning = '') {
  const parts = [make('span', kind), make('small', inUnits(stroke.speed, 'speed')), make('b', chance)];
  return make('li', button(parts, () => aim(offsetsOf(stroke), null, start), { title: warning || kind }));
}

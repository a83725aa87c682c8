// Plans of the server, if it has a planner: strokes that reach a target, as the search finds them.

const GOALS = [['Pot', 'pot'], ['Hit first', 'hit'], ['Play safe on', 'safe'], ['Break with', 'break']];
let search = null; // what cancels the one that runs

function fillPlanner() {
  element('tab-plan').hidden = !data.planner;
  const places = (names) => names.map((name) => [placeInWords(name), name]);
  fill('goal', GOALS);
  fill('goal-ball', [['any ball', 'any'], ...places(data.scene.names.slice(1))]);
  fill('goal-pocket', [['any pocket', 'any'], ...places([...data.scene.pockets])]);
  element('goal').addEventListener('change', () => {
    element('goal-pocket').hidden = element('goal').value !== 'pot';
  });
  element('search').addEventListener('click', () => (search ? search.abort() : plan()));
}

/** Ask for a plan, and show the strokes of each line of the answer. */
async function plan() {
  const [goal, ball, pocket] = ['goal', 'goal-ball', 'goal-pocket'].map((id) => element(id).value);
  const { balls, effects, parameters } = state;
  const known = goal === 'pot' && ball !== 'any';
  const start = { balls, effects, parameters, target: known ? { ball, ...(pocket !== 'any' && { pocket }) } : null };
  const request = { state: publicState(), target: { [goal]: ball, ...(goal === 'pot' && { pocket }) } };
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
    planned(kind, stroke, `${percent(success)} (${interval.map(percent).join(' to ')})`, start, warning)));
  return message;
}

/** A line that tries a stroke from the places that it was found for. */
function planned(kind, stroke, chance, start, warning = '') {
  const parts = [make('span', kind), make('small', inUnits(stroke.speed, 'speed')), make('b', chance)];
  return make('li', button(parts, () => aim(offsetsOf(stroke), null, start), { title: warning }));
}

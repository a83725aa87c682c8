// A drill: a start that is kept; each strike is a try with errors of the player, and counted.

function beginDrill() {
  const target = targetNow();
  if (target) change({ drill: { tries: 0, successes: 0 }, target });
  else giveHint('A drill needs a shot that meets a ball, and pockets.');
}

/** Strike, pause, or go on; in a drill a strike is the next try. */
function strike() {
  if (state.drill && (time <= begin() || time >= end())) tryDrill();
  else play(!playing);
}

/** Play the stroke with errors; count whether it reaches the target. */
function tryDrill() {
  const { drill, target } = state;
  const table = tableFor(state);
  // another seed for each try, so that a link brings the same tries back
  const [stroke] = table.drawn(offsetsOf(state.stroke), state.noise, 1, SEED + 1 + drill.tries);
  stroke.elevation = clamp(stroke.elevation, 0, Math.PI / 2);
  stroke.azimuth = turned(stroke.azimuth);
  const successes = drill.successes + table.shoot(state.balls, stroke).reaches(target);
  change({ played: stroke, drill: { tries: drill.tries + 1, successes } });
  play(true);
}

function showDrill() {
  const { drill } = state;
  element('no-drill').hidden = Boolean(drill);
  element('drilling').hidden = !drill;
  if (!drill) return;
  const { tries, successes } = drill;
  element('drill-target').textContent = inWords(targetNow());
  element('score').textContent = tries
    ? `${successes} of ${tries}: ${percent(successes / tries)}` : 'no try yet';
}

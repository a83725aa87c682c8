// A menu of all direct shots from where the balls lie, the surest first; a click aims.

const MOST_LISTED = 40;

function directShots(balls) {
  const found = data.scene.pockets.length ? tableFor(state).shots(balls) : [];
  return found.sort((a, b) => b.chance - a.chance);
}

function listShots() {
  const found = directShots(state.balls);
  element('shots').replaceChildren(...found.slice(0, MOST_LISTED).map((shot) => {
    const cut = `${fixed(Math.abs(shot.cut) * DEGREES, 0)}° cut`;
    const way = make('span', `${shot.ball} → ${placeInWords(shot.pocket)}`);
    const chance = make('b', `about ${percent(shot.chance)}`);
    return make('li', button([way, make('small', cut), chance], () => takeShot(shot)));
  }));
  element('no-shots').hidden = found.length > 0;
}

function takeShot({ ball, pocket, stroke }) {
  aim({ a: 0, b: 0, ...stroke }, null, { target: { ball, pocket } });
}

// Where a page without a stroke looks for one. Breaks: the cue at 6 to 7 m/s gives the ball 8 to 9 m/s,
// as amateurs do; places beside the middle of the first ball, in ball radii.
const BREAK = { speeds: [6.5, 7, 6], beside: [0, 0.3, -0.3, 0.15, -0.15] };
const NEAR_SHOTS = [0, 0.2, -0.2, 0.4, -0.4, 0.7, -0.7, 1, -1]; // ° from direct shots, against throw
const MOST_TRIED = 5; // direct shots
const TURN = 1.5; // ° from one stroke to the next, all round

/** The stroke of a page without one: the first one that succeeds; else the first one. */
function firstStroke(balls) {
  let first = null;
  for (const { stroke: wanted, target } of isRack(balls) ? breaks(balls) : likelyShots(balls)) {
    const elevation = Math.ceil(100 * DEGREES * wanted.elevation) / 100 / DEGREES;
    const azimuth = rounded(turned(wanted.azimuth) * DEGREES, 100) / DEGREES;
    const stroke = raised(balls, { ...wanted, azimuth, speed: rounded(wanted.speed, 100) }, elevation);
    const shot = tableFor(state).shoot(balls, stroke);
    if (data.scene.pockets.length ? shot.reaches(target) : isCarom(shot)) return stroke;
    first ??= stroke;
  }
  return first;
}

function* breaks(balls) {
  const [[x, y], [u, v]] = [balls.cue, nearestBall(balls)];
  for (const speed of BREAK.speeds) {
    for (const beside of BREAK.beside) {
      const azimuth = Math.atan2(v + beside * data.scene.radius - y, u - x);
      yield { stroke: withRoom(balls, { a: 0, b: 0, azimuth, speed }), target: {} };
    }
  }
}

/** Direct shots, the surest first, and near them; then strokes all round, the first at the nearest ball. */
function* likelyShots(balls) {
  const found = directShots(balls).slice(0, MOST_TRIED);
  for (const turn of NEAR_SHOTS) {
    for (const { ball, pocket, stroke } of found) {
      const azimuth = stroke.azimuth + turn / DEGREES;
      yield { stroke: { a: 0, b: 0, ...stroke, azimuth }, target: { ball, pocket } };
    }
  }
  const [[x, y], nearest] = [balls.cue, nearestBall(balls)];
  const ahead = nearest ? Math.atan2(nearest[1] - y, nearest[0] - x) : 0;
  for (let turn = 0; turn < (nearest ? 360 : TURN); turn += TURN) {
    yield { stroke: withRoom(balls, { a: 0, b: 0, azimuth: ahead + turn / DEGREES, speed: 4 }), target: {} };
  }
}

/** Whether the cue ball meets two balls, or all that there are, and the cue does not hit it again. */
function isCarom({ events, balls, cue }) {
  const meetings = events.filter(({ cause, balls: met }) => cause !== 'CUE' && met.length > 1 && met.includes('cue'));
  const met = new Set(meetings.flatMap((event) => event.balls)).add('cue');
  return met.size >= Math.min(Object.keys(balls).length, 3) && cue.double_hit === Infinity;
}

/** A stroke as low as clearance allows if the player errs. */
function withRoom(balls, stroke) {
  const { elevation } = raised(balls, { ...stroke, elevation: 0 }, 0);
  return { ...stroke, elevation: elevation + 3 * state.noise.elevation };
}

/** The place of the ball that is nearest to the cue ball; undefined if there is none. */
function nearestBall({ cue: [x, y], ...others }) {
  const far = ([u, v]) => Math.hypot(u - x, v - y);
  return Object.values(others).sort((a, b) => far(a) - far(b))[0];
}

// Where balls may lie, and the list of them.

const APART = 1e-5; // m between the surfaces of balls that are dragged against each other

/** The nearest place to a wish (x, y) where a ball can lie, or null. */
function freePlace(name, wish) {
  const [numbers] = data.scene.entries.play_tables.layout.numbers.values;
  const [x, y] = [Number(numbers.centre_half_length), Number(numbers.centre_half_width)];
  const onTable = ([u, v]) => [clamp(u, -x, x), clamp(v, -y, y)];
  const others = Object.entries(state.balls).filter(([other]) => other !== name).map(([, place]) => place);
  const least = 2 * data.scene.radius + APART;
  const overlapped = ([u, v]) => others.find(([s, t]) => Math.hypot(u - s, v - t) < least - APART / 2);
  let place = onTable(wish);
  for (let step = 0; step < 8; step++) {
    const other = overlapped(place);
    if (!other) return place;
    const [dx, dy] = [place[0] - other[0], place[1] - other[1]];
    const far = Math.hypot(dx, dy);
    const part = far > 0 ? least / far : 0;
    place = onTable(far > 0 ? [other[0] + part * dx, other[1] + part * dy] : [other[0] + least, other[1]]);
  }
  return null;
}

function moveBall(name, wish) {
  const place = freePlace(name, wish.map((x) => rounded(x, 1e4)));
  if (place) withBalls({ ...state.balls, [name]: place }, `place of ${name}`);
}

/** Let balls lie elsewhere; tries of a drill begin again. */
function withBalls(balls, kind) {
  aim({}, kind, { balls, ...(state.drill && { drill: { tries: 0, successes: 0 } }) });
}

/** A ball that is not on the table comes to the free place next to its middle. */
function addBall(name) {
  const step = data.scene.radius / 2;
  for (let i = 0; i < 400; i++) {
    const wish = [(i % 20) * step, Math.floor(i / 20) * step];
    const place = freePlace(name, wish);
    if (place) return withBalls({ ...state.balls, [name]: place });
  }
}

/** The balls where the shot leaves them; a cue ball that is gone lies on the head string. */
function goOn() {
  const left = Object.entries(shown.shot.balls).filter(([, { motion }]) => motion === 'REST');
  const balls = Object.fromEntries(left.map(([name, { position: [x, y] }]) => [name, [x, y]]));
  if (!Object.hasOwn(balls, 'cue')) balls.cue = inHand(balls);
  const stroke = firstStroke(balls);
  change({ balls, stroke, level: stroke.elevation, drill: null, target: null });
}

function inHand(others) {
  const x = data.table ? -data.table.size[0] / 4 : 0;
  for (let i = 0; ; i++) {
    const y = (i % 2 ? 1 : -1) * Math.ceil(i / 2) * 0.25 * data.scene.radius;
    const free = ([u, v]) => Math.hypot(u - x, v - y) >= 2 * data.scene.radius;
    if (Object.values(others).every(free)) return [x, y];
  }
}

function listBalls() {
  if (element('balls').contains(document.activeElement)) return; // who types there goes on
  element('balls').replaceChildren(...data.balls.map(({ name }) => {
    const place = state.balls[name];
    const label = make('span', ballInWords(name));
    if (!Object.hasOwn(state.balls, name)) return make('li', [label, button('Add', () => addBall(name))]);
    const boxes = place.map((_, axis) => field(`${ballInWords(name)}, ${'xy'[axis]}`, 'length', [-1, 1],
      () => state.balls[name]?.[axis] ?? 0,
      (value) => moveBall(name, state.balls[name].map((old, k) => (k === axis ? value : old)))));
    const { [name]: _, ...others } = state.balls;
    const remove = button('×', () => withBalls(others), { title: `Take ${name} off the table` });
    return make('li', [label, ...boxes, ...(name === 'cue' ? [] : [remove])]);
  }));
}

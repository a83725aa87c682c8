// The stroke under the hand: the tip on the face of the ball, as seen along the cue, and its numbers.

const HALF_TIP = 0.0065; // m, half the width of a usual tip
const FARTHEST = 0.9; // radii from the middle, to which the tip can be dragged
const NUDGE = 0.02; // ball radii by which an arrow key moves the tip; five times as far with shift
const CURVED = 1 + data.cue.tip_curvature; // the axis of the cue passes so many times as far out
const STROKE = [ // name, label, kind, range of the slider, what a box takes
  ['speed', 'speed', 'speed', [0.1, 10], [0.001, 100]],
  ['elevation', 'elevation', 'angle', [0, Math.PI / 2]],
  ['azimuth', 'direction', 'angle', [-Math.PI, Math.PI], [-2 * Math.PI, 2 * Math.PI]],
  ['a', 'side', 'offset', [-FARTHEST, FARTHEST], [-1, 1]],
  ['b', 'height', 'offset', [-FARTHEST, FARTHEST], [-1, 1]],
];

function fillStroke() {
  element('stroke').replaceChildren(...STROKE.map(([name, label, kind, range, allowed]) => field(
    label, kind, range, () => state.stroke[name],
    (value) => aim({ [name]: name === 'azimuth' ? turned(value) : value }, name), allowed,
  )));
  element('axis').setAttribute('r', HALF_TIP / data.scene.radius);
  const face = element('face');
  let box = null; // of the face, as it was touched
  const put = ({ clientX, clientY }) => {
    const size = 2.24 / box.width; // of its viewBox
    putTip((clientX - box.left) * size - 1.12, 1.12 - (clientY - box.top) * size);
  };
  face.addEventListener('pointerdown', (event) => {
    face.setPointerCapture(event.pointerId);
    box = face.getBoundingClientRect();
    put(event);
  });
  face.addEventListener('pointermove', (event) => face.hasPointerCapture(event.pointerId) && put(event));
  face.addEventListener('pointerup', endOfDrag);
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  face.addEventListener('keydown', (event) => {
    if (!ways[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    const step = CURVED * NUDGE * (event.shiftKey ? 5 : 1);
    const [x, y] = ways[event.key];
    putTip(state.stroke.a * CURVED + x * step, state.stroke.b * CURVED + y * step);
  });
  face.addEventListener('keyup', endOfDrag);
}

/** Move the axis of the cue to a place on the face of the ball [ball radii], or as far out as it goes. */
function putTip(x, y) {
  const part = Math.min(1, FARTHEST / Math.max(Math.hypot(x, y), 1e-9)) / CURVED;
  aim({ a: rounded(x * part, 100), b: rounded(y * part, 100) }, 'tip');
}

const rounded = (value, parts) => Math.round(value * parts) / parts;

/** An angle from -pi to pi. */
const turned = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

function showStroke() {
  const { a, b, elevation } = state.stroke;
  for (const [id, factor] of [['axis', CURVED], ['touch', 1]]) {
    element(id).setAttribute('cx', a * factor);
    element(id).setAttribute('cy', -b * factor);
  }
  element('face').setAttribute('aria-label', 'Tip on the face of the cue ball: '
    + `${fixed(a, 2)} R to the right, ${fixed(b, 2)} R up. Arrow keys move it.`);
  const isRaised = elevation > state.level + 1e-9;
  update(element('raised'), { textContent: isRaised ? 'The cue is raised: something is in its way.' : '' });
}

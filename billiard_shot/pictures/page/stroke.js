// The stroke under the hand: the tip on the face of the ball, as seen along the cue, and its numbers.

const HALF_TIP = 0.0065; // m, half the width of a usual tip
const FARTHEST = 0.9; // radii from the middle, to which the tip can be dragged
const CURVED = 1 + data.cue.tip_curvature; // the axis of the cue passes so many times as far out
const STROKE = [ // name, label, kind, range
  ['speed', 'speed', 'speed', [0.1, 10]],
  ['elevation', 'elevation', 'angle', [0, Math.PI / 2]],
  ['azimuth', 'direction', 'angle', [-Math.PI, Math.PI]],
  ['a', 'side', 'offset', [-FARTHEST, FARTHEST]],
  ['b', 'height', 'offset', [-FARTHEST, FARTHEST]],
];
const SMALLEST = 0.001; // m/s

function fillStroke() {
  const limited = (name, value) => (name === 'speed' ? clamp(value, SMALLEST, 1e3)
    : name === 'elevation' ? clamp(value, 0, Math.PI / 2) : name === 'azimuth' ? turned(value) : value);
  element('stroke').replaceChildren(...STROKE.map(([name, label, kind, range]) => field(
    label, kind, range, () => state.stroke[name],
    (value) => aim({ [name]: limited(name, value) }, name),
  )));
  element('axis').setAttribute('r', HALF_TIP / data.scene.radius);
  const face = element('face');
  const put = ({ clientX, clientY }) => {
    const { left, top, width } = face.getBoundingClientRect();
    const size = 2.24 / width; // of its viewBox
    const [x, y] = [(clientX - left) * size - 1.12, 1.12 - (clientY - top) * size];
    const part = Math.min(1, FARTHEST / Math.max(Math.hypot(x, y), 1e-9)) / CURVED;
    aim({ a: rounded(x * part, 100), b: rounded(y * part, 100) }, 'tip');
  };
  face.addEventListener('pointerdown', (event) => {
    face.setPointerCapture(event.pointerId);
    put(event);
  });
  face.addEventListener('pointermove', (event) => face.hasPointerCapture(event.pointerId) && put(event));
  face.addEventListener('pointerup', endOfDrag);
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
  const isRaised = elevation > state.level + 1e-9;
  update(element('raised'), { textContent: isRaised ? 'The cue is raised: something is in its way.' : '' });
}

// Mouse and fingers on the table: they move balls, turn the cue, and turn, move and zoom the view.

const CLICK = 4; // pixels that the pointer may move in a click
const NEAR_CUE = 12; // pixels
const NEAR_RING = 22;
const RING = 1.3; // ball radii: the ring with which the cue is aimed
const AHEAD = 0.6; // m from the cue ball to the ring, if the cue ball meets no other

const editable = () => time <= 0;

/** Where the ring is: around the ghost ball, or ahead of the cue ball. */
function ringPlace() {
  const met = firstContact(shown);
  if (met && !shown.refused) return stateAt(shown.balls[0].segments, met.time).position;
  const { azimuth } = state.stroke;
  return add([...state.balls.cue, data.scene.radius], [Math.cos(azimuth), Math.sin(azimuth), 0], AHEAD);
}

/** What is under the pointer: the ring, the number of a ball, the cue, or nothing. */
function thingAt(x, y) {
  if (!editable()) return null;
  const view = cameraNow();
  const distance = (place) => {
    const [px, py] = project(place, view);
    return Math.hypot(px - x, py - y);
  };
  const number = ballAt(x, y);
  const ring = distance(ringPlace());
  if (ring < NEAR_RING && (number === null || number === 0 || ring < 8)) return 'ring';
  if (number !== null) return number;
  const cue = shownCue(shown, time);
  for (let part = 0; part < 1; part += 0.02) {
    if (distance(add(cue.tip, cue.direction, -part * data.cue.length)) < NEAR_CUE) return 'cue';
  }
  return null;
}

/** Drag a thing to a place on the canvas. */
function drag(thing, grip, x, y) {
  const [px, py] = placeAt(x, y, data.scene.radius);
  if (typeof thing === 'number') {
    moveBall(data.balls[thing].name, [px + grip[0], py + grip[1]]);
    return;
  }
  const [cx, cy] = state.balls.cue;
  const [dx, dy] = thing === 'ring' ? [px - cx, py - cy] : [cx - px, cy - py];
  if (Math.hypot(dx, dy) < data.scene.radius) return;
  const azimuth = turned(Math.atan2(dy, dx) + grip[0]);
  aim({ azimuth: rounded(azimuth * DEGREES, 100) / DEGREES }, 'azimuth');
}

/** What a drag keeps: the place of a ball, or the angle of the cue, as seen from where it was gripped. */
function gripOf(thing, x, y) {
  const [px, py] = placeAt(x, y, data.scene.radius);
  if (typeof thing === 'number') {
    const [bx, by] = state.balls[data.balls[thing].name];
    return [bx - px, by - py];
  }
  const [cx, cy] = state.balls.cue;
  const here = thing === 'ring' ? Math.atan2(py - cy, px - cx) : Math.atan2(cy - py, cx - px);
  return [turned(state.stroke.azimuth - here)];
}

function listenToPointer() {
  const canvas = element('canvas');
  const fingers = new Map();
  let pressed = null; // the press that is a click, unless the pointer moves
  let held = null; // what is dragged
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
    pressed = fingers.size === 1 && event.button === 0 ? event : null;
    const thing = pressed && !event.shiftKey ? thingAt(event.clientX, event.clientY) : null;
    held = thing === null ? null : { thing, grip: gripOf(thing, event.clientX, event.clientY) };
  });
  canvas.addEventListener('pointerup', (event) => {
    fingers.delete(event.pointerId);
    const [x, y] = [event.clientX, event.clientY];
    if (pressed && !takeClick(x, y)) follow(ballAt(x, y));
    [pressed, held] = [null, null];
    endOfDrag();
  });
  canvas.addEventListener('pointercancel', (event) => {
    fingers.delete(event.pointerId);
    held = null;
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      const thing = fingers.size ? null : thingAt(event.clientX, event.clientY);
      canvas.style.cursor = thing === null ? '' : typeof thing === 'number' ? 'move' : 'crosshair';
      return;
    }
    if (pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < CLICK) return;
    pressed = null;
    fingers.set(event.pointerId, event);
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    const other = [...fingers.values()].find(({ pointerId }) => pointerId !== event.pointerId);
    if (other) {
      held = null;
      const gap = ({ clientX, clientY }) => Math.hypot(clientX - other.clientX, clientY - other.clientY);
      zoom(gap(before) / Math.max(gap(event), 1));
      pan(dx / 2, dy / 2); // each of two fingers moves their middle by a half
    } else if (held) drag(held.thing, held.grip, event.clientX, event.clientY);
    else if (event.shiftKey || event.buttons & 6) pan(dx, dy);
    else turn(dx, dy);
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoom(Math.exp(0.0012 * event.deltaY));
  }, { passive: false });
  new ResizeObserver(fitAgain).observe(canvas);
}

function fitAgain() {
  if (kept) look(kept);
  else draw();
}

function turn(dx, dy) {
  kept = null;
  camera.azimuth -= 0.006 * dx;
  camera.elevation = clamp(camera.elevation + 0.006 * dy, 0, Math.PI / 2);
  draw();
}

function zoom(factor) {
  kept = null;
  camera.distance = clamp(camera.distance * factor, 0.12, 60);
  draw();
}

function pan(dx, dy) {
  follow(null);
  kept = null;
  const size = 2 * Math.tan(FIELD / 2) * camera.distance / element('canvas').clientHeight;
  const [c, s] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth)];
  const lift = Math.max(Math.sin(camera.elevation), 0.3);
  camera.target = add(camera.target,
    [size * (dx * s - dy * c / lift), size * (-dx * c - dy * s / lift), 0]);
  draw();
}

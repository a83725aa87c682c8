// From where the table is seen.

const FLOOR_SIZE = 60; // m of an endless cloth to each side of its origin

const camera = { azimuth: 0, elevation: 0, distance: 1, target: [0, 0, 0] };
let kept = 'corner'; // the view that is fitted again if the free area changes; null: the user's own
const FIELD = 0.62; // rad, its angle of view from below to above
const NEAR_CLOTH = 0.02; // m, the least height of the eye above the cloth, or above the frame

// What has to be in view: corners of the table, or of all that moves on an endless cloth.
function corners() {
  let [x, y] = [0, 0];
  let half = data.table?.frame;
  if (!half) {
    const points = shown.balls.filter(({ there }) => there).flatMap(({ segments }) => segments);
    const ranges = [0, 1].map((axis) => points.reduce(([low, high], { position }) =>
      [Math.min(low, position[axis]), Math.max(high, position[axis])], [Infinity, -Infinity]));
    [x, y] = ranges.map(([low, high]) => (low + high) / 2);
    half = ranges.map(([low, high]) => Math.max((high - low) / 2, 0.25) + 0.15);
  }
  return [-1, 1].flatMap((i) => [-1, 1].map((j) => [x + i * half[0], y + j * half[1], 0]));
}

// A narrow window shows the table along its length.
const OVERVIEWS = {
  corner: { wide: [-1.8, 0.78], narrow: [Math.PI + 0.12, 1.1] },
  top: { wide: [-Math.PI / 2, Math.PI / 2], narrow: [Math.PI, Math.PI / 2] },
};

function look(view) {
  const { left, right, top, bottom } = freeArea();
  if (view === 'player') {
    const [dx, dy, dz] = shown.cue.direction;
    const level = Math.hypot(dx, dy);
    const ahead = level > 1e-6 ? [dx / level, dy / level, 0] : [0, 0, 0];
    follow(null);
    Object.assign(camera, {
      azimuth: level > 1e-6 ? Math.atan2(-dy, -dx) : Math.PI, distance: 1.9,
      elevation: clamp(Math.asin(-dz) + 0.2, 0.28, 1.2),
      target: add(stateAt(shown.balls[0].segments, 0).position, ahead, 0.35),
    });
  } else {
    const [azimuth, elevation] = OVERVIEWS[view][right - left < bottom - top ? 'narrow' : 'wide'];
    const [first, , , last] = corners();
    Object.assign(camera, { azimuth, elevation, target: scale(add(first, last), 0.5) });
    camera.distance = followed === null ? fitting() : CLOSE;
  }
  kept = view;
  draw();
}

// The least distance from which all corners are seen.
function fitting() {
  const [{ left, right, top, bottom }, edges] = [freeArea(), corners()];
  for (camera.distance = 0.6; camera.distance < 60; camera.distance *= 1.02) {
    const view = cameraNow();
    const seen = edges.map((corner) => project(corner, view));
    if (seen.every(([x, y]) => x > left + 20 && x < right - 20 && y > top + 20 && y < bottom - 20)) break;
  }
  return camera.distance;
}

// ---- the ball that the camera follows ----

const CLOSE = 1.8; // m, the largest distance from a ball that is followed
let followed = null; // its number

function follow(number) {
  if (followed !== null && number === null) camera.target = onCloth(placeOf(followed));
  if (number !== null) camera.distance = Math.min(camera.distance, CLOSE);
  if (number !== followed) kept = null;
  followed = number;
  element('follow').value = number === null ? '' : data.balls[number].name;
  draw();
}

const placeOf = (number) => stateAt(shown.balls[number].segments, time).position;
const onCloth = ([x, y, z]) => [x, y, Math.max(z, 0)];

// The number of the ball at a place on the canvas, or near it [pixels]; null: there is none.
function ballAt(x, y) {
  const view = cameraNow();
  const near = data.balls.map((ball, number) => ({ number, look: shownBall(shown, number, time) }))
    .filter(({ look }) => look.opacity > 0.5)
    .map(({ number, look: { place } }) => {
      const [px, py] = project(place, view);
      const [rx, ry] = project(add(place, view.up, data.scene.radius), view);
      return { number, distance: Math.hypot(px - x, py - y) / Math.max(Math.hypot(rx - px, ry - py), 12) };
    })
    .reduce((a, b) => (a.distance < b.distance ? a : b), { number: null, distance: 1 });
  return near.number;
}

// ---- from places to pixels ----

// The part of the canvas that the panels leave free [pixels].
function freeArea() {
  const { innerWidth: width, innerHeight: height } = window;
  const [panel, bar, views] = ['aside', 'footer', '#views'].map(
    (each) => document.querySelector(each).getBoundingClientRect());
  const isBelow = panel.width > 0.7 * width;
  return {
    left: 0, top: views.bottom < height / 2 ? views.bottom : 0,
    right: panel.width && !isBelow ? panel.left - 8 : width,
    bottom: (isBelow ? panel.top : bar.top) - 4,
  };
}

// The target is in the middle of the free area.
function cameraNow() {
  const canvas = element('canvas');
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const { azimuth, distance } = camera;
  const target = followed === null ? camera.target : onCloth(placeOf(followed));
  const toEye = (elevation) => [Math.cos(elevation) * Math.cos(azimuth),
    Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)];
  const [x, y] = add(target, toEye(camera.elevation), distance);
  const outside = data.table && data.table.size.some((size, i) => Math.abs([x, y][i]) > size / 2);
  const least = NEAR_CLOTH + (outside ? data.table.height : 0);
  const elevation = Math.max(camera.elevation, Math.asin(clamp((least - target[2]) / distance, -1, 1)));
  const eye = add(target, toEye(elevation), distance);
  const up = toEye(elevation + Math.PI / 2);
  const projection = perspective(FIELD, width / height, 0.01 * distance + 0.005, 12 * distance + 5);
  const { left, right, top, bottom } = freeArea();
  projection[8] = 1 - (left + right) / width;
  projection[9] = (top + bottom) / height - 1;
  return {
    matrix: multiply(projection, lookAt(eye, target, up)), eye, target, distance, up, width, height,
  };
}

// Where a place [m] is on the canvas [pixels], and its depth: below 0, it is behind the camera.
function project(place, { matrix, width, height } = cameraNow()) {
  const [x, y, , w] = [0, 1, 2, 3].map((row) => matrix[row] * place[0] + matrix[4 + row] * place[1]
    + matrix[8 + row] * place[2] + matrix[12 + row]);
  return [(0.5 + 0.5 * x / w) * width, (0.5 - 0.5 * y / w) * height, w];
}

/** The place at a height above the cloth that is seen at a place on the canvas [pixels]. */
function placeAt(x, y, height) {
  const { eye, target, up, distance } = cameraNow();
  const ahead = scale(add(target, eye, -1), 1 / distance);
  const canvas = element('canvas');
  const { left, right, top, bottom } = freeArea();
  const size = 2 * Math.tan(FIELD / 2) / canvas.clientHeight; // of a pixel, at the distance 1
  const [dx, dy] = [size * (x - (left + right) / 2), size * ((top + bottom) / 2 - y)];
  const way = add(add(ahead, cross(ahead, up), dx), up, dy);
  return add(eye, way, (height - eye[2]) / Math.min(way[2], -1e-6));
}

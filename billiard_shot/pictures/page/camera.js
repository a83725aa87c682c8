// From where the table is seen.

const element = (id) => document.getElementById(id);
const centre = data.balls.find(({ name }) => name === 'cue') || data.balls[0];
const points = data.trails.flatMap(({ points: line }) => line);
const range = (axis) => minmax([
  ...data.balls.map((ball) => ball.segments[0][2 + axis]),
  ...points.filter((_, i) => i % 3 === axis),
]);
data.middle = [0, 1].map((axis) => (range(axis)[0] + range(axis)[1]) / 2);
data.half = [0, 1].map((axis) => Math.max((range(axis)[1] - range(axis)[0]) / 2, 0.25) + 0.15);
data.extent = Math.max(3, ...[0, 1].map((axis) => range(axis)[1] - range(axis)[0])) + 3;

function minmax(values) { // Math.min(...values) has a limit
  return values.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)],
    [Infinity, -Infinity]);
}

const camera = { azimuth: 0, elevation: 0, distance: 1, target: [0, 0, 0] };
const FIELD = 0.62; // rad, its angle of view from below to above

// What has to be in view: corners of the table, or of all that moves on an endless cloth.
const corners = [-1, 1].flatMap((i) => [-1, 1].map((j) => (data.table
  ? [i * data.table.frame[0], j * data.table.frame[1], 0]
  : [data.middle[0] + i * data.half[0], data.middle[1] + j * data.half[1], 0])));

function look(view) {
  const [dx, dy, dz] = data.cue.direction;
  const level = Math.hypot(dx, dy);
  const middle = data.table ? [0, 0, 0] : [...data.middle, 0];
  if (view === 'player') {
    const ahead = level > 1e-6 ? [dx / level, dy / level, 0] : [0, 0, 0];
    Object.assign(camera, {
      azimuth: level > 1e-6 ? Math.atan2(-dy, -dx) : Math.PI, distance: 1.9,
      elevation: clamp(Math.asin(-dz) + 0.2, 0.28, 1.2),
      target: add(stateOf(centre, 0).position, ahead, 0.35),
    });
  } else {
    const angles = view === 'top' ? [-Math.PI / 2, Math.PI / 2] : [-1.95, 0.78];
    Object.assign(camera, { azimuth: angles[0], elevation: angles[1], target: middle });
    camera.distance = fitting(element('follow').checked);
  }
  draw();
}

// The least distance from which all corners are seen; of something to follow, its surroundings.
function fitting(follows) {
  if (follows) return 1.8;
  const { clientWidth, clientHeight } = element('canvas');
  const room = [20, 20, clientWidth - panelWidth() - 20, clientHeight - 84];
  for (camera.distance = 0.6; camera.distance < 60; camera.distance *= 1.02) {
    const seen = corners.map(project);
    if (seen.every(([x, y]) => x > room[0] && x < room[2] && y > room[1] && y < room[3])) break;
  }
  return camera.distance;
}

const panelWidth = () => {
  const { offsetWidth } = document.querySelector('aside');
  return offsetWidth ? offsetWidth + 20 : 0;
};

// The side panel covers a part of the window: the middle of the rest is where the target is.
function cameraNow() {
  const canvas = element('canvas');
  const { azimuth, elevation, distance } = camera;
  const target = element('follow').checked ? stateOf(centre, time).position : camera.target;
  const c = Math.cos(elevation);
  const eye = add(target, [c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(elevation)], distance);
  const up = [-Math.sin(elevation) * Math.cos(azimuth), -Math.sin(elevation) * Math.sin(azimuth), c];
  const width = canvas.clientWidth;
  const projection = perspective(FIELD, width / canvas.clientHeight, 0.01 * distance + 0.005, 12 * distance + 5);
  projection[8] = panelWidth() / width; // moves the picture to the left by half the panel
  projection[9] = -60 / canvas.clientHeight;
  return { matrix: multiply(projection, lookAt(eye, target, up)), eye, target, distance };
}

// Where a place [m] is on the canvas, in pixels of the page.
function project(place) {
  const { matrix } = cameraNow();
  const [x, y, , w] = [0, 1, 2, 3].map((row) => matrix[row] * place[0] + matrix[4 + row] * place[1]
    + matrix[8 + row] * place[2] + matrix[12 + row]);
  const canvas = element('canvas');
  return [(0.5 + 0.5 * x / w) * canvas.clientWidth, (0.5 - 0.5 * y / w) * canvas.clientHeight];
}

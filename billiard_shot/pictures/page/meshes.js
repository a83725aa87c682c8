// Triangles of what does not change: 10 numbers a corner: place, normal, colour, material.

const PLAIN = 0;
const CLOTH = 1;
const WOOD = 2;
const FLOOR = 3; // a cloth without end: fades out
const COLOURS = {
  cloth: colourOf('#1c7a55'), cushion: colourOf('#176548'), wood: colourOf('#7a4a28'),
  pocket: colourOf('#0c0c0d'), sight: colourOf('#efe6cf'),
};
const ROUND = 0.07; // m, of the corners of the frame
const DROP = 0.11; // m that pockets and the frame reach below the cloth

class Mesh {
  constructor() {
    this.numbers = [];
  }

  triangle(a, b, c, normals, colour, material = PLAIN) {
    [a, b, c].forEach((place, i) => {
      this.numbers.push(...place, ...(normals[i] || normals[0]), ...colour, material);
    });
  }

  quad(a, b, c, d, normal, colour, material = PLAIN) {
    this.triangle(a, b, c, [normal], colour, material);
    this.triangle(a, c, d, [normal], colour, material);
  }

  // A flat convex polygon of points [x, y] at a height.
  flat(points, z, colour, material) {
    for (let i = 1; i + 1 < points.length; i++) {
      this.triangle([...points[0], z], [...points[i], z], [...points[i + 1], z], [[0, 0, 1]],
        colour, material);
    }
  }

  // The walls between two lines of as many points [x, y, z].
  walls(upper, lower, colour, material = PLAIN) {
    for (let i = 0; i + 1 < upper.length; i++) {
      const along = add(upper[i + 1], upper[i], -1);
      const across = cross(along, add(upper[i], lower[i], -1));
      if (Math.hypot(...across) < 1e-12) continue;
      this.quad(upper[i], upper[i + 1], lower[i + 1], lower[i], unit(across), colour, material);
    }
  }
}

// Corners of a rectangle with rounded corners, around it once, the first one twice.
function roundedRectangle([x, y], radius, steps) {
  const points = [];
  for (let corner = 0; corner < 4; corner++) {
    const sx = corner === 0 || corner === 3 ? 1 : -1;
    const sy = corner < 2 ? 1 : -1;
    for (let i = 0; i <= steps; i++) {
      const angle = (corner + i / steps) * Math.PI / 2;
      points.push([sx * (x - radius) + radius * Math.cos(angle),
        sy * (y - radius) + radius * Math.sin(angle)]);
    }
  }
  return [...points, points[0]];
}

function tableMesh(table) {
  const mesh = new Mesh();
  const [bx, by] = table.back;
  const top = table.height;
  mesh.flat([[-bx, -by], [bx, -by], [bx, by], [-bx, by]], 0, COLOURS.cloth, CLOTH);
  for (const cushion of table.cushions) cushionMesh(mesh, cushion, top);
  frameMesh(mesh, table, top);
  mesh.flat(roundedRectangle(table.frame, ROUND, 10), -DROP, COLOURS.pocket); // nothing shines through
  for (const [x, y, radius] of table.holes) pocketMesh(mesh, x, y, radius, bx, by, top);
  sightsMesh(mesh, table, top);
  return mesh.numbers;
}

// The nose overhangs: below it the cushion recedes.
function cushionMesh(mesh, points, top) {
  const middle = scale(points.reduce((sum, [x, y]) => add(sum, [x, y, 0]), [0, 0, 0]),
    1 / points.length);
  const turned = dot(cross(add([...points[1], 0], [...points[0], 0], -1),
    add(middle, [...points[0], 0], -1)), [0, 0, 1]) < 0;
  const line = turned ? [...points].reverse() : points;
  mesh.flat(line, top, COLOURS.cushion, CLOTH);
  const inward = line.map((point, i) => {
    const before = line[Math.max(i - 1, 0)];
    const after = line[Math.min(i + 1, line.length - 1)];
    return unit([before[1] - after[1], after[0] - before[0], 0]);
  });
  const upper = line.map((point) => [...point, top]);
  const nose = line.map((point) => [...point, 0.82 * top]);
  const foot = line.map((point, i) => add([...point, 0], inward[i], 0.35 * top));
  mesh.walls(nose, upper, COLOURS.cushion, CLOTH);
  mesh.walls(foot, nose, COLOURS.cushion, CLOTH);
}

function frameMesh(mesh, table, top) {
  const [bx, by] = table.back;
  const outer = roundedRectangle(table.frame, ROUND, 10);
  const inner = outer.map(([x, y]) => [clamp(x, -bx, bx), clamp(y, -by, by)]);
  for (let i = 0; i + 1 < outer.length; i++) {
    mesh.quad([...inner[i], top], [...outer[i], top], [...outer[i + 1], top], [...inner[i + 1], top],
      [0, 0, 1], COLOURS.wood, WOOD);
  }
  const at = (points, z) => points.map((point) => [...point, z]);
  mesh.walls(at(outer, -DROP), at(outer, top), COLOURS.wood, WOOD);
}

function pocketMesh(mesh, x, y, radius, bx, by, top) {
  const steps = 40;
  const rim = [];
  const floor = [];
  const edge = [];
  for (let i = 0; i <= steps; i++) {
    const angle = 2 * Math.PI * i / steps;
    const px = x + radius * Math.cos(angle);
    const py = y + radius * Math.sin(angle);
    const outside = Math.abs(px) > bx || Math.abs(py) > by;
    rim.push([px, py, outside ? top : 0]);
    floor.push([px, py, -DROP]);
    edge.push([px, py]);
  }
  mesh.walls(rim, floor, COLOURS.pocket);
  mesh.flat(edge.slice(0, -1), -DROP, COLOURS.pocket);
}

// Eighths of the length and quarters of the width are marked on the frame.
function sightsMesh(mesh, table, top) {
  const [length, width] = table.size;
  const [x, y] = [0, 1].map((i) => 0.5 * (table.back[i] + table.frame[i]));
  const z = top + 5e-4;
  const diamond = (px, py) => mesh.flat(
    [[px - 0.008, py], [px, py - 0.008], [px + 0.008, py], [px, py + 0.008]], z, COLOURS.sight, PLAIN);
  for (let i = -3; i <= 3; i++) {
    const free = table.holes.every(([hx]) => Math.abs(hx - i * length / 8) > 0.1);
    if (free) for (const side of [-1, 1]) diamond(i * length / 8, side * y);
  }
  for (let i = -1; i <= 1; i++) for (const side of [-1, 1]) diamond(side * x, i * width / 4);
}

function floorMesh([x, y], size) {
  const mesh = new Mesh();
  mesh.flat([[x - size, y - size], [x + size, y - size], [x + size, y + size], [x - size, y + size]],
    0, COLOURS.cloth, FLOOR);
  return mesh.numbers;
}

// A cue along -x, its tip at the origin.
function cueMesh(length) {
  const mesh = new Mesh();
  const maple = colourOf('#d9b37c');
  const dark = colourOf('#33201a');
  const rings = [ // from the tip, radius, colour from here on
    [0, 0.0035, colourOf('#3d6f9e')], [0.002, 0.0062, colourOf('#3d6f9e')],
    [0.008, 0.0065, colourOf('#f4efe2')], [0.033, 0.0066, maple],
    [0.5 * length, 0.0105, dark], [0.52 * length, 0.0106, colourOf('#c9a24b')],
    [0.53 * length, 0.0107, dark], [length, 0.0145, dark], [length, 0, dark],
  ];
  const steps = 24;
  for (let i = 0; i + 1 < rings.length; i++) {
    const [[a, ra, colour], [b, rb]] = [rings[i], rings[i + 1]];
    for (let k = 0; k < steps; k++) {
      const [p, q] = [k, k + 1].map((n) => [Math.cos(2 * Math.PI * n / steps),
        Math.sin(2 * Math.PI * n / steps)]);
      const corners = [[a, ra, p], [a, ra, q], [b, rb, q], [b, rb, p]].map(
        ([x, r, [c, s]]) => [-x, r * c, r * s]);
      const slope = (rb - ra) / Math.hypot(rb - ra, b - a || 1e-9);
      const normal = ([c, s]) => unit([slope, c, s]);
      const n = [p, q, q, p].map(normal);
      mesh.triangle(corners[0], corners[1], corners[2], [n[0], n[1], n[2]], colour);
      mesh.triangle(corners[0], corners[2], corners[3], [n[0], n[2], n[3]], colour);
    }
  }
  return mesh.numbers;
}

// Lines as points: place, how far along [m], and the pattern of the line that ends there; -1: a line
// begins there.
const PATTERNS = { ROLL: 0, SLIDE: 1, FLIGHT: 2 };
const POINT = 5; // numbers of a point

function pointsOfLines(lines, lift) {
  const numbers = new Float32Array(POINT * lines.reduce((sum, { points }) => sum + points.length / 3, 0));
  let at = 0;
  for (const { points, motion } of lines) {
    let along = 0;
    for (let i = 0; i < points.length; i += 3) {
      const by = (axis) => (i ? points[i + axis] - points[i + axis - 3] : 0);
      along += Math.hypot(by(0), by(1), by(2));
      numbers[at++] = points[i];
      numbers[at++] = points[i + 1];
      numbers[at++] = points[i + 2] + lift;
      numbers[at++] = along;
      numbers[at++] = i ? PATTERNS[motion] : -1;
    }
  }
  return numbers;
}

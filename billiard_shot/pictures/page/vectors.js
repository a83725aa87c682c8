// Vectors are arrays [x, y, z]; quaternions [x, y, z, w]; matrices 16 numbers, column by column.

const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];
const unit = (a) => scale(a, 1 / Math.hypot(...a));
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

function multiply(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++) {
    for (let j = 0; j < 4; j++) {
      for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
    }
  }
  return c;
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  const range = 1 / (near - far);
  return new Float32Array([
    f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) * range, -1, 0, 0, 2 * near * far * range, 0,
  ]);
}

function lookAt(eye, target, up) {
  const z = unit(add(eye, target, -1));
  const x = unit(cross(up, z));
  const y = cross(z, x);
  return new Float32Array([
    x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1,
  ]);
}

// The rotation matrix of a quaternion, with a place to move to.
function pose([x, y, z, w], place) {
  return new Float32Array([
    1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0,
    2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0,
    2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0,
    ...place, 1,
  ]);
}

// From one orientation to the next, at an even rate.
function slerp(a, b, part) {
  let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = Math.sign(cosine) || 1;
  cosine = Math.min(Math.abs(cosine), 1);
  const angle = Math.acos(cosine);
  const sine = Math.sin(angle);
  const p = sine > 1e-4 ? Math.sin((1 - part) * angle) / sine : 1 - part;
  const q = sign * (sine > 1e-4 ? Math.sin(part * angle) / sine : part);
  return a.map((value, i) => p * value + q * b[i]);
}

// How many of some numbers, in order, are at most x.
function countUpTo(x, count, number) {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (number(middle) <= x) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Colour #rrggbb as three numbers from 0 to 1: as it is shown, and linear in light.
const shadeOf = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
const colourOf = (text) => shadeOf(text).map((part) => part ** 2.2);

/** Turn about a vector by its length [rad], as a quaternion. */
function rotation(vector) {
  const angle = Math.hypot(...vector);
  const part = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return [...scale(vector, part), Math.cos(angle / 2)];
}

/** Turn by the quaternion b, then by a. */
const product = (a, b) => [
  ...add(add(scale(b, a[3]), scale(a, b[3])), cross(a, b)), a[3] * b[3] - dot(a, b),
];

// Numbers in the unit of the reader; those of the state are in SI units and radians.

const DEGREES = 180 / Math.PI;
const INCH = 0.0254; // m
const UNITS = { // name, how many make one SI unit, digits after the point
  si: { speed: ['m/s', 1, 2], length: ['m', 1, 3], small: ['mm', 1e3, 0] },
  us: { speed: ['mph', 1 / 0.44704, 2], length: ['in', 1 / INCH, 2], small: ['in', 1 / INCH, 2] },
};
const OTHERS = { angle: ['°', DEGREES, 2], offset: ['R', 1, 2] }; // R: radii of the ball
const unitOf = (kind) => UNITS[state.units][kind] ?? OTHERS[kind] ?? [kind, 1, 4];

/** Write a number with its unit. */
function inUnits(value, kind) {
  const [name, size, digits] = unitOf(kind);
  return `${fixed(value * size, digits)}${name === '°' ? '' : ' '}${name}`;
}

const fields = []; // `root` of each in the page, and how to `show` its number again

/**
 * Make a slider and a box for a number. `range` is what the slider offers, `get` and `put` read and
 * write the number.
 */
function field(label, kind, range, get, put) {
  const [slider, box] = ['range', 'number'].map((type) => make('input', [], { type }));
  const name = make('small', '');
  for (const input of [slider, box]) {
    input.setAttribute('aria-label', label);
    input.addEventListener('input', () => {
      const value = input.valueAsNumber / unitOf(kind)[1];
      if (Number.isFinite(value)) put(value);
    });
    input.addEventListener('change', endOfDrag);
  }
  const show = () => {
    const [unit, size, digits] = unitOf(kind);
    const value = get();
    const [low, high] = [Math.min(range[0], value), Math.max(range[1], value)];
    const step = 10 ** -digits;
    update(slider, { min: low * size, max: high * size, step: 'any', value: value * size });
    if (document.activeElement !== box) {
      update(box, { step, value: Number((value * size).toFixed(digits + 1)) });
    }
    update(name, { textContent: unit });
  };
  const root = make('label', [make('span', label), slider, box, name], { className: 'field' });
  fields.push({ root, show });
  return root;
}

// Numbers in the unit of the reader; those of the state are in SI units and radians.

const DEGREES = 180 / Math.PI;
const INCH = 0.0254; // m
const UNITS = { // name, how many make one SI unit, digits after the point
  si: { speed: ['m/s', 1, 2], length: ['m', 1, 3], small: ['mm', 1e3, 0] },
  us: { speed: ['mph', 1 / 0.44704, 2], length: ['in', 1 / INCH, 2], small: ['in', 1 / INCH, 2] },
};
const OTHERS = { angle: ['°', DEGREES, 2], offset: ['R', 1, 3], 1: ['', 1, 4] }; // R: radii of the ball
const unitOf = (kind) => UNITS[state.units][kind] ?? OTHERS[kind] ?? [kind, 1, 4];

/** Write a number with its unit. */
function inUnits(value, kind) {
  const [name, size, digits] = unitOf(kind);
  return `${fixed(value * size, digits)}${name === '°' ? '' : ' '}${name}`;
}

const fields = []; // `root` of each in the page, and how to `show` its number again

/**
 * Make a slider, which offers a range, and a box, which takes what is allowed; `get` and `put` read and
 * write the number. What is shown is played: a slider rounds, a box refuses what is not allowed.
 */
function field(label, kind, range, get, put, allowed = range) {
  const [slider, box] = ['range', 'number'].map((type) => make('input', [], { type }));
  const name = make('small', '');
  const shortened = (value) => Number((value * unitOf(kind)[1]).toPrecision(6));
  const showNumber = () => update(box, { value: shortened(get()), ariaInvalid: false });
  const show = () => {
    const [unit, size, digits] = unitOf(kind);
    const value = get();
    const [low, high] = [Math.min(range[0], value), Math.max(range[1], value)];
    update(slider, { min: low * size, max: high * size, step: 'any', value: value * size });
    update(box, { step: 10 ** -digits });
    update(name, { textContent: unit });
    if (document.activeElement !== box) showNumber();
  };
  slider.addEventListener('input', () => {
    const [, size, digits] = unitOf(kind);
    put(clamp(rounded(slider.valueAsNumber, 10 ** digits) / size, ...allowed));
  });
  box.addEventListener('input', () => {
    const [unit, size] = unitOf(kind);
    const value = box.valueAsNumber / size;
    const isAllowed = value >= allowed[0] && value <= allowed[1];
    if (isAllowed) put(value);
    else giveHint(`${label} must be ${allowed.map(shortened).join(' to ')}, got ${box.value} (${unit})`);
    update(box, { ariaInvalid: !isAllowed });
  });
  box.addEventListener('change', showNumber);
  for (const input of [slider, box]) {
    input.setAttribute('aria-label', label);
    input.addEventListener('change', endOfDrag);
  }
  const root = make('label', [make('span', label), slider, box, name], { className: 'field' });
  fields.push({ root, show });
  return root;
}

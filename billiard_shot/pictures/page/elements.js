// Parts of the page.

const element = (id) => document.getElementById(id);

function make(tag, content, properties = {}) {
  const made = document.createElement(tag);
  made.append(...[content].flat());
  return Object.assign(made, properties);
}

/** Set properties that differ from those of an element: browsers draw all again that is set. */
function update(part, properties) {
  for (const [name, value] of Object.entries(properties)) {
    if (String(part[name]) !== String(value)) part[name] = value;
  }
}

function fill(id, choices) {
  element(id).replaceChildren(...choices.map(([text, value]) => make('option', text, { value })));
}

function button(text, act, properties = {}) {
  const made = make('button', text, { type: 'button', ...properties });
  made.addEventListener('click', act);
  return made;
}

/** Write a number with its digits; of two that are equally near it is the even one, as in Python. */
function fixed(value, digits) {
  let text = value.toFixed(digits);
  const isTie = Math.abs(value * 2 ** (digits + 1)) % 2 === 1;
  if (isTie && text.at(-1) % 2) text = text.slice(0, -1) + (text.at(-1) - 1);
  return text.replace(/^-(0\.?0*)$/, '$1').replace('-', '−');
}

/** Write a probability in per cent, with enough digits to distinguish it from 0 and 100, as Python does. */
function percent(part) {
  for (let digits = 0; ; digits++) {
    const text = fixed(100 * part, digits);
    if (digits === 3 || part <= 1e-9 || part >= 1 - 1e-9 || (text > 0 && text < 100)) return `${text} %`;
  }
}

const between = ([low, high]) => `${percent(low).slice(0, -2)} to ${percent(high)}`;

/** Call a function once nothing has asked for it for a while [ms]. */
function afterQuiet(wait, act) {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(act, wait);
  };
}

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

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, '$1').replace('-', '−');

/** Call a function once nothing has asked for it for a while [ms]. */
function afterQuiet(wait, act) {
  let timer = 0;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(act, wait);
  };
}

// Parts of the page.

const element = (id) => document.getElementById(id);

function make(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

function fill(id, choices) {
  element(id).replaceChildren(...choices.map(([text, value]) => {
    const option = make('option', text);
    option.value = value;
    return option;
  }));
}

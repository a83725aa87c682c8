// The list of events, and the marks on the slider: all, or those of a ball.

const MARKS = { // colours of events on the slider
  strike: '#ffffff', cushion: '#009e73', ball: '#cc79a7', cluster: '#cc79a7', pocket: '#e69f00',
  off: '#d55e00', roll: '#0072b2', bounce: '#9aa6b0', land: '#9aa6b0',
};
let listed = [];

function listEvents() {
  const ball = element('ball').value;
  listed = shown.events.filter((event) => !ball || event.balls.includes(ball));
  element('events').replaceChildren(...listed.map((event) => {
    const text = [make('span', fixed(event.time, 3)), event.text];
    return make('li', button(text, () => setTime(event.time)));
  }));
  if (!listed.length) element('events').append(make('li', 'no such event'));
  element('ticks').replaceChildren(...listed.filter(({ kind }) => MARKS[kind]).map((event) => {
    const tick = make('i', '');
    tick.style.left = `${100 * (event.time - begin()) / (end() - begin())}%`;
    tick.style.background = MARKS[event.kind];
    return tick;
  }));
  draw();
}

function markEvents() {
  const now = countUpTo(time + 1e-9, listed.length, (i) => listed[i].time) - 1;
  const list = element('events');
  list.querySelectorAll('button').forEach((item, i) => {
    item.classList.toggle('past', i <= now);
    const entered = i === now && !item.classList.contains('now');
    item.classList.toggle('now', i === now);
    if (!entered) return; // else the list alone is scrolled, not the panel around it
    const [above, below] = [item.offsetTop, item.offsetTop + item.offsetHeight];
    list.scrollTop = clamp(list.scrollTop, below - list.clientHeight, above);
  });
}

function fillChoices() {
  const names = data.balls.map(({ name }) => name);
  fill('ball', [['all balls', ''], ...names.map((name) => [name, name])]);
  fill('follow', [['follow', ''], ...names.map((name) => [`follow ${name}`, name])]);
}

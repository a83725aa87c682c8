// Names beside the balls, in the colours of their paths.

const GAP = 4; // pixels between a ball and its name
const labels = data.balls.map((ball) => {
  const label = make('span', ball.name);
  label.style.color = (!ball.pale && ball.path) || '';
  label.classList.toggle('dark', ball.path === '#000000');
  element('labels').append(label);
  return label;
});
// A name that would cover a ball or another name is left out: first those of balls at rest.
const order = [...data.balls.keys()].sort((i, j) => !data.balls[i].path - !data.balls[j].path);

function placeLabels(balls, view) {
  const shown = element('names').checked;
  const area = freeArea();
  const discs = balls.map(({ place, opacity }) => {
    const [x, y, depth] = project(place, view);
    const [topX, topY] = project(add(place, view.up, data.radius), view);
    const radius = Math.hypot(topX - x, topY - y);
    return { x, y, radius, there: opacity > 0.5 && depth > 0 };
  });
  const taken = discs.filter(({ there }) => there)
    .map(({ x, y, radius: r }) => [x - r, y - r, x + r, y + r]);
  for (const i of order) {
    const { x, y, radius, there } = discs[i];
    const { offsetWidth: width, offsetHeight: height } = labels[i];
    const away = radius + GAP;
    const places = [[x - width / 2, y - away - height], [x + away, y - height / 2],
      [x - away - width, y - height / 2], [x - width / 2, y + away]];
    const found = shown && there && places.find(([left, top]) =>
      left > area.left && left + width < area.right && top > area.top && top + height < area.bottom
      && taken.every(([l, t, r, b]) => left >= r || left + width <= l || top >= b || top + height <= t));
    labels[i].style.visibility = found ? 'visible' : 'hidden';
    if (!found) continue;
    const [left, top] = found;
    labels[i].style.transform = `translate(${left}px, ${top}px)`;
    taken.push([left, top, left + width, top + height]);
  }
}

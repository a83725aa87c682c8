// Names beside the balls, in the colours of their paths.

const GAP = 4; // pixels between a ball and its name
const labels = data.balls.map(({ name }) => {
  const label = make('span', name);
  element('labels').append(label);
  return label;
});

function colourLabels() {
  shown.balls.forEach(({ path }, i) => {
    labels[i].style.color = (path !== PALE && path) || '';
    labels[i].classList.toggle('dark', path === '#000000');
  });
}

// A name that would cover a ball or another name is left out: first those of balls at rest.
function placeLabels(balls, view) {
  const [wanted, moved] = [element('names').checked, shown.balls.map((ball) => Boolean(ball.path))];
  const area = freeArea();
  const discs = balls.map(({ place, opacity }) => {
    const [x, y, depth] = project(place, view);
    const [topX, topY] = project(add(place, view.up, data.scene.radius), view);
    const radius = Math.hypot(topX - x, topY - y);
    return { x, y, radius, there: opacity > 0.5 && depth > 0 };
  });
  const taken = discs.filter(({ there }) => there)
    .map(({ x, y, radius: r }) => [x - r, y - r, x + r, y + r]);
  for (const i of [...labels.keys()].sort((a, b) => moved[b] - moved[a])) {
    const { x, y, radius, there } = discs[i];
    const { offsetWidth: width, offsetHeight: height } = labels[i];
    const away = radius + GAP;
    const places = [[x - width / 2, y - away - height], [x + away, y - height / 2],
      [x - away - width, y - height / 2], [x - width / 2, y + away]];
    const found = wanted && there && places.find(([left, top]) =>
      left > area.left && left + width < area.right && top > area.top && top + height < area.bottom
      && taken.every(([l, t, r, b]) => left >= r || left + width <= l || top >= b || top + height <= t));
    labels[i].style.visibility = found ? 'visible' : 'hidden';
    if (!found) continue;
    const [left, top] = found;
    labels[i].style.transform = `translate(${left}px, ${top}px)`;
    taken.push([left, top, left + width, top + height]);
  }
}

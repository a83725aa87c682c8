// The stroke: its numbers, and where the tip meets the ball's face, as seen along the cue.

function fillStroke() {
  const { a, b, elevation_deg: elevation, azimuth_deg: azimuth, speed, touch } = data.stroke;
  const sides = (value, before, after) => (Math.abs(value) < 5e-3 ? '' : value < 0 ? ` ${before}` : ` ${after}`);
  const rows = [
    ['speed', `${fixed(speed, 2)} m/s`],
    ['elevation', `${fixed(elevation, 1)}°`],
    ['azimuth', `${fixed(azimuth, 1)}°`],
    ['a', `${fixed(a, 2)}${sides(a, 'left', 'right')}`],
    ['b', `${fixed(b, 2)}${sides(b, 'below', 'above')}`],
  ];
  element('stroke').replaceChildren(...rows.flatMap(([name, text]) => [make('dt', name), make('dd', text)]));
  for (const [id, [x, y]] of [['axis', [a, b]], ['touch', touch]]) {
    element(id).setAttribute('cx', x);
    element(id).setAttribute('cy', -y);
  }
  element('axis').setAttribute('r', 0.0065 / data.radius); // m, half the width of a usual tip
}

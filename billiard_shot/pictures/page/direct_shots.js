// A menu of all direct shots from where the balls lie, the surest first; a click aims.

const MOST_LISTED = 40;

function directShots(balls) {
  const found = data.scene.pockets.length ? tableFor(state).shots(balls) : [];
  return found.sort((a, b) => b.chance - a.chance);
}

function listShots() {
  const found = directShots(state.balls);
  element('shots').replaceChildren(...found.slice(0, MOST_LISTED).map((shot) => {
    const cut = `${fixed(Math.abs(shot.cut) * DEGREES, 0)}° cut`;
    const way = make('span', `${shot.ball} → ${placeInWords(shot.pocket)}`);
    const chance = make('b', `about ${percent(shot.chance)}`);
    return make('li', button([way, make('small', cut), chance], () => takeShot(shot)));
  }));
  element('no-shots').hidden = found.length > 0;
}

function takeShot({ ball, pocket, stroke }) {
  aim({ a: 0, b: 0, ...stroke }, null, { target: { ball, pocket } });
}

/** The stroke of a page without one: the surest direct shot, or at the nearest ball. */
function firstStroke(balls) {
  const [best] = directShots(balls);
  const [x, y] = balls.cue;
  const others = Object.entries(balls).filter(([name]) => name !== 'cue').map(([, place]) => place);
  const far = ([u, v]) => Math.hypot(u - x, v - y);
  const [nearest] = others.sort((a, b) => far(a) - far(b));
  const ahead = nearest ? Math.atan2(nearest[1] - y, nearest[0] - x) : 0;
  const wanted = best ? { a: 0, b: 0, ...best.stroke } : { ...state.stroke, azimuth: ahead, speed: 4 };
  return raised(balls, wanted, wanted.elevation);
}

// How balls turn. On a segment the spin is linear in time, w0 + w' t, about an axis that may turn. A
// step of length h turns the ball by the vector  h w(h/2) + h^3/12 w' x w0 , the Magnus series (Iserles
// et al., Acta Numerica 2000, section 4) to fourth order.

const MAX_TURN = 0.35; // rad by which a ball turns from one orientation to the next, at most

/** Times, and orientations at them, of a ball from its first orientation on. */
function turnsOf({ segments }, until, first) {
  const [times, turns] = [[0], [first]];
  segments.forEach((segment, i) => {
    const duration = Math.min(segments[i + 1]?.time ?? Infinity, until) - segment.time;
    if (duration <= 0) return;
    const { spin: w, spin_acceleration: change } = segment;
    const fastest = Math.max(Math.hypot(...w), Math.hypot(...add(w, change, duration)));
    const steps = Math.max(1, Math.ceil(fastest * duration / MAX_TURN));
    const h = duration / steps;
    const twist = scale(cross(change, w), h ** 3 / 12);
    for (let step = 0; step < steps; step++) {
      const turn = add(scale(add(w, change, (step + 0.5) * h), h), twist);
      turns.push(product(rotation(turn), turns.at(-1)));
      times.push(segment.time + (step + 1) * h);
    }
  });
  return { times, turns };
}

/** The first orientation of a ball: its number up, tilted to its own side. */
function firstTurn(number) {
  const around = 2.4 * number; // the golden angle: no two balls are tilted to the same side
  // the number, at +x with its head at +z, comes to +z with its head at +x
  const up = product(rotation([0, 0, Math.PI]), rotation([0, -Math.PI / 2, 0]));
  return product(rotation([0.6 * Math.cos(around), 0.6 * Math.sin(around), 0]), up);
}

// What is where at a time: balls, as their trajectories say; the cue, for the eye.

const SWING = 0.3; // m, largest distance over which the cue is accelerated
const MAX_ACCELERATION_TIME = 0.8; // s, largest duration of the acceleration

/** State of a ball at a time [s]: what its trajectory says. */
function stateAt(segments, time) {
  const t = Math.max(time, 0);
  const row = segments[Math.max(countUpTo(t, segments.length, (i) => segments[i].time) - 1, 0)];
  const dt = STILL.includes(row.motion) ? 0 : t - row.time;
  return {
    motion: row.motion,
    since: t - row.time,
    position: add(add(row.position, row.velocity, dt), row.acceleration, dt * dt / 2),
    velocity: add(row.velocity, row.acceleration, dt),
    spin: add(row.spin, row.spin_acceleration, dt),
  };
}

function turnAt(shown, number, time) {
  const first = firstTurn(number);
  if (time <= 0) return first;
  const ball = shown.balls[number];
  ball.turns ??= turnsOf(ball, shown.until, first); // of balls that are looked at in motion
  const { times, turns } = ball.turns;
  const next = clamp(countUpTo(time, times.length, (i) => times[i]), 1, times.length);
  if (next === times.length) return turns.at(-1);
  const part = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return slerp(turns[next - 1], turns[next], Math.max(part, 0));
}

/** A ball as it is drawn; one that is gone falls out of sight. */
function shownBall(shown, number, time) {
  const ball = shown.balls[number];
  if (!ball.there) return { place: [0, 0, -1], turn: [0, 0, 0, 1], opacity: 0 };
  const { motion, since, position } = stateAt(ball.segments, time);
  const look = { place: position, turn: turnAt(shown, number, time), opacity: 1 };
  if (motion === 'POCKETED') {
    const distance = (to) => Math.hypot(to[0] - position[0], to[1] - position[1]);
    const hole = data.table.holes.reduce((a, b) => (distance(a) < distance(b) ? a : b));
    const way = 1 - Math.exp(-12 * since);
    look.place = [position[0] + way * (hole[0] - position[0]) * 0.6,
      position[1] + way * (hole[1] - position[1]) * 0.6, position[2] - 4.9 * since * since];
  }
  if (motion === 'OFF_TABLE') look.opacity = clamp(1 - 2 * since, 0, 1);
  if (look.place[2] < -0.13) look.opacity = 0;
  return look;
}

/** Unit vectors to the right, up and along a stroke. */
function axesOf({ elevation, azimuth }) {
  const [c, s, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return { right: [s, -c, 0], up: [c * se, s * se, ce], along: [c * ce, s * ce, -se] };
}

/** The cue as it strikes: where its tip touches the ball, and how it moves. */
function cueOf({ balls, shot, stroke }) {
  const { right, up, along } = axesOf(stroke);
  const depth = Math.sqrt(Math.max(1 - stroke.a ** 2 - stroke.b ** 2, 0));
  const normal = add(add(scale(right, stroke.a), up, stroke.b), along, -depth);
  const swing = Math.min(SWING, 0.5 * stroke.speed * MAX_ACCELERATION_TIME);
  return {
    tip: add(stateAt(balls[0].segments, 0).position, normal, data.scene.radius),
    direction: along, swing, time: 2 * swing / stroke.speed, after: Math.max(shot.cue.speed, 0),
  };
}

/** The cue speeds up evenly, strikes at 0, goes on for a moment, and is taken away. */
function shownCue({ cue }, time) {
  let ahead = cue.after * 0.06;
  if (time < 0) ahead = -cue.swing * (1 - clamp(1 + time / cue.time, 0, 1) ** 2);
  else if (time < 0.12) ahead = cue.after * (time - time * time / 0.24);
  const { tip, direction } = cue;
  return { tip: add(tip, direction, ahead), direction, opacity: clamp(2 - 2.5 * time, 0, 1) };
}

// What is where at a time: balls, as their trajectories say; the cue, for the eye.

const data = JSON.parse(document.getElementById('data').textContent);
const [REST, POCKETED, OFF] = [0, 5, 6]; // motions
const BEGIN = data.events.length ? -data.cue.time - 0.1 : 0;
const END = Math.max(data.until, 0.01);

// State of a ball at a time [s]: what its trajectory says.
function stateOf(ball, time) {
  const { segments } = ball;
  const t = Math.max(time, 0);
  const row = segments[Math.max(countUpTo(t, segments.length, (i) => segments[i][0]) - 1, 0)];
  const dt = row[1] === REST || row[1] >= POCKETED ? 0 : t - row[0];
  const part = (from) => row.slice(from, from + 3);
  const acceleration = part(8);
  return {
    motion: row[1],
    since: t - row[0],
    position: add(add(part(2), part(5), dt), acceleration, dt * dt / 2),
    velocity: add(part(5), acceleration, dt),
    spin: add(part(11), part(14), dt),
  };
}

function turnOf({ times, turns }, time) {
  const next = clamp(countUpTo(time, times.length, (i) => times[i]), 1, times.length);
  const quaternion = (i) => turns.slice(4 * i, 4 * i + 4);
  if (next === times.length) return quaternion(times.length - 1);
  const part = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return slerp(quaternion(next - 1), quaternion(next), Math.max(part, 0));
}

// A ball as it is drawn; one that is gone falls out of sight.
function shownBall(ball, time) {
  const { motion, since, position } = stateOf(ball, time);
  const shown = { place: position, turn: turnOf(ball, time), opacity: 1 };
  if (motion === POCKETED) {
    const hole = nearestHole(position);
    const way = 1 - Math.exp(-12 * since);
    shown.place = [position[0] + way * (hole[0] - position[0]) * 0.6,
      position[1] + way * (hole[1] - position[1]) * 0.6, position[2] - 4.9 * since * since];
  }
  if (motion === OFF) shown.opacity = clamp(1 - 2 * since, 0, 1);
  if (shown.place[2] < -0.13) shown.opacity = 0;
  return shown;
}

function nearestHole([x, y]) {
  const distance = (hole) => Math.hypot(hole[0] - x, hole[1] - y);
  return data.table.holes.reduce((a, b) => (distance(a) < distance(b) ? a : b));
}

// The cue speeds up evenly, strikes at 0, goes on for a moment, and is taken away.
function shownCue(time) {
  const { tip, direction, swing, time: swingTime, after } = data.cue;
  let ahead = after * 0.06;
  if (time < 0) ahead = -swing * (1 - clamp(1 + time / swingTime, 0, 1) ** 2);
  else if (time < 0.12) ahead = after * (time - time * time / 0.24);
  return { tip: add(tip, direction, ahead), opacity: clamp(2 - 2.5 * time, 0, 1) };
}

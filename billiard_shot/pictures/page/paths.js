// Paths of the balls of a shot, as lines to draw, and what a shot looks like.

const COLOURS_OF_PATHS = ['#ffffff', '#e69f00', '#56b4e9', '#cc79a7', '#f0e442', '#000000'];
const PALE = '#7f9f91';
const ENDLESS_SHOWN = 2; // s for which a motion without end is shown
const SAGITTA = 2e-4; // m, largest distance of a drawn line from the curve
const MOST_POINTS = 200; // of a segment
const STILL = ['REST', 'POCKETED', 'OFF_TABLE']; // motions without a path
const LIFT = 1.5e-3; // m above the cloth, at which paths are drawn

/** Play the stroke of a state; return all that views show of it. */
function played({ balls: places, stroke, played: executed, effects, parameters }) {
  const shot = tableFor({ effects, parameters }).shoot(places, executed ?? stroke);
  const { refused } = shot;
  const balls = data.balls.map(({ name }) => {
    const segments = shot.segments[name] ?? [];
    if (!segments.length) segments.push(atRest(places[name] ?? [0, 0]));
    const moved = segments.length > 1 || isEndless(segments);
    return { name, segments, there: Object.hasOwn(places, name), moved };
  });
  const lasts = balls.filter(({ there }) => there).map(({ segments }) =>
    segments.at(-1).time + (isEndless(segments) ? ENDLESS_SHOWN : 0));
  const events = refused ? [] : [
    { time: 0, kind: 'strike', balls: ['cue'], text: 'cue strikes' }, ...eventsOf(shot),
  ];
  return withColours({
    shot, refused, balls, events, stroke: executed ?? stroke, until: Math.max(0, ...lasts),
  });
}

const atRest = (place) => {
  const [position, zero] = [[...place, data.scene.radius], [0, 0, 0]];
  return {
    time: 0, motion: 'REST', position, velocity: zero, acceleration: zero, spin: zero, spin_acceleration: zero,
  };
};

const isEndless = (segments) => !STILL.includes(segments.at(-1).motion);

/** Whether balls meet in an event. */
const isMeeting = ({ kind }) => kind === 'ball' || kind === 'cluster';

/** The ball that the cue ball meets first, and when; undefined if it meets none. */
const firstContact = ({ events }) => events.find((event) => isMeeting(event) && event.balls[0] === 'cue');

// No two balls share a colour. If more move than there are colours, only the cue ball, the ball that it
// meets first and those that leave the table have one.
function withColours(shown) {
  const moving = shown.balls.filter(({ moved }) => moved);
  let told = moving;
  if (moving.length > COLOURS_OF_PATHS.length) {
    const first = firstContact(shown)?.balls[1];
    const gone = ({ segments }) => ['POCKETED', 'OFF_TABLE'].includes(segments.at(-1).motion);
    told = [...moving.filter(({ name }) => name === 'cue' || name === first), ...moving.filter(gone)];
  }
  moving.forEach((ball) => { ball.path = PALE; });
  COLOURS_OF_PATHS.forEach((colour, i) => {
    const ball = [...new Set(told)][i];
    if (ball) ball.path = colour;
  });
  return shown;
}

/** Lines of the path of a ball: for each stretch of one kind of motion its points, one after the other. */
function linesOf({ segments }, until) {
  const lines = [];
  let line = null;
  segments.forEach((segment, i) => {
    const { motion, time: start } = segment;
    const end = Math.min(segments[i + 1]?.time ?? Infinity, until);
    if (!['SLIDE', 'ROLL', 'FLIGHT'].includes(motion) || start >= end) return;
    const [v, a] = [segment.velocity, segment.acceleration];
    if (line?.motion !== motion) {
      line = { motion, points: [...segment.position] };
      lines.push(line);
    }
    // a parabola's chord over dt misses it by at most a dt^2 / 8
    const size = Math.hypot(...a);
    const straight = Math.hypot(...cross(v, a)) <= 1e-9 * size * Math.hypot(...v);
    const wanted = straight ? 1 : Math.ceil((end - start) * Math.sqrt(size / (8 * SAGITTA)));
    const steps = Math.min(Math.max(wanted, 1), MOST_POINTS);
    for (let k = 1; k <= steps; k++) {
      const dt = (end - start) * k / steps;
      for (let axis = 0; axis < 3; axis++) {
        line.points.push(segment.position[axis] + (v[axis] + 0.5 * a[axis] * dt) * dt);
      }
    }
  });
  return lines;
}

/** A circle on the cloth as a line. */
function circle([x, y], radius) {
  const points = [];
  for (let i = 0; i <= 48; i++) {
    const angle = 2 * Math.PI * i / 48;
    points.push(x + radius * Math.cos(angle), y + radius * Math.sin(angle), data.scene.radius);
  }
  return { points, motion: 'ROLL' };
}

/** Where the cue ball is as it meets other balls. */
const ghostsOf = (shown) => shown.events
  .filter((event) => isMeeting(event) && event.balls.includes('cue'))
  .map(({ time }) => stateAt(shown.balls[0].segments, time).position);

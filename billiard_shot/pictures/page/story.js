// What happened in words, and why a ball missed.

const REFUSALS = { // by status: why nothing was played
  MISS: 'the tip passes the ball',
  NEGATIVE_ELEVATION: 'the stroke points up',
  CUE_THROUGH_CLOTH: 'the cue would pass through the cloth: hit higher, or raise it',
  CUE_THROUGH_BALL: 'another ball is in the way of the cue',
  CUE_THROUGH_CUSHION: 'a cushion is in the way of the cue',
  INVALID_STROKE: 'there is no such stroke',
};
const TROUBLES = { // by status: what is wrong with the result
  INFINITE_SEQUENCE: 'an infinite, decaying sequence of impacts was replaced by its limit',
  NEGATIVE_ENERGY: 'law: poisson drove an elastic energy below zero; take another law',
  TOLERANCE_NOT_REACHED: 'tolerance: not reached',
  BUDGET_EXCEEDED: 'step budget exceeded in the impact or the bounces; the result is incomplete',
};

/** What happened in a shot, in one line. */
function sentenceOf({ shot, refused, balls, events }) {
  if (refused) return REFUSALS[shot.status] ?? placeInWords(shot.status.toLowerCase());
  const falls = events.filter(({ kind }) => kind === 'pocket').map(({ balls: [ball], place }) =>
    `${ball === 'cue' ? 'cue ball scratched' : ball} into ${placeInWords(place)}`);
  const offs = events.filter(({ kind }) => kind === 'off').map(({ balls: [ball] }) =>
    `${ballInWords(ball)} off the table`);
  const first = shot.balls.cue.first_contact;
  const others = balls.filter(({ there }) => there).length > 1;
  const again = shot.cue.double_hit; // s; 0: during the strike
  const endless = balls.find(({ segments }) => isEndless(segments));
  const last = threeDigits(balls[0].segments.at(-1).time);
  const when = again ? `at ${threeDigits(again)} s` : 'during the strike';
  return [
    shot.status === 'NEVER_RESTS'
      && `nothing stops the ball: its last motion, from ${last} s on, is endless`,
    TROUBLES[shot.status],
    shot.cue.miscue && 'a miscue: the tip slid on the ball',
    ...falls, ...offs,
    first >= 0 ? `first contact ${data.scene.names[first]}` : others && 'no ball hit',
    again < Infinity && `a double hit: the cue hits the ball again ${when}`,
    !endless && `at rest after ${threeDigits(shot.duration)} s`,
  ].filter(Boolean).join('; ');
}

/**
 * The ball that a shot pots, or seems to be meant to: the one that it meets first, with the pocket that
 * this ball comes nearest to on its way.
 */
function intended(shown) {
  if (shown.refused || !data.scene.pockets.length) return null;
  const falls = shown.events.find(({ kind, balls }) => kind === 'pocket' && balls[0] !== 'cue');
  if (falls) return { ball: falls.balls[0], pocket: falls.place };
  const met = firstContact(shown);
  if (!met) return null;
  const { position, velocity } = stateAt(ballNamed(shown, met.balls[1]).segments, met.time);
  const off = data.table.holes.map((hole) => Math.abs(angleBetween(velocity, add(hole, position, -1))));
  return { ball: met.balls[1], pocket: data.scene.pockets[off.indexOf(Math.min(...off))] };
}

/** Whether balls are racked: at least nine, each of which nearly touches two others. */
function isRack(balls) {
  const places = Object.entries(balls).filter(([name]) => name !== 'cue').map(([, place]) => place);
  const touches = ([x, y]) => places.filter(([u, v]) => Math.hypot(u - x, v - y) < 2.1 * data.scene.radius);
  return places.length >= 9 && places.every((place) => touches(place).length > 2); // with itself
}

const ballNamed = (shown, name) => shown.balls.find((ball) => ball.name === name);

/** The angle from one horizontal direction to another [rad], positive to the left. */
function angleBetween([ux, uy], [vx, vy]) {
  return Math.atan2(ux * vy - uy * vx, ux * vx + uy * vy);
}

/** Why a shot does not reach its target; empty if it does, or if there is nothing to say. */
function whyMissed(shown, target) {
  if (shown.shot.reaches(target)) return '';
  if (target.ball === undefined) {
    const falls = shown.events.some(({ kind, balls }) => kind === 'pocket' && balls[0] !== 'cue');
    return falls ? 'the cue ball does not stay on the table' : 'no ball falls';
  }
  const fallen = shown.events.find(({ kind, balls }) => kind === 'pocket' && balls[0] === target.ball);
  const [ball, pocket] = [ballInWords(target.ball), placeInWords(target.pocket ?? 'the pockets')];
  if (fallen) {
    const other = target.pocket && fallen.place !== target.pocket;
    return other ? `${ball} falls into ${placeInWords(fallen.place)}, not ${pocket}`
      : 'the cue ball does not stay on the table';
  }
  const ofBall = shown.events.filter(({ balls }) => balls.includes(target.ball));
  const meets = ofBall.find(isMeeting);
  if (!meets) return `${ball} is not hit`;
  if (!target.pocket) return '';
  const hole = data.table.holes[data.scene.pockets.indexOf(target.pocket)];
  const { segments } = ballNamed(shown, target.ball);
  const { position, velocity } = stateAt(segments, meets.time);
  const way = add(hole, position, -1);
  const told = (angle) => `${fixed(Math.abs(angle) * DEGREES, 1)}°`;
  const side = (angle) => (angle > 0 ? 'left' : 'right');
  const off = angleBetween(way, velocity);
  const reasons = [`leaves ${told(off)} too far ${side(off)}`];
  if (meets.balls[0] === 'cue' && meets.kind === 'ball') {
    const cue = stateAt(shown.balls[0].segments, meets.time).position;
    const thrown = angleBetween(add(position, cue, -1), velocity);
    reasons.push(`throw turns it ${told(thrown)} to the ${side(thrown)}`);
  }
  const next = ofBall.find((event) => event.time > meets.time + 1e-9
    && (isMeeting(event) || ['cushion', 'rest', 'off'].includes(event.kind)));
  if (next?.kind === 'rest') {
    const gone = add(stateAt(segments, next.time).position, position, -1);
    const far = (vector) => inUnits(Math.hypot(vector[0], vector[1]), 'length');
    reasons.push(`stops after ${far(gone)} of ${far(way)}`);
  } else if (next?.kind === 'ball') {
    reasons.push(`meets ${ballInWords(next.balls.find((name) => name !== target.ball))}`);
  } else if (next) reasons.push(next.text.replace(/^.*? (?=meets|leaves)/, ''));
  return `${ball} misses ${pocket}: it ${reasons.join('; ')}`;
}

// Balls, places and events in the words that Python has for them.

const ballInWords = (name) => (name === 'cue' ? 'cue ball' : name);
const placeInWords = (place) => place.replaceAll('_', ' ');

/** Write a number with three digits. */
const threeDigits = (value) => String(Number(value.toPrecision(3)));

/** Events of a shot, each with its `text`, in the order of time. */
function eventsOf(shot) {
  return shot.events.map((event) => ({ ...event, text: eventInWords(event) }));
}

function eventInWords({ kind, balls: [first, ...others], place }) {
  const met = others.length ? ` ${others.map(ballInWords).join(', ')}` : '';
  const text = `${ballInWords(first)} ${data.words.happens[kind]}${met}`;
  return place ? `${text}: ${placeInWords(place)}` : text;
}

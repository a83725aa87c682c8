// Balls, places and events in the words that Python has for them.

const ballInWords = (name) => (name === 'cue' ? 'cue ball' : name);
const placeInWords = (place) => place.replaceAll('_', ' ');

/** Write a number with three digits. */
const threeDigits = (value) => String(Number(value.toPrecision(3)));

/** Events of a shot with `kind` and `text`, in the order of time. */
function eventsOf(shot) {
  const names = shot.meanings.Motion;
  return shot.events.flatMap((event) => {
    const place = event.cause === 'POCKET' ? event.pocket
      : event.cause === 'CUSHION' ? data.words.cushions[event.other] : '';
    const kinds = kindsOf(names[event.motion_before], names[event.motion_after], event.cause);
    return kinds.map((kind) => ({
      time: event.time, kind, balls: event.balls, place, text: eventInWords(kind, event.balls, place),
    }));
  });
}

/** What happened between two segments. */
function kindsOf(before, after, cause) {
  if (cause !== 'OWN' && cause !== 'RELEASE') return [cause.toLowerCase()];
  if (after === before) return cause === 'RELEASE' ? [] : [after === 'FLIGHT' ? 'bounce' : 'spin_end'];
  const begins = after.toLowerCase();
  return [...(before === 'FLIGHT' ? ['land'] : []), ...(begins in data.words.happens ? [begins] : [])];
}

function eventInWords(kind, [first, ...others], place) {
  const met = others.length ? ` ${others.map(ballInWords).join(', ')}` : '';
  const text = `${ballInWords(first)} ${data.words.happens[kind]}${met}`;
  return place ? `${text}: ${placeInWords(place)}` : text;
}

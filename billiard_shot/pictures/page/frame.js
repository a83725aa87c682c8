// Messages between the page in a frame and the page around it, if Python wrote it for a frame.
//
// To the page around it:  { type: 'ready' | 'state', state }, { type: 'outcome', outcome } for each shot,
// { type: 'estimate', estimate } for each chance. From there:  { type: 'set', state } with some fields of
// a state, { type: 'play' }. A state that makes no sense is answered by { type: 'refused', message }.

function tell(type, content) {
  if (data.framed) window.parent.postMessage({ type, [type === 'ready' ? 'state' : type]: content }, '*');
}

const publicState = () => fieldsOf(state, LINKED);

function listenToFrame() {
  if (!data.framed || window.parent === window) return;
  window.addEventListener('message', ({ source, data: message }) => {
    if (source !== window.parent || typeof message !== 'object' || message === null) return;
    if (message.type === 'play') play(true);
    if (message.type !== 'set') return;
    try {
      change(acceptable(message.state));
    } catch (error) {
      tell('refused', error.message);
    }
  });
  tell('ready', publicState());
}

/** How a shot ended, for other programs. */
function outcomeNow() {
  const { status, duration, balls: ends } = shown.shot;
  const balls = Object.fromEntries(Object.entries(ends).map(
    ([name, { motion, position, pocket }]) => [name, { motion, position, pocket }]));
  return { status, message: sentenceOf(shown), duration, balls };
}

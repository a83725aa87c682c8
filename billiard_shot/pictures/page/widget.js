// The page of a table in a frame of a notebook (see frame.js): its state is that of the widget.

function render({ model, el }) {
  const frame = Object.assign(document.createElement('iframe'), { srcdoc: model.get('page'), title: 'Billiard table' });
  frame.setAttribute('sandbox', 'allow-scripts allow-downloads');
  Object.assign(frame.style, { width: '100%', height: `${model.get('height')}px`, border: 'none' });
  let shown = null; // the state of the page
  let waiting = false; // until the page has taken a state: what it tells until then is of the one before
  const put = () => {
    waiting = true;
    frame.contentWindow.postMessage({ type: 'set', state: model.get('state') }, '*');
  };
  const follow = () => JSON.stringify(model.get('state')) !== JSON.stringify(shown) && put();
  const take = (estimate) => {
    model.set('state', shown);
    model.set('estimate', estimate);
    model.save_changes();
  };
  const listen = ({ source, data }) => {
    if (source !== frame.contentWindow) return;
    if ('state' in data || data.type === 'refused') waiting = false;
    if ('state' in data) shown = data.state;
    if (data.type === 'ready' && Object.keys(model.get('state')).length) put();
    else if (data.type === 'refused') console.error(data.message);
    else if (data.type !== 'state' && !waiting) take(data.estimate ?? null); // 'state': during a drag, too
  };
  window.addEventListener('message', listen);
  model.on('change:state', follow);
  el.append(frame);
  return () => {
    window.removeEventListener('message', listen);
    model.off('change:state', follow);
  };
}

export default { render };

// The page of a table in a frame of a notebook (see frame.js): its state is that of the widget.

function render({ model, el }) {
  const frame = Object.assign(document.createElement('iframe'), { srcdoc: model.get('page'), title: 'Billiard table' });
  frame.setAttribute('sandbox', 'allow-scripts allow-downloads');
  Object.assign(frame.style, { width: '100%', height: `${model.get('height')}px`, border: 'none' });
  let shown = null; // the state of the page
  const put = () => frame.contentWindow.postMessage({ type: 'set', state: model.get('state') }, '*');
  const follow = () => JSON.stringify(model.get('state')) !== JSON.stringify(shown) && put();
  const take = (estimate) => {
    model.set('state', shown);
    model.set('estimate', estimate);
    model.save_changes();
  };
  const listen = ({ source, data }) => {
    if (source !== frame.contentWindow) return;
    if ('state' in data) shown = data.state;
    if (data.type === 'ready' && Object.keys(model.get('state')).length) put();
    else if (['ready', 'outcome', 'estimate'].includes(data.type)) take(data.estimate ?? null); // not during a drag
    else if (data.type === 'refused') console.error(data.message);
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

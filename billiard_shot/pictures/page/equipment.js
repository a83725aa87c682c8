// Effects on and off, with what each changes; cloth, cushions and tip under the hand.

function fillEquipment() {
  const names = Object.keys(data.equipment.effects);
  element('effects').replaceChildren(...names.map((name) => {
    const box = make('input', [], { type: 'checkbox', id: `effect-${name}` });
    box.addEventListener('change', () => change({ effects: toggled(state.effects, name) }));
    const difference = make('output', '', { id: `difference-${name}` });
    return make('li', [make('label', [box, ` ${placeInWords(name)}`]), difference]);
  }));
  const sectionOf = ({ name }) => name.slice(0, name.lastIndexOf('.'));
  const numbers = data.equipment.parameters;
  const sections = [...new Set(numbers.map(sectionOf))];
  element('parameters').replaceChildren(...sections.flatMap((section) => [
    make('h2', placeInWords(section.replace('.', ', '))),
    ...numbers.filter((number) => sectionOf(number) === section).map((number) => field(
      placeInWords(number.name.split('.').at(-1)), number.unit, number.range,
      () => state.parameters[number.name] ?? number.value,
      (value) => setParameter(number, value),
    )),
  ]));
}

/** The effects that differ from the scene if one more is turned off, or on. */
function toggled(effects, name) {
  const others = effects.filter((each) => each !== name);
  return others.length < effects.length ? others : [...others, name];
}

function setParameter({ name, value: usual }, value) {
  const { [name]: _, ...others } = state.parameters;
  change({ parameters: value === usual ? others : { ...others, [name]: value } }, name);
}

function showEffects() {
  for (const [name, { on }] of Object.entries(data.equipment.effects)) {
    element(`effect-${name}`).checked = on !== state.effects.includes(name);
  }
}

// What each effect changes, one after the other, so that the page stays responsive.
let comparison = 0;
const compareEffects = afterQuiet(QUIET, async () => {
  comparison += 1;
  const [number, before, given] = [comparison, shown, state];
  if (tab !== 'table' || before.refused) return;
  for (const name of Object.keys(data.equipment.effects)) {
    const { shot } = played({ ...given, effects: toggled(given.effects, name) });
    element(`difference-${name}`).textContent = differenceOf(before.shot, shot);
    await new Promise((resolve) => { setTimeout(resolve); });
    if (number !== comparison) return;
  }
});

/** By how much the ends of two shots differ, in words: where they differ most. */
function differenceOf(one, other) {
  if (one.refused !== other.refused) return 'refused';
  const gone = ({ motion, pocket }) => pocket ?? (motion === 'OFF_TABLE' ? motion : '');
  const distanceOf = (a, b) => {
    if (gone(a) !== gone(b)) return Infinity;
    return gone(a) ? 0 : Math.hypot(...add(a.position, b.position, -1));
  };
  const differences = Object.keys(one.balls).map((name) => (
    { name, distance: distanceOf(one.balls[name], other.balls[name]) }));
  const most = differences.reduce((a, b) => (b.distance > a.distance ? b : a));
  if (most.distance === 0) return '–';
  const ball = most.name === 'cue' ? 'cue ball' : `ball ${most.name}`;
  if (most.distance === Infinity) return `${ball} ends elsewhere`;
  const [unit, size, digits] = unitOf('small');
  const least = 10 ** -digits;
  return `${ball} by ${most.distance * size < least ? `< ${least} ${unit}` : inUnits(most.distance, 'small')}`;
}

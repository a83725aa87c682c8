// Up to two shots that are kept: their paths stay on the table, to compare others with.

const KEPT_COLOURS = ['#56b4e9', '#cc79a7'];
const KEPT_NAMES = ['A', 'B'];
const MOST_KEPT = KEPT_NAMES.length;
let keptShots = []; // what is shown of them

function keepShot() {
  change({ kept: [...state.kept, fieldsOf(state, SHOT)].slice(-MOST_KEPT) });
}

function showKept() {
  keptShots = state.kept.map((given) => played({ ...state, played: null, ...given }));
  keptShots.forEach((kept, i) => {
    const ends = kept.balls.filter(({ there, moved }) => there && moved)
      .map(({ segments }) => circle(segments.at(-1).position, data.scene.radius));
    const paths = kept.balls.filter(({ there }) => there).flatMap((ball) => linesOf(ball, kept.until));
    renderer?.setLines(`kept ${i}`, pointsOfLines([...paths, ...ends], LIFT - data.scene.radius));
  });
  element('kept').replaceChildren(...keptShots.map((kept, i) => {
    const colour = make('i', '');
    colour.style.background = KEPT_COLOURS[i];
    const take = button('Take', () => change(state.kept[i]), { title: 'Go back to this shot' });
    const others = state.kept.filter((_, k) => k !== i);
    const leave = button('×', () => change({ kept: others }), { title: 'Forget it' });
    return make('li', [colour, make('b', KEPT_NAMES[i]), make('span', sentenceOf(kept), { id: `kept-${i}` }), take, leave]);
  }));
}

const keptLines = () => keptShots.map((_, i) => (
  { name: `kept ${i}`, colour: KEPT_COLOURS[i], width: 1.4, opacity: 0.85 }));

import { readFileSync } from 'node:fs';
import { load } from './core.mjs';

const core = await load();
const table = new core.Table(JSON.parse(readFileSync('scene.json', 'utf-8')));

const balls = { cue: [-0.4, 0], 8: [0.6, 0.2] }; // m; ball 1 is not on the table
const [best] = table.shots(balls).sort((one, other) => other.chance - one.chance);
const { chance, interval } = await table.chance(balls, best.stroke, best);
console.log(`8 into ${best.pocket}: ${chance}, 95 % CI ${interval}`);

const shot = table.shoot(balls, { ...best.stroke, b: 0.3 }); // the tip hits above the middle
console.log(shot.status, shot.balls[8].pocket, shot.events.map((event) => event.kind));
console.log(shot.at(0.5).cue.position, shot.balls.cue.position);

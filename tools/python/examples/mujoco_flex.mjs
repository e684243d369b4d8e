// node mujoco_flex.mjs MODEL.xml SECONDS RATE: simulates a cloth of MuJoCo and prints the positions of its nodes at the
// start and RATE times a second as JSON.
import {readFileSync} from 'fs';
import load from '@mujoco/mujoco';

const [path, seconds, rate] = process.argv.slice(2);
const mujoco = await load();
mujoco.FS.writeFile('/model.xml', readFileSync(path, 'utf8'));
const model = mujoco.MjModel.mj_loadXML('/model.xml');
const data = new mujoco.MjData(model);
const numSteps = Math.round(1 / (Number(rate) * model.opt.timestep));
mujoco.mj_forward(model, data);
const frames = [Array.from(data.flexvert_xpos)];
for (let frame = 0; frame < Math.round(Number(seconds) * Number(rate)); ++frame) {
  for (let step = 0; step < numSteps; ++step) mujoco.mj_step(model, data);
  frames.push(Array.from(data.flexvert_xpos));
}
console.log(JSON.stringify(frames));

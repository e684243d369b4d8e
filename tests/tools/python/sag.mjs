// node sag.mjs MODEL.xml SECONDS: lets a cloth of MuJoCo come to rest, stopping all of it whenever its kinetic energy
// falls, and prints the positions of its nodes as JSON.
import {readFileSync} from 'fs';
import load from '@mujoco/mujoco';

const mujoco = await load();
mujoco.FS.writeFile('/model.xml', readFileSync(process.argv[2], 'utf8'));
const model = mujoco.MjModel.mj_loadXML('/model.xml');
const data = new mujoco.MjData(model);
const numSteps = Math.round(Number(process.argv[3]) / model.opt.timestep);
let last = 0;
for (let step = 0; step < numSteps; ++step) {
  mujoco.mj_step(model, data);
  let energy = data.qvel.reduce((sum, v) => sum + v * v, 0);
  if (energy < last) {
    data.qvel.fill(0);
    energy = 0;
  }
  last = energy;
}
mujoco.mj_forward(model, data);
console.log(JSON.stringify(Array.from(data.flexvert_xpos)));

// node mujoco_flex.mjs MODEL.xml SECONDS RATE [POSES.json]: simulates a cloth of MuJoCo and prints the positions of its
// nodes at the start and RATE times a second as JSON. POSES.json has a row per step, x, y, z, qw, qx, qy, qz of every
// body that is moved (data.mocap_pos and data.mocap_quat), behind each other.
import {readFileSync} from 'fs';
import load from '@mujoco/mujoco';

const [path, seconds, rate, posesFile] = process.argv.slice(2);
const mujoco = await load();
mujoco.FS.writeFile('/model.xml', readFileSync(path, 'utf8'));
const model = mujoco.MjModel.mj_loadXML('/model.xml');
const data = new mujoco.MjData(model);
const numSteps = Math.round(1 / (Number(rate) * model.opt.timestep));
const poses = posesFile ? JSON.parse(readFileSync(posesFile, 'utf8')) : [];
mujoco.mj_forward(model, data);
const frames = [Array.from(data.flexvert_xpos)];
for (let frame = 0; frame < Math.round(Number(seconds) * Number(rate)); ++frame) {
  for (let step = 0; step < numSteps; ++step) {
    const pose = poses[frame * numSteps + step];
    if (pose) {
      data.mocap_pos.set(pose.filter((_, i) => i % 7 < 3));
      data.mocap_quat.set(pose.filter((_, i) => i % 7 >= 3));
    }
    mujoco.mj_step(model, data);
  }
  frames.push(Array.from(data.flexvert_xpos));
}
console.log(JSON.stringify(frames));

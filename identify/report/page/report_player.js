'use strict';
// Plays a recording: which frame is shown, and when.

// What the replay shows.
const state = {replay: null, wanted: 0, frame: 0, isPlaying: false, clock: 0, last: 0, isDirty: true};
let viewer = null;

function redraw() { state.isDirty = true; }

function showFrame(frame) {
  state.frame = frame;
  part('scrubber').value = frame;
  const {times, frames} = state.replay;
  part('time').textContent = `${times[frame].toFixed(3)} s, frame ${frame + 1} of ${frames}`;
  redraw();
}

// The last frame that is not later.
function frameAt(time) {
  const {times} = state.replay;
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}

function play(isPlaying) {
  state.isPlaying = isPlaying;
  part('play').textContent = isPlaying ? 'Pause' : 'Play';
  const {times} = state.replay;
  state.clock = state.frame === times.length - 1 ? times[0] : times[state.frame];
}

function advance(now) {
  const elapsed = Math.min(now - state.last, 250);
  state.last = now;
  if (state.isPlaying) {
    const {times} = state.replay, first = times[0], length = times[times.length - 1] - first;
    state.clock += elapsed / 1e3 * Number(part('speed').value);
    if (length > 0 && state.clock > first + length) state.clock = first + (state.clock - first) % length;
    const frame = frameAt(state.clock);
    if (frame !== state.frame) showFrame(frame);
  }
  if (state.isDirty && state.replay) {
    state.isDirty = false;
    viewer.draw(state.frame, {sideBySide: part('view').value === 'side', withErrors: part('error-colours').checked});
  }
  requestAnimationFrame(advance);
}

function setLabels() {
  const dot = (name) => {
    const made = element('span', 'swatch');
    made.style.background = `var(--${name})`;
    return made;
  };
  const isSide = part('view').value === 'side';
  part('label-left').replaceChildren(...(isSide ? [dot('recorded'), 'recorded']
    : [dot('recorded'), 'recorded', dot('predicted'), 'predicted']));
  part('label-right').replaceChildren(...(isSide ? [dot('predicted'), 'predicted'] : []));
  part('scale').hidden = !part('error-colours').checked;
  redraw();
}

function replayNotes(replay) {
  const notes = [`Positions are rounded to ${number(1e3 * replay.step, 2)} mm.`];
  if (replay.every > 1) notes.push(`Every ${replay.every}th of the recorded frames, to keep this file small.`);
  if (!replay.points_are_nodes && replay.hasNodes) notes.push('Lines lead from recorded points to where they are predicted.');
  return notes.concat(replay.notes).join(' ');
}

function showMissing(reason) {
  part('stage').hidden = part('replay-controls').hidden = true;
  part('replay-missing').hidden = false;
  part('replay-missing').textContent = reason;
}

function showErrors(replay) {
  drawHeatMap(replay);
  part('heat-map').removeAllListeners('plotly_click');
  part('heat-map').on('plotly_click', ({points}) => {
    if (!state.replay) return;
    play(false);
    showFrame(replay.times.indexOf(points[0].x));
  });
}

async function showRecording(index) {
  const recording = data.recordings[index];
  drawPerFrame(recording);
  drawHistogram(recording);
  drawForces(recording);
  part('stage').hidden = part('replay-controls').hidden = false;
  part('replay-missing').hidden = true;
  state.replay = null;
  state.wanted = index;
  state.isPlaying = false;
  if (recording.replay.left_out) {
    narrow.onchange = null;
    Plotly.purge('heat-map');
    part('heat-map-caption').textContent = recording.replay.left_out;
    showMissing(recording.replay.left_out);
    return;
  }
  const replay = await unpackReplay(recording.replay);
  if (state.wanted !== index) return;
  showErrors(replay);
  narrow.onchange = () => showErrors(replay);
  if (!viewer) {
    showMissing('This browser has no WebGL 2, which the replay needs.');
    return;
  }
  viewer.load(replay);
  state.replay = replay;
  part('scrubber').max = replay.frames - 1;
  part('scale-end').textContent = millimetres(replay.largest_error);
  part('replay-notes').textContent = replayNotes(replay);
  play(false);
  // report.html#frame=40 opens there.
  const asked = Number((/^#frame=(\d+)$/.exec(location.hash) || [])[1] || 1);
  showFrame(Math.min(Math.max(asked, 1), replay.frames) - 1);
}

function select(index) {
  showRecording(index).catch((error) => showMissing(`The replay cannot be shown: ${error}`));
}

// What one pointer, or the first two fingers, do to the view.
function listenToPointers(canvas) {
  const held = new Map();
  const between = () => {
    const [[ax, ay], [bx, by]] = [...held.values()];
    return {x: (ax + bx) / 2, y: (ay + by) / 2, spread: Math.hypot(bx - ax, by - ay) || 1};
  };
  canvas.addEventListener('pointerdown', (event) => {
    if (held.size === 2) return;
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, ({pointerId}) => held.delete(pointerId));
  }
  canvas.addEventListener('pointermove', (event) => {
    const last = held.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!last || !state.replay) return;
    const before = held.size === 2 ? between() : null, dx = now[0] - last[0], dy = now[1] - last[1];
    held.set(event.pointerId, now);
    if (before) {
      const after = between();
      viewer.move(after.x - before.x, after.y - before.y);
      viewer.zoom(before.spread / after.spread);
    } else if (event.shiftKey || event.buttons > 1) {
      viewer.move(dx, dy);
    } else {
      viewer.turn(dx, dy);
    }
    redraw();
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    viewer.zoom(Math.exp(0.001 * event.deltaY));
    redraw();
  }, {passive: false});
}

'use strict';
// Plays a recording: which frame is shown, and when. The page has `frameShown(frame)`, which says what else changes with
// the frame, and `drawOptions()`, how it is drawn.

// What the replay shows.
const state = {replay: null, wanted: 0, frame: 0, isPlaying: false, clock: 0, last: 0, isDirty: true};
let viewer = null;

function redraw() { state.isDirty = true; }

function showFrame(frame) {
  state.frame = frame;
  part('scrubber').value = frame;
  frameShown(frame);
  redraw();
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
    const frame = frameAt(times, state.clock);
    if (frame !== state.frame) showFrame(frame);
  }
  if (state.isDirty && state.replay) {
    state.isDirty = false;
    viewer.draw(state.frame, drawOptions());
  }
  requestAnimationFrame(advance);
}

// What the replay leaves out, behind it what the page has to say of it.
function fillNotes(replay, own) {
  const notes = [`Positions are rounded to ${number(1e3 * replay.step, 2)} mm.`];
  if (replay.every > 1) notes.push(`Every ${replay.every}th of the recorded frames, to keep this file small.`);
  part('replay-notes').textContent = notes.concat(own, replay.notes).join(' ');
}

// Shows another recording, from frame `first` on.
function loadReplay(replay, first) {
  if (!viewer) {
    showMissing('This browser has no WebGL 2, which the replay needs.');
    return;
  }
  viewer.load(replay);
  state.replay = replay;
  part('scrubber').max = replay.frames - 1;
  play(false);
  showFrame(Math.min(Math.max(first, 0), replay.frames - 1));
}

function showMissing(reason) {
  part('stage').hidden = part('replay-controls').hidden = true;
  part('replay-missing').hidden = false;
  part('replay-missing').textContent = reason;
}

// The viewer and its controls, at a speed of `speed`.
function makePlayer(speed) {
  for (const factor of [0.05, 0.1, 0.25, 0.5, 1, 2, 4]) addOption('speed', factor, `${factor} ×`, factor === speed);
  part('play').addEventListener('click', () => play(!state.isPlaying));
  part('scrubber').addEventListener('input', (event) => {
    play(false);
    showFrame(Number(event.target.value));
  });
  part('reset').addEventListener('click', () => {
    viewer.reset();
    redraw();
  });
  part('replay-hint').textContent = POINTER_HINT;
  new ResizeObserver(redraw).observe(part('canvas'));
  viewer = makeViewer(part('canvas'));
  if (viewer) listenToPointers(part('canvas'), viewer, redraw);
  requestAnimationFrame(advance);
}

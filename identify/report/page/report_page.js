'use strict';
// The page of a fit: its controls, and the order in which its parts are filled in.

function makeControls() {
  for (const speed of [0.05, 0.1, 0.25, 0.5, 1, 2, 4]) {
    const option = element('option', '', `${speed} ×`);
    option.value = speed;
    option.selected = speed === 0.5;
    part('speed').append(option);
  }
  data.recordings.forEach((recording, i) => {
    const option = element('option', '', recording.name);
    option.value = i;
    part('recording').append(option);
  });
  part('recording-label').hidden = data.recordings.length < 2;
  part('scale-bar').style.background = `linear-gradient(to right, ${SCALE.map((c) => `rgb(${c})`).join(', ')})`;
  part('recording').addEventListener('change', (event) => select(Number(event.target.value)));
  part('play').addEventListener('click', () => play(!state.isPlaying));
  part('scrubber').addEventListener('input', (event) => {
    play(false);
    showFrame(Number(event.target.value));
  });
  for (const id of ['view', 'error-colours']) part(id).addEventListener('change', setLabels);
  part('reset').addEventListener('click', () => {
    viewer.reset();
    redraw();
  });
  part('replay-hint').textContent = isTouch ? 'One finger turns, two fingers move and zoom.'
    : 'Drag to turn, shift and drag to move, wheel to zoom.';
  part('convergence-axis').addEventListener('change', drawConvergence);
  part('licences-details').addEventListener('toggle', () => {
    part('licences-shown').textContent = part('licences').textContent;
  });
  new ResizeObserver(redraw).observe(part('canvas'));
}

fillHead();
fillEstimates();
fillTiles();
fillStarts();
fillProvenance();
makeControls();
drawConvergence();
drawProfiles();
viewer = makeViewer(part('canvas'));
if (viewer) listenToPointers(part('canvas'));
setLabels();
requestAnimationFrame(advance);
select(0);

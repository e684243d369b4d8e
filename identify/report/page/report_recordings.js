'use strict';
// The recordings of a fit, one of which is replayed.

function frameShown(frame) {
  const {times, frames} = state.replay;
  part('time').textContent = `${times[frame].toFixed(3)} s, frame ${frame + 1} of ${frames}`;
}

const hasForce = () => Boolean(state.replay && state.replay.missingForce && state.replay.hasNodes);
const drawOptions = () => ({sideBySide: part('view').value === 'side', withErrors: part('error-colours').checked,
  withForce: hasForce() && part('force-colours').checked});

function setLabels() {
  const dot = (name) => swatch(`var(--${name})`);
  const isSide = part('view').value === 'side';
  part('label-left').replaceChildren(...(isSide ? [dot('recorded'), 'recorded']
    : [dot('recorded'), 'recorded', dot('predicted'), 'predicted']));
  part('label-right').replaceChildren(...(isSide ? [dot('predicted'), 'predicted'] : []));
  const {withErrors, withForce} = drawOptions();
  part('scale').hidden = !withErrors && !withForce;
  if (state.replay) {
    part('scale-end').textContent = withForce ? `${number(state.replay.largest_force, 3)} N/m²`
      : millimetres(state.replay.largest_error);
  }
  redraw();
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
  const hasLines = !replay.points_are_nodes && replay.hasNodes;
  fillNotes(replay, hasLines ? ['Lines lead from recorded points to where they are predicted.'] : []);
  // report.html#frame=40 opens there.
  loadReplay(replay, Number((/^#frame=(\d+)$/.exec(location.hash) || [])[1] || 1) - 1);
  part('force-colours-label').hidden = !hasForce();
  setLabels();
}

function select(index) {
  showRecording(index).catch((error) => showMissing(`The replay cannot be shown: ${error}`));
}

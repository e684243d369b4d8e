'use strict';
// The page of a fit: its controls, and the order in which its parts are filled in.

function makeControls() {
  data.recordings.forEach(({name}, i) => addOption('recording', i, name));
  part('recording-label').hidden = data.recordings.length < 2;
  part('scale-bar').style.background = `linear-gradient(to right, ${SCALE.map((c) => `rgb(${c})`).join(', ')})`;
  part('recording').addEventListener('change', (event) => select(Number(event.target.value)));
  for (const id of ['view', 'error-colours', 'force-colours']) part(id).addEventListener('change', setLabels);
  part('convergence-axis').addEventListener('change', drawConvergence);
  part('licences-details').addEventListener('toggle', () => {
    part('licences-shown').textContent = part('licences').textContent;
  });
}

fillHead();
fillEstimates();
fillTiles();
fillStarts();
fillProvenance();
makeControls();
drawConvergence();
drawProfiles();
drawMemories();
makePlayer(0.5);
setLabels();
select(0);

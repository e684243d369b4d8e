'use strict';
// The page of a plan: its head, what failed, and the order in which its parts are filled in.

function fillHead() {
  const names = data.parameters.join(', ');
  part('about').textContent = `${count(data.candidates.length, 'motion')}; ${names}`;
  document.title = `Plan: ${names}`;
  const {version, git, flags} = data.provenance;
  part('provenance').textContent = `clothid ${version}, ${git}: plan ${flags}`;
}

const STARTS = {estimated: 'estimated with the parameters', rest: 'estimated, released at rest',
  moving: 'estimated, in motion', scene: 'known: that of the scene'};

function fillFacts() {
  const recorded = data.recorded, rows = [];
  const add = (name, text) => rows.push([element('th', '', name), element('td', '', text)]);
  const noise = `± ${number(recorded.force_sigma_n, 3)} N`;
  add('parameters', data.parameters.join(', '));
  add('noise', `± ${number(1e3 * recorded.sigma_m, 3)} mm, standard deviation of a coordinate`);
  add('frame rate', recorded.frame_rate_hz > 0 ? `${number(recorded.frame_rate_hz, 4)} Hz` : 'a frame per time step');
  add('points', recorded.markers > 0 ? count(recorded.markers, 'marker') : 'every node');
  add('forces', recorded.forces ? `on all handles together, ${noise}` : `none; a gauge would have ${noise}`);
  if (recorded.handle_sigma_m > 0) {
    add('handles', `their path is measured, ± ${number(1e3 * recorded.handle_sigma_m, 3)} mm`);
  }
  add('start', STARTS[recorded.initial] || recorded.initial);
  add('cloths', `the nominal one and ${count(recorded.draws, 'draw')} of what is believed of it`);
  fillTable('facts', null, rows);
}

function fillFailed() {
  const failed = data.candidates.filter(({failure}) => failure !== null);
  part('failed-card').hidden = failed.length === 0;
  part('failed').replaceChildren(...failed.map(({name, failure}) => {
    const made = element('li');
    made.append(element('strong', '', name), `: ${failure}`);
    return made;
  }));
}

// Motions, the one first that leaves the prediction the narrowest, and the best pair.
function fillPrediction() {
  const predicted = data.prediction;
  part('prediction-card').hidden = !predicted;
  if (!predicted) return;
  const believed = predicted.believed_width_m, both = data.pairs[predicted.pair];
  const planned = ran.map((own) => ({who: own.name, width: own.prediction_width_m}));
  planned.sort((a, b) => a.width - b.width);
  if (both) planned.push({who: pairName(both), width: both.prediction_width_m});
  fillTable('prediction', ['recorded', 'the prediction is off by', 'of what is believed'],
    planned.map(({who, width}, i) => [element('td', i === 0 ? 'estimate' : '', who),
      element('td', 'number', `± ${millimetres(width)}`), element('td', 'number', `${number(100 * width / believed, 3)} %`)]));
  part('prediction-caption').textContent = `Of ${predicted.name}, ± ${millimetres(believed)} by what is believed now: ` +
    'standard deviations of a coordinate, to first order, by what such a recording leaves open of the parameters. ' +
    'What it would not tell, as forces that the model lacks, comes on top of all of them.';
}

fillHead();
fillBest();
fillFacts();
fillFailed();
fillPrediction();
fillBars();
fillMotions();

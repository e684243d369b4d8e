'use strict';
// The page of a recording: its findings, what it holds, and the replay. Frames have the numbers of `motion check`.

const data = JSON.parse(part('data').textContent);
const KINDS = {ok: 'good', note: '', warning: 'warn', problem: 'bad'}, MOST_BUTTONS = 12;
const charts = [];

// To a recorded frame, or the last one before it that is shown.
function jumpTo(recorded) {
  if (!state.replay) return;
  play(false);
  showFrame(Math.min(Math.floor(recorded / state.replay.every), state.replay.frames - 1));
}

function jumpToTime(time) {
  if (!state.replay) return;
  play(false);
  showFrame(nearest(state.replay.times, time));
}

function fillHead() {
  const found = (verdict) => count(data.findings.filter((finding) => finding.verdict === verdict).length, verdict);
  const words = {ok: 'ok', note: found('note'), warning: found('warning'), problem: 'cannot be fitted as it is'};
  part('status').textContent = data.prediction ? data.prediction.status : words[data.verdict];
  if (!data.prediction && KINDS[data.verdict]) part('status').classList.add(KINDS[data.verdict]);
  part('about').textContent = data.name;
  part('heading').textContent = data.prediction ? 'Prediction' : data.simulated ? 'Scene' : 'Recording';
  document.title = data.name;
}

function frameButtons({runs, num_frames: total}) {
  const box = element('div', 'frames'), shown = runs.slice(0, MOST_BUTTONS);
  for (const [first, last] of shown) {
    const made = element('button', '', first === last ? `frame ${first}` : `frames ${first} to ${last}`);
    made.type = 'button';
    made.addEventListener('click', () => {
      jumpTo(first);
      part('stage').scrollIntoView({block: 'nearest'});
    });
    box.append(made);
  }
  const left = total - shown.reduce((sum, [first, last]) => sum + last - first + 1, 0);
  if (left > 0) box.append(element('span', 'caption', `and ${left} more, marked below the slider`));
  return box;
}

function findingItem(finding) {
  const made = element('li');
  made.append(element('span', `pill ${KINDS[finding.verdict]}`, finding.verdict),
    element('strong', '', ` ${finding.what} `), finding.value);
  if (finding.hint) made.append(element('p', 'caption', finding.hint));
  if (finding.runs.length > 0 && !data.replay.left_out) made.append(frameButtons(finding));
  return made;
}

// The gravest first.
const told = ['problem', 'warning', 'note'].flatMap((verdict) =>
  data.findings.filter((finding) => finding.verdict === verdict));

function fillFindings() {
  const fine = data.findings.filter(({verdict}) => verdict === 'ok');
  part('findings').replaceChildren(...told.map(findingItem));
  part('fine').replaceChildren(...fine.map(findingItem));
  part('fine-summary').textContent = `${count(fine.length, 'check')} found nothing to tell`;
  part('fine-details').hidden = fine.length === 0;
}

// Below the slider a row for each finding that names frames.
function fillTimeline() {
  const rows = told.filter(({runs}) => runs.length > 0), last = data.frames - 1;
  const area = part('timeline');
  area.hidden = rows.length === 0 || last < 1;
  if (area.hidden) return;
  const svg = svgElement('svg',
    {viewBox: `0 0 ${last} ${rows.length}`, preserveAspectRatio: 'none', 'aria-hidden': true});
  svg.style.height = `${7 * rows.length}px`;
  rows.forEach(({what, runs, verdict}, row) => {
    const group = svgElement('g', {class: `run ${KINDS[verdict]}`});
    group.append(svgElement('title', {}, what));
    for (const [first, end] of runs) group.append(svgElement('path', {d: `M${first} ${row + 0.5}H${end}`}));
    svg.append(group);
  });
  svg.addEventListener('click', (event) => {
    const box = svg.getBoundingClientRect();
    jumpTo(Math.round(last * Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1)));
  });
  area.replaceChildren(svg);
}

function fillFacts() {
  const {scene, times, frames, points} = data, clouds = data.cloud_points, rows = [];
  const add = (name, text) => { if (text) rows.push([element('th', '', name), element('td', '', text)]); };
  add('frames', `${count(frames, 'frame')}, ${times[0].toFixed(3)} to ${times[1].toFixed(3)} s`);
  add('points', points > 0 ? `${points} on a cloth of ${count(scene.nodes, 'node')}` : '');
  const sizes = clouds ? [...new Set(extent(clouds))].join(' to ') : '';
  add('clouds', clouds ? `${sizes} points in a frame` : '');
  const held = `${count(scene.handles, 'node')}, ${scene.handles_move ? 'moved' : 'held still'}`;
  add('handles', scene.handles > 0 ? held : 'none');
  add('obstacles', scene.obstacles.map(({name, mu}) => `${name} (mu ${number(mu, 4)})`).join(', ') || 'none');
  add('cloth', Object.entries(scene.constants).filter(([, value]) => value !== 0)
    .map(([name, value]) => `${name} ${number(value, 4)} ${parameterUnit(name)}`.trim()).join(', '));
  add('fabric', scene.fabric);
  if (data.forces) {
    add('forces', `${count(data.forces.times.length, 'reading')}, ${count(data.forces.groups, 'group')} of handles`);
  }
  add('from', data.provenance);
  add('sha256', data.sha256);
  fillTable('facts', null, rows);
}

function addChart(area, chart) {
  const target = element('div', 'lines');
  part(area).append(target);
  charts.push(lineChart(target, chart));
}

const BAND_COLOURS = ['#2d5f9a', '#e58a3c', '#3c8d5f', '#8a4fa3', '#b0413e', '#5b6770'];

function fillPrediction() {
  const {prediction} = data;
  part('findings-card').hidden = Boolean(prediction);
  part('prediction-card').hidden = part('bands-card').hidden = !prediction;
  if (!prediction) return;
  part('prediction-facts').replaceChildren(...prediction.facts.map((fact) => element('li', '', fact)));
  for (const chart of prediction.charts) {
    const colours = Object.fromEntries(Object.keys(chart.lines).map((name, i) => [name, BAND_COLOURS[i % 6]]));
    addChart('bands', {...chart, colours});
  }
}

function fillCharts() {
  const {forces, wind} = data, groups = {};
  for (const {group, axis, measured} of forces ? forces.components : []) (groups[group] ||= {})[axis] = measured;
  part('forces-card').hidden = Object.keys(groups).length === 0;
  for (const [group, lines] of Object.entries(groups)) {
    addChart('forces', {name: forces.groups > 1 ? `group ${group}` : 'force', unit: 'N', times: forces.times, lines});
  }
  part('wind-card').hidden = !wind;
  if (wind) addChart('wind', {name: 'wind', unit: 'm/s', times: data.replay.times, lines: wind});
  for (const hint of document.querySelectorAll('.jump-hint')) {
    hint.textContent = `${isTouch ? 'Tap' : 'Click'} to see the frame in the replay.`;
  }
}

function frameShown(frame) {
  const {times, every} = state.replay, clouds = data.cloud_points, words = [];
  part('time').textContent = `${times[frame].toFixed(3)} s, frame ${frame * every} (0 to ${data.frames - 1})`;
  if (data.points > 0) {
    const unseen = data.unseen[frame];
    words.push(unseen > 0 ? `${unseen} of ${count(data.points, 'point')} not seen` : 'all points seen');
  }
  if (data.prediction) {
    words.splice(0, words.length, `the median, and the nodes of ${count(data.prediction.cloths, 'cloth')} that may be`);
  } else if (clouds) words.push(`${count(clouds[frame], 'point')} in the cloud`);
  part('seen').textContent = words.join('; ');
  for (const show of charts) show(times[frame]);
}

const drawOptions = () => ({withStart: part('start').checked});

// What the page itself leaves out.
function ownNotes() {
  const notes = [];
  if (data.cloud_stride > 1) notes.push(`Every ${data.cloud_stride}th point of the clouds.`);
  if (data.far > 0) notes.push(`${count(data.far, 'point')}, over all frames, too far off to be drawn.`);
  return notes;
}

function fillLegend(replay) {
  const dot = (colour, text) => [swatch(colour), text];
  const parts = dot('var(--recorded)', data.prediction ? 'cloths that may be' : data.simulated ? 'simulated' : 'recorded');
  if (replay.handles.length > 0) parts.push(...dot('var(--ink)', 'handles'));
  if (part('start').checked) parts.push(...dot('var(--predicted)', 'start of a simulation'));
  part('label-left').replaceChildren(...parts);
  redraw();
}

// view.html#frame=40 opens there, and goes there.
const askedFrame = () => Number((/^#frame=(\d+)$/.exec(location.hash) || [])[1] || 0);

async function showReplay() {
  if (data.replay.left_out) {
    showMissing(data.replay.left_out);
    return;
  }
  const replay = await unpackReplay({...data.replay, wind: data.wind});
  // Where no cloth was seen, this is the one to look at.
  part('start').checked = !replay.points_are_nodes || data.unseen.every((unseen) => unseen === data.points);
  part('start').addEventListener('change', () => fillLegend(replay));
  fillLegend(replay);
  fillNotes(replay, ownNotes());
  loadReplay(replay, Math.floor(askedFrame() / replay.every));
  addEventListener('hashchange', () => jumpTo(askedFrame()));
}

fillHead();
fillFindings();
fillTimeline();
fillFacts();
fillPrediction();
fillCharts();
makePlayer(1);
showReplay().catch((error) => showMissing(`The replay cannot be shown: ${error}`));

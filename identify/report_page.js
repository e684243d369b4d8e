'use strict';
// The page of a fit: fills in its parts from the data, whose names and texts are shown and never run.

const data = JSON.parse(document.getElementById('data').textContent);
const result = data.result;
const part = (id) => document.getElementById(id);
// Plotly would take tags in names for its own.
const plain = (text) => String(text).replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');
const COLOURS = {estimate: '#2d5f9a', start: '#a3adb8', interval: '#e58a3c'};

function number(value, digits) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  const size = Math.abs(value);
  if (size >= 1e7 || (size < 1e-4 && size > 0)) {
    return value.toExponential(digits - 1).replace(/(\.\d*?)0*e/, '$1e').replace('.e', 'e').replace('e+', 'e');
  }
  return Number(value.toPrecision(digits)).toString();
}
const millimetres = (metres) => metres === null || metres === undefined ? '–' : `${number(1e3 * metres, 4)} mm`;
const percent = (share) => share === null || share === undefined ? '–' : `${number(share, 5)} %`;
const count = (n, word) => `${n} ${word}${n === 1 ? '' : 's'}`;

function element(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
}

function fillList(id, lines) {
  part(id).replaceChildren(...lines.map((line) => element('li', '', line)));
}

function fillTable(id, head, rows) {
  const made = rows.map((cells) => {
    const row = element('tr');
    row.append(...cells);
    return row;
  });
  if (head) {
    const row = element('tr');
    row.append(...head.map((text) => element('th', '', text)));
    made.unshift(row);
  }
  part(id).replaceChildren(...made);
}

const UNITS = {k_stretch: 'N/m', k_bend: 'N m', density: 'kg/m²', drag: 'kg/(m² s)', damping: 'N s/m'};

const STATUS = {0: ['fitted', 'good'], 3: ['not converged', 'bad'], 4: ['not identifiable, or at a bound', 'warn'],
  5: ['worse than nominal on what was held out', 'warn'], 130: ['interrupted', 'warn']};

function fillHead() {
  const [words, kind] = STATUS[result.exit_code] || [result.status, 'bad'];
  part('status').textContent = words;
  part('status').classList.add(kind);
  const names = data.recordings.map((recording) => recording.name).join(', ');
  part('about').textContent = names;
  document.title = `Fit report: ${names}`;
  fillList('verdict', result.verdict);
  fillList('limits', data.limits.length > 0 ? data.limits : ['Nothing that can be told.']);
}

// With as many digits as tell its ends apart.
function interval(parameter) {
  if (parameter.std === null) return '–';
  const relative = parameter.std / Math.max(Math.abs(parameter.value), parameter.std);
  const digits = Math.min(Math.max(2 + Math.ceil(-Math.log10(relative + 2e-16)), 3), 9);
  return `${number(parameter.lower95, digits)} … ${number(parameter.upper95, digits)}`;
}

function remark(parameter) {
  if (parameter.identifiable === false) return 'not identifiable';
  return parameter.at_bound ? 'at its bound' : '';
}

function fillEstimates() {
  const rows = Object.entries(result.parameters).map(([name, parameter]) => {
    const title = element('td', '', `${name} `);
    title.append(element('span', 'unit', UNITS[name] || ''));
    const estimate = element('td', 'number estimate', number(parameter.value, 8));
    estimate.dataset.parameter = name;
    const bounds = element('td', 'number', interval(parameter));
    if (remark(parameter)) bounds.append(' ', element('span', 'remark', remark(parameter)));
    return [title, estimate, bounds, element('td', 'number', number(parameter.start, 6))];
  });
  fillTable('estimates', ['parameter', 'estimate', '95 % interval', 'start'], rows);
  const isKnown = data.recordings.every((recording) => recording.sigma_is_known);
  part('estimates-caption').textContent = isKnown ? 'Intervals follow from the noise that the recordings state.'
    : 'Intervals take the remaining error for noise: the recordings do not state any.';
}

function fillTiles() {
  const holdout = result.holdout, seconds = result.seconds.total;
  const tiles = [['rmse', millimetres(result.rmse_m), `start: ${millimetres(data.start_rmse_m)}`, 'rmse'],
    ['fit', percent(result.fit_percent), `start: ${percent(data.start_fit_percent)}`, 'fit'],
    ['run time', `${number(seconds, 3)} s`, `${count(result.iterations, 'iteration')}, ${count(result.rollouts, 'rollout')}`,
      'seconds']];
  if (holdout) {
    tiles.push(['rmse held out', millimetres(holdout.rmse_m), `nominal: ${millimetres(holdout.nominal_rmse_m)}`, 'holdout']);
  }
  part('tiles').replaceChildren(...tiles.map(([what, value, beside, id]) => {
    const tile = element('div', 'tile');
    const shown = element('div', 'value', value);
    shown.id = `tile-${id}`;
    tile.append(element('div', 'what', what), shown, element('div', 'beside', beside));
    return tile;
  }));
}

const FONT = {family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: 12, color: '#1f2630'};
const PLAIN_AXIS = {gridcolor: '#e9edf1', zerolinecolor: '#cfd6de', linecolor: '#cfd6de', ticks: 'outside', ticklen: 4,
  tickcolor: '#cfd6de', exponentformat: 'power', automargin: true};

function plot(target, traces, {x = {}, y = {}, margin = {}, ...more}) {
  const axis = (own) => ({...PLAIN_AXIS, ...own, title: {text: own.title || '', standoff: 6}});
  const layout = {font: FONT, margin: {l: 56, r: 14, t: 10, b: 40, ...margin}, paper_bgcolor: '#fff', plot_bgcolor: '#fff',
    showlegend: false, legend: {orientation: 'h', x: 0, y: 1.02, yanchor: 'bottom'}, xaxis: axis(x), yaxis: axis(y),
    ...more};
  Plotly.react(target, traces, layout, {displayModeBar: false, responsive: true});
}

// A logarithmic axis where the values ask for one.
function scaleOf(values) {
  const positive = values.filter((value) => value > 0);
  if (positive.length === 0 || values.some((value) => value !== null && value < 0)) return 'linear';
  return Math.max(...positive) / Math.min(...positive) > 30 ? 'log' : 'linear';
}
const decades = (type) => type === 'log' ? {type, dtick: 1, nticks: 6, tickmode: 'auto'} : {type};

const inMillimetres = (values) => values.map((value) => value === null ? null : 1e3 * value);

function drawPerFrame(recording) {
  const {times, rmse, start_rmse: start, every} = recording.per_frame, type = scaleOf(rmse.concat(start));
  const lines = [[start, 'start', COLOURS.start], [rmse, 'estimate', COLOURS.estimate]];
  plot('per-frame', lines.map(([values, name, color]) => ({type: 'scatter', mode: 'lines', x: times, y: inMillimetres(values),
    name, line: {color, width: 2}, hovertemplate: `%{y:.4g} mm at %{x:.4g} s<extra>${name}</extra>`})),
  {x: {title: 'time, s'}, y: {title: 'rmse, mm', ...decades(type), rangemode: 'tozero'}, showlegend: true, margin: {t: 28}});
  part('per-frame-caption').textContent = 'Root mean square distance between recorded and predicted points' +
    (every > 1 ? `, ${every} frames at a time.` : ' of every frame.');
}

function drawHistogram(recording) {
  const histogram = recording.histogram;
  if (!histogram) {
    part('histogram-caption').textContent = 'There are no residuals to speak of.';
    return;
  }
  const bins = histogram.axes[0].counts.length, width = 2e3 * histogram.range / bins;
  const x = Array.from({length: bins}, (_, i) => -1e3 * histogram.range + (i + 0.5) * width);
  plot('histogram', histogram.axes.map((axis, i) => ({type: 'scatter', mode: 'lines', x, y: axis.counts, name: 'xyz'[i],
    line: {shape: 'hvh', width: 1.8, color: ['#2d5f9a', '#e58a3c', '#3c8d5f'][i]},
    hovertemplate: `%{y} at %{x:.3g} mm<extra>${'xyz'[i]}</extra>`})),
  {x: {title: 'predicted - recorded, mm'}, y: {title: 'coordinates', rangemode: 'tozero'}, showlegend: true,
    margin: {t: 28}});
  const spread = histogram.axes.map((axis, i) => `${'xyz'[i]} ${millimetres(axis.deviation)}`).join(', ');
  part('histogram-caption').textContent = `Standard deviations: ${spread}.` +
    (histogram.beyond > 0 ? ` ${histogram.beyond} coordinates lie outside of the picture.` : '');
}

const MOST_ROWS = 500;

// Errors as rows of points over time, mm; neighbouring points together where there are too many.
function errorRows(replay) {
  const together = Math.ceil(replay.points / MOST_ROWS), rows = [];
  for (let first = 0; first < replay.points; first += together) {
    rows.push(Array.from({length: replay.frames}, (_, frame) => {
      let sum = 0, seen = 0;
      for (let p = first; p < Math.min(first + together, replay.points); ++p) {
        const error = replay.errors[frame * replay.points + p];
        if (Number.isNaN(error)) continue;
        sum += error * error;
        ++seen;
      }
      return seen === 0 ? null : 1e3 * Math.sqrt(sum / seen);
    }));
  }
  return {rows, together};
}

const SCALE_STOPS = SCALE.map((colour, i) => [i / (SCALE.length - 1), `rgb(${colour.join(',')})`]);

function drawHeatMap(replay) {
  const {rows, together} = errorRows(replay);
  plot('heat-map', [{type: 'heatmap', z: rows, x: replay.times, y: rows.map((_, i) => i * together),
    colorscale: SCALE_STOPS, zmin: 0, colorbar: {title: {text: 'mm', side: 'top'}, thickness: 12, outlinewidth: 0,
      exponentformat: 'power'}, hovertemplate: 'point %{y}, %{x:.4g} s: %{z:.3g} mm<extra></extra>'}],
  {x: {title: 'time, s', ticks: ''}, y: {title: 'point', ticks: ''}});
  part('heat-map-caption').textContent = 'Distance between recorded and predicted point; white: not seen, or a handle.' +
    (together > 1 ? ` Of ${together} points at a time the root mean square.` : '') +
    (replay.every > 1 ? ` Every ${replay.every}th frame.` : '') + ' Click to see the frame in the replay.';
}

function drawConvergence() {
  const {convergence} = data, which = part('convergence-axis').value, x = convergence[which];
  const marker = (color) => ({color, size: 8, symbol: convergence.loose.map((loose) => loose ? 'circle-open' : 'circle')});
  const charts = [['cost', convergence.cost, null],
    ...Object.entries(convergence.values).map(([name, values]) => [name, values, result.parameters[name].value])];
  const area = part('convergence');
  while (area.children.length < charts.length) area.append(element('div', 'plot'));
  charts.forEach(([name, values, final], i) => {
    const traces = [{type: 'scatter', mode: 'lines+markers', x, y: values, line: {color: COLOURS.estimate, width: 1.5},
      marker: marker(COLOURS.estimate), hovertemplate: '%{y:.8g} at %{x:.4g}<extra></extra>'}];
    if (final !== null) {
      traces.unshift({type: 'scatter', mode: 'lines', x: [x[0], x[x.length - 1]], y: [final, final], hoverinfo: 'skip',
        line: {color: COLOURS.interval, width: 1.5, dash: 'dash'}});
    }
    plot(area.children[i], traces, {x: {title: which === 'seconds' ? 'seconds' : 'iteration',
      ...(which === 'iteration' ? {tickformat: 'd', nticks: 8} : {})},
    y: {...decades(scaleOf(values)), nticks: 6}, margin: {t: 28}, title: {text: `<b>${plain(name)}</b>`, x: 0.02, y: 0.97,
      font: {size: 13}}});
  });
  const anyLoose = convergence.loose.some(Boolean);
  part('convergence-caption').textContent = 'Dashed: the estimate.' +
    (anyLoose ? ' Open circles: points that were simulated loosely, far from the solution.' : '');
}

function drawProfiles() {
  part('profiles-card').hidden = data.profiles.length === 0;
  for (const profile of data.profiles) {
    const target = element('div', 'plot'), ends = [profile.value[0], profile.value[profile.value.length - 1]];
    part('profiles').append(target);
    const estimate = result.parameters[profile.parameter].value;
    const line = (x, y, color) => ({type: 'scatter', mode: 'lines', x, y, hoverinfo: 'skip',
      line: {color, width: 1.5, dash: 'dash'}});
    plot(target, [line(ends, [profile.limit, profile.limit], COLOURS.interval),
      line([estimate, estimate], [0, Math.max(profile.limit, ...profile.rise)], COLOURS.start),
      {type: 'scatter', mode: 'lines+markers', x: profile.value, y: profile.rise, line: {color: COLOURS.estimate, width: 2},
        marker: {size: 6}, hovertemplate: '%{y:.4g} at %{x:.6g}<extra></extra>'}],
    {y: {title: 'rise', rangemode: 'tozero'}, margin: {t: 28}, title: {text: `<b>${plain(profile.parameter)}</b>`, x: 0.02,
      y: 0.97, font: {size: 13}}});
  }
}

function fillStarts() {
  part('starts-card').hidden = !result.starts;
  if (!result.starts) return;
  const names = Object.keys(result.parameters), total = result.starts.starts.length;
  fillTable('starts', ['starts that ended there', ...names, 'rmse', 'cost'], result.starts.minima.map((minimum) =>
    [`${minimum.num_starts} of ${total}`, ...names.map((name) => number(minimum.values[name], 6)),
      millimetres(minimum.rmse_m), number(minimum.cost, 5)].map((text) => element('td', 'number', text))));
}

function fillProvenance() {
  const {provenance, seconds} = result, code = (text) => {
    const cell = element('td');
    cell.append(element('code', '', text));
    return cell;
  };
  const rows = [['command line', code(`identify ${provenance.flags}`)],
    ['clothid', code(`${provenance.version}, git ${provenance.git}`)],
    ['seconds', element('td', '', `${number(seconds.total, 3)} in all: rollouts ${number(seconds.rollout, 3)}, derivatives ` +
      `${number(seconds.derivative, 3)}, solver ${number(seconds.solver, 3)}`)],
    ['work', element('td', '', `${count(result.rollouts, 'rollout')}, ${count(result.sweeps, 'sweep')}, Jacobian ` +
      `${result.jacobian}, ${count(provenance.threads, 'thread')}, seed ${provenance.seed}`)]];
  for (const recording of data.recordings) {
    const cell = element('td', '', `${recording.name}: ${count(recording.frames, 'frame')}, ${count(recording.points, 'point')}` +
      ` on a cloth of ${count(recording.nodes, 'node')}; rmse ${millimetres(recording.rmse_m)}, at the start ` +
      `${millimetres(recording.start_rmse_m)}`);
    cell.append(element('br'), element('code', '', `sha256 ${recording.sha256}`));
    rows.push(['recording', cell]);
  }
  fillTable('provenance', null, rows.map(([name, cell]) => [element('th', '', name), cell]));
}

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

async function showRecording(index) {
  const recording = data.recordings[index];
  drawPerFrame(recording);
  drawHistogram(recording);
  part('stage').hidden = part('replay-controls').hidden = false;
  part('replay-missing').hidden = true;
  state.replay = null;
  state.wanted = index;
  state.isPlaying = false;
  if (recording.replay.left_out) {
    Plotly.purge('heat-map');
    part('heat-map-caption').textContent = recording.replay.left_out;
    showMissing(recording.replay.left_out);
    return;
  }
  const replay = await unpackReplay(recording.replay);
  if (state.wanted !== index) return;
  drawHeatMap(replay);
  part('heat-map').removeAllListeners('plotly_click');
  part('heat-map').on('plotly_click', ({points}) => {
    if (!state.replay) return;
    play(false);
    showFrame(replay.times.indexOf(points[0].x));
  });
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

function listenToMouse(canvas) {
  canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons === 0 || !state.replay) return;
    if (event.shiftKey || event.buttons > 1) viewer.move(event.movementX, event.movementY);
    else viewer.turn(event.movementX, event.movementY);
    redraw();
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    viewer.zoom(Math.exp(0.001 * event.deltaY));
    redraw();
  }, {passive: false});
}

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
if (viewer) listenToMouse(part('canvas'));
setLabels();
requestAnimationFrame(advance);
select(0);

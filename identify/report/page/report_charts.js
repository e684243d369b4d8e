'use strict';
// Charts over time, points, iterations and parameters.

// A logarithmic axis where the values ask for one.
function scaleOf(values) {
  const positive = values.filter((value) => value > 0);
  if (positive.length === 0 || values.some((value) => value !== null && value < 0)) return 'linear';
  return Math.max(...positive) / Math.min(...positive) > 30 ? 'log' : 'linear';
}

// The axis of these values, logarithmic where they ask for that.
function axisOf(values) {
  if (scaleOf(values) === 'linear') return {type: 'linear'};
  const positive = values.filter((value) => value > 0);
  const tickvals = roundMarks(Math.min(...positive) / 2, Math.max(...positive) * 2, true);
  return {type: 'log', tickmode: 'array', tickvals, ticktext: tickvals.map((mark) => number(mark, 6))};
}

const inMillimetres = (values) => values.map((value) => value === null ? null : 1e3 * value);

// Lines over time in a unit, [values, name, colour] of each.
function plotOverTime(target, times, lines, unit, y) {
  plot(target, lines.map(([values, name, color]) => ({type: 'scatter', mode: 'lines', x: times, y: values, name,
    line: {color, width: 2}, hovertemplate: `%{y:.4g} ${unit} at %{x:.4g} s<extra>${name}</extra>`})),
  {x: {title: 'time, s'}, y, showlegend: true, margin: {t: 28}});
}

function drawPerFrame(recording) {
  const {times, every} = recording.per_frame;
  const [rmse, start] = [recording.per_frame.rmse, recording.per_frame.start_rmse].map(inMillimetres);
  const missed = recording.per_frame.model_error;
  const lines = [[start, 'start', COLOURS.start], [rmse, 'estimate', COLOURS.estimate]];
  if (missed) lines.push([inMillimetres(missed), 'model misses', COLOURS.missed]);
  plotOverTime('per-frame', times, lines, 'mm', {title: 'rmse, mm', ...axisOf(rmse.concat(start)), rangemode: 'tozero'});
  part('per-frame-caption').textContent = 'Root mean square distance between recorded and predicted points' +
    (every > 1 ? `, ${every} frames at a time.` : ' of every frame.') +
    (missed ? ' What the model misses is what noise does not explain; frames count for less by it.' : '');
}

function drawForces({forces}) {
  part('forces-card').hidden = !forces;
  part('forces').replaceChildren();
  for (const {group, axis, measured, predicted} of forces ? forces.components : []) {
    const target = element('div', 'plot');
    part('forces').append(target);
    plotOverTime(target, forces.times, [[measured, 'recorded', COLOURS.start], [predicted, 'predicted', COLOURS.estimate]],
      'N', {title: `${axis}${forces.groups > 1 ? ` of group ${group}` : ''}, N`});
  }
}

function drawHistogram(recording) {
  const histogram = recording.histogram;
  if (!histogram) {
    Plotly.purge('histogram');
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
  const spread = histogram.axes.map(({mean, deviation}, i) =>
    `${'xyz'[i]} ${number(1e3 * mean, 3)} ± ${millimetres(deviation)}`);
  part('histogram-caption').textContent = `Mean and standard deviation: ${spread.join(', ')}.` +
    (histogram.leaves_out_start ? ' Without the first frame, where the simulation starts.' : '') +
    (histogram.beyond > 0 ? ` Outside of the picture: ${count(histogram.beyond, 'coordinate')}.` : '');
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
    colorscale: SCALE_STOPS, zmin: 0, colorbar: {...colourBar('mm', narrow.matches), tickmode: 'auto', nticks: 6,
      exponentformat: 'power'}, hovertemplate: 'point %{y}, %{x:.4g} s: %{z:.3g} mm<extra></extra>'}],
  {x: {title: 'time, s', ticks: ''}, y: {title: 'point', ticks: ''}, margin: narrow.matches ? {b: 112} : {}});
  part('heat-map-caption').textContent = 'Distance between recorded and predicted point; white: not seen, or a handle.' +
    (together > 1 ? ` Of ${together} points at a time the root mean square.` : '') +
    (replay.every > 1 ? ` Every ${replay.every}th frame.` : '') +
    ` ${isTouch ? 'Tap' : 'Click'} to see the frame in the replay.`;
}

function drawConvergence() {
  const {convergence} = data, which = part('convergence-axis').value, x = convergence[which];
  const marker = (color) => ({color, size: 8, symbol: convergence.loose.map((loose) => loose ? 'circle-open' : 'circle')});
  const charts = [['cost', convergence.cost, null],
    ...Object.entries(convergence.values).filter(([name]) => !isCharted(name)).map(([name, values]) => [name, values, result.parameters[name].value])];
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
    y: {nticks: 6, ...axisOf(values)}, margin: {t: 28}, ...heading(name)});
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
    {y: {title: 'rise', rangemode: 'tozero'}, margin: {t: 28}, ...heading(profile.parameter)});
  }
}

// The fits with corrected rollouts, and how predictions err by their lead time.
function drawMemories() {
  const {trials = [], lead_times: ahead = []} = result.assimilation || {};
  part('memories-card').hidden = trials.length === 0;
  const add = () => part('memories').appendChild(element('div', 'plot'));
  const axis = {title: 'memory, s', type: 'log', nticks: 5};
  const memories = trials.map(({memory_s: memory}) => memory), ends = [memories[0], memories[memories.length - 1]];
  for (const name of trials.length > 0 ? Object.keys(trials[0].values) : []) {
    const values = trials.map((trial) => trial.values[name]), final = result.parameters[name].value;
    const beyond = (side, sign) => trials.map((trial, i) => sign * ((trial[side][name] ?? values[i]) - values[i]));
    plot(add(), [{type: 'scatter', mode: 'lines', x: ends, y: [final, final], hoverinfo: 'skip',
      line: {color: COLOURS.interval, width: 1.5, dash: 'dash'}},
    {type: 'scatter', mode: 'lines+markers', x: memories, y: values, line: {color: COLOURS.estimate, width: 1.5},
      marker: {size: 7}, error_y: {type: 'data', symmetric: false, array: beyond('upper95', 1),
        arrayminus: beyond('lower95', -1), color: COLOURS.estimate, thickness: 1.2},
      hovertemplate: '%{y:.6g} with %{x:.3g} s<extra></extra>'}], {x: axis, y: {nticks: 6}, margin: {t: 28},
      ...heading(name)});
  }
  if (ahead.length === 0) return;
  const leads = ahead.map(({lead_s: lead}) => lead);
  plotOverTime(add(), leads, [[inMillimetres(ahead.map(({rmse_m: rmse}) => rmse)), 'predicted', COLOURS.estimate],
    [inMillimetres(ahead.map(({still_rmse_m: still}) => still)), 'a cloth at rest', COLOURS.start]], 'mm',
  {title: 'error, mm', rangemode: 'tozero'});
}

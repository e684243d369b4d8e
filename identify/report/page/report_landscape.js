'use strict';
// Landscapes: maps of the cost over two parameters, with the estimate, its interval and the way to it.

// On a phone the legend takes this share of a map's height, at its lower end.
const LEGEND_SHARE = 0.17;

// What the colours show: the rmse in mm, where the cost tells it, else the cost.
function measureOf(landscape) {
  const factor = landscape.rmse_of_root_cost;
  if (factor === null) return {name: 'cost', title: 'cost', unit: '', of: (cost) => cost};
  return {name: 'rmse', title: 'rmse, mm', unit: ' mm', of: (cost) => 1e3 * factor * Math.sqrt(cost)};
}

const isInside = (value, values) => value >= values[0] && value <= values[values.length - 1];

function cellTraces(landscape, window, measure) {
  const {x, y} = window, nx = x.length, shown = window.cost.map((cost) => cost === null ? null : measure.of(cost));
  const names = [landscape.x, landscape.y].map(({parameter}) => plain(parameter));
  const place = (cell) => `${names[0]} ${number(x[cell % nx], 6)}, ${names[1]} ${number(y[Math.floor(cell / nx)], 6)}`;
  const texts = window.cost.map((cost, cell) => cost === null ? '' : `${place(cell)}<br>${measure.name} ` +
    `${number(shown[cell], 6)}${measure.unit}<br>cost ${number(cost, 6)}`);
  const rows = (values) => y.map((_, row) => values.slice(row * nx, (row + 1) * nx));
  const traces = [];
  if (shown.some((value) => value !== null)) {
    const bar = colourBar(measure.title, narrow.matches, LEGEND_SHARE);
    const {onScale, style} = colouring({...limitsOfRmse(shown), bar});
    traces.push({type: 'contour', x, y, z: rows(shown.map(onScale)), text: rows(texts),
      hovertemplate: '%{text}<extra></extra>', ...style});
  }
  const {cells: failed, reasons} = window.failures;
  if (failed.length > 0) {
    traces.push({type: 'scatter', mode: 'markers', name: 'failed', showlegend: true, cliponaxis: false,
      x: failed.map(([cell]) => x[cell % nx]), y: failed.map(([cell]) => y[Math.floor(cell / nx)]),
      text: failed.map(([cell, reason]) => `${place(cell)}<br>failed: ${plain(reasons[reason])}`),
      marker: {symbol: 'x', size: 7, color: MARKS.failed}, hovertemplate: '%{text}<extra></extra>'});
  }
  return traces;
}

// The points that the fit accepted, one after the other.
function pathTraces(landscape, window) {
  const {iteration, values} = data.convergence, x = values[landscape.x.parameter], y = values[landscape.y.parameter];
  const traces = [{type: 'scatter', mode: 'lines+markers', name: 'way of the fit', showlegend: true, x, y,
    text: iteration.map((i) => i === 0 ? 'start' : `iteration ${i}`), line: {color: MARKS.path, width: 1.5},
    marker: {color: MARKS.path, size: 6, line: {color: '#fff', width: 1}},
    hovertemplate: '%{text}<br>%{x:.6g}, %{y:.6g}<extra></extra>'}];
  if (isInside(x[0], window.x) && isInside(y[0], window.y)) {
    traces.push({type: 'scatter', mode: 'markers', name: 'start', showlegend: true, x: [x[0]], y: [y[0]],
      hoverinfo: 'skip', cliponaxis: false, marker: {color: '#fff', size: 10, line: {color: MARKS.path, width: 2.5}}});
  }
  return traces;
}

function estimateTraces(landscape, window) {
  const ends = (axis) => {
    const {value, lower95, upper95} = result.parameters[axis.parameter];
    const isOpen = lower95 === null || upper95 === null;
    return {value, bar: isOpen ? {visible: false} : {type: 'data', symmetric: false, array: [upper95 - value],
      arrayminus: [value - lower95], color: MARKS.estimate, thickness: 1.5, width: 4}};
  };
  const x = ends(landscape.x), y = ends(landscape.y), traces = [];
  if (landscape.region) {
    traces.push({type: 'scatter', mode: 'lines', name: '95 % region', showlegend: true, ...landscape.region,
      hoverinfo: 'skip', line: {color: MARKS.estimate, width: 1.5, dash: 'dot'}});
  }
  if (isInside(x.value, window.x) && isInside(y.value, window.y)) {
    traces.push({type: 'scatter', mode: 'markers', name: 'estimate', showlegend: true, x: [x.value], y: [y.value],
      error_x: x.bar, error_y: y.bar, cliponaxis: false,
      marker: {symbol: 'star', color: MARKS.estimate, size: 14, line: {color: '#fff', width: 1}},
      hovertemplate: 'estimate<br>%{x:.6g}, %{y:.6g}<extra></extra>'});
  }
  return traces;
}

// The share of an axis that `values` span.
function shareOf(axis, values, window) {
  const onScale = axis.scale === 'log' ? Math.log : (value) => value;
  return (onScale(Math.max(...values)) - onScale(Math.min(...values))) /
    (onScale(window[window.length - 1]) - onScale(window[0]));
}

// Where the lowest cell is, and what else the map of one window tells.
function windowCaption(landscape, window, measure) {
  const names = [landscape.x, landscape.y].map(({parameter}) => parameter), lines = [];
  const joined = (values, between, separator) =>
    names.map((name, i) => name + between + number(values[i], 4)).join(separator);
  const lowest = window.cost.reduce((best, cost, cell) =>
    cost !== null && (best < 0 || cost < window.cost[best]) ? cell : best, -1);
  if (lowest < 0) return ['Every cell failed.'];
  const place = [window.x[lowest % window.x.length], window.y[Math.floor(lowest / window.x.length)]];
  const value = measure.of(window.cost[lowest]), estimate = landscape.estimate_rmse_m;
  lines.push(`Lowest cell: ${number(value, 4)}${measure.unit} at ${joined(place, ' ', ', ')}.`);
  // By more than what contours can show, and a hundredth.
  const highest = measure.of(extent(window.cost)[1]);
  if (estimate !== null && value < 1e3 * estimate - Math.max(10 * estimate, LEAST_RMSE_SHARE * highest)) {
    lines.push(`That is below the estimate's ${millimetres(estimate)}: a fit from there may end lower, --start ` +
      `${joined(place, '=', ',')}.`);
  }
  const failed = window.failures.cells.length;
  if (failed > 0) lines.push(`${failed} of ${count(window.cost.length, 'cell')} failed.`);
  const values = names.map((name) => result.parameters[name].value);
  if (!isInside(values[0], window.x) || !isInside(values[1], window.y)) lines.push('The estimate lies outside.');
  else if (!landscape.region) lines.push('No region of 95 %: not both parameters have an interval.');
  else if (['x', 'y'].every((which) => shareOf(landscape[which], landscape.region[which], window[which]) < 0.02)) {
    lines.push('The 95 % region is smaller than the star.');
  }
  return lines;
}

function drawMap(landscape, window, measure) {
  const box = element('div'), target = element('div', 'plot map');
  box.append(target, element('p', 'caption', windowCaption(landscape, window, measure).join(' ')));
  const name = window.zoom === 1 ? '' : `<b>zoom: ${number(window.zoom, 4)} of either axis</b>`;
  const title = name ? {title: {text: name, x: 0.02, y: 0.98, font: {size: 13}}} : {};
  const draw = () => plot(target, [...cellTraces(landscape, window, measure), ...pathTraces(landscape, window),
    ...estimateTraces(landscape, window)], {x: mapAxis(landscape.x, window.x), y: mapAxis(landscape.y, window.y),
    showlegend: true, ...title, ...(narrow.matches ? {margin: {t: name ? 36 : 10, b: 175, r: 10},
      legend: {orientation: 'h', x: 0, y: 0, yref: 'container', yanchor: 'bottom'}} : {margin: {t: name ? 64 : 40}})});
  return {box, draw};
}

function landscapeCaption(landscape, measure) {
  const colours = measure.name === 'rmse' ? 'Root mean square distance between recorded and predicted points'
    : 'The cost: half the sum of squared residuals in standard deviations, without a robust loss';
  return [`${colours}, at every cell of a scan; contours between them are interpolated.`,
    'Star: the estimate with its 95 % intervals' +
      (landscape.region ? '; dotted: the region that holds both parameters with 95 %.' : '.'),
    ...landscape.notes].join(' ');
}

function showLandscape(landscape, index) {
  const measure = measureOf(landscape), card = element('section', 'card'), maps = element('div', 'multiples');
  card.id = `landscape-${index}`;
  maps.style.gridTemplateColumns = landscape.windows.length === 1 ? 'minmax(0, 720px)'
    : 'repeat(auto-fit, minmax(min(100%, 440px), 1fr))';
  const made = landscape.windows.map((window) => drawMap(landscape, window, measure));
  maps.append(...made.map(({box}) => box));
  card.append(element('h2', '', `Landscape of ${landscape.x.parameter} and ${landscape.y.parameter}`), maps,
    element('p', 'caption', landscapeCaption(landscape, measure)));
  part('starts-card').before(card);
  made.forEach(({draw}) => draw());
  narrow.addEventListener('change', () => made.forEach(({draw}) => draw()));
}

data.landscapes.forEach(showLandscape);

'use strict';
// What the pages share: charts, and maps of the cost over two parameters.

const FONT = {family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: 12, color: '#1f2630'};
const PLAIN_AXIS = {gridcolor: '#e9edf1', zerolinecolor: '#cfd6de', linecolor: '#cfd6de', ticks: 'outside', ticklen: 4,
  tickcolor: '#cfd6de', exponentformat: 'power', automargin: true};

// Into an element, or the one of that id.
function plot(target, traces, {x = {}, y = {}, margin = {}, ...more}) {
  const box = typeof target === 'string' ? part(target) : target;
  // A finger that moves over a chart scrolls the page.
  const held = isTouch ? {fixedrange: true} : {};
  const axis = (own) => ({...PLAIN_AXIS, ...held, ...own, title: {text: own.title || '', standoff: 6}});
  const layout = {font: FONT, margin: {l: 56, r: 14, t: 10, b: 40, ...margin}, paper_bgcolor: '#fff',
    plot_bgcolor: '#fff', showlegend: false, legend: {orientation: 'h', x: 0, y: 1.02, yanchor: 'bottom'}, xaxis: axis(x), yaxis: axis(y),
    dragmode: isTouch ? false : 'zoom', ...more};
  // A colour bar that goes elsewhere would leave its margin behind.
  const bars = traces.map(({colorbar}) => colorbar?.orientation || 'v').join();
  if (box.bars !== undefined && box.bars !== bars) Plotly.purge(box);
  box.bars = bars;
  return Plotly.react(box, traces, layout, {displayModeBar: false, responsive: true});
}

// What heads a chart, in its upper corner.
const heading = (name) => ({title: {text: `<b>${plain(name)}</b>`, x: 0.02, y: 0.97, font: {size: 13}}});

// Round numbers from `low` to `high`, about six.
function roundMarks(low, high, isLog) {
  const marks = [], ratio = high / low;
  if (isLog && ratio > 4) {
    const every = Math.ceil(Math.log10(ratio) / 6), factors = ratio > 1e3 ? [1] : ratio > 50 ? [1, 3] : [1, 2, 5];
    for (let power = every * Math.floor(Math.log10(low) / every); power <= Math.log10(high); power += every) {
      marks.push(...factors.map((factor) => Number((factor * 10 ** power).toPrecision(6))));
    }
  } else {
    const rough = (high - low) / 7, unit = 10 ** Math.floor(Math.log10(rough));
    const step = unit * [1, 2, 5, 10].find((factor) => factor * unit >= rough * (1 - 1e-9));
    for (let i = Math.ceil(low / step); i * step <= high; ++i) marks.push(Number((i * step).toPrecision(12)));
  }
  return marks.filter((mark) => mark >= low && mark <= high);
}

// Colours of a map from low to high: the valley is light, what is drawn over it dark or orange.
const DEPTHS = [[0, '#ffffe3'], [0.14, '#e3f3bd'], [0.3, '#aadcb8'], [0.46, '#60c0c1'], [0.62, '#2f96bd'],
  [0.8, '#2460a0'], [1, '#14285e']];
const MARKS = {estimate: '#1f2630', path: '#d9661f', failed: '#b3261e'};
const BAR = {thickness: 12, outlinewidth: 0, tickmode: 'array'};

// The colour bar: beside a map, or below it where that is narrow, `above` of the picture's height over its lower end.
function colourBar(title, isBelow, above = 0.04) {
  if (!isBelow) return {...BAR, title: {text: title, side: 'top'}, xpad: 6};
  // Plotly puts the title of one line onto such a bar.
  return {...BAR, title: {text: `${title}<br> `, side: 'top', font: {size: 11}}, orientation: 'h', yref: 'container',
    y: above, yanchor: 'bottom', x: 0.5, len: 1, ypad: 0, tickangle: 0};
}

// A mark of a colour bar, where there is little room.
const shortNumber = (value) => Math.abs(value) >= 1e4 ? value.toExponential().replace('e+', 'e') : number(value, 6);

// Below this share of the largest value, and below half of the next to lowest, logarithmic colours end: the lowest cell
// itself may be zero.
const LEAST_RMSE_SHARE = 1e-3;

function limitsOfRmse(values) {
  const [lowest, high] = extent(values), isLog = high > 30 * lowest;
  const [next] = extent(values.filter((value) => value > lowest));
  return {low: isLog ? Math.max(lowest, LEAST_RMSE_SHARE * high, next / 2) : lowest, high, isLog};
}

// Every so many-th of `marks`, so that there are at most `most`.
function sparse(marks, most) {
  const every = Math.ceil(marks.length / most);
  return marks.filter((_, i) => i % every === 0);
}

// Colours and 20 contours from `low` to `high`, on a logarithmic scale below whose low end colours are the same.
function colouring({low, high, isLog, bar}) {
  const onScale = isLog ? (value) => value === null ? null : Math.log10(Math.max(value, low)) : (value) => value;
  const size = (onScale(high) - onScale(low)) / 20, plainStyle = {colorscale: DEPTHS,
    line: {width: 0.5, color: 'rgba(31,38,48,0.35)'}};
  if (!(size > 0)) return {onScale, style: {...plainStyle, showscale: false, contours: {coloring: 'fill'}}};
  const marks = sparse(roundMarks(low, high, isLog), bar.orientation === 'h' ? 5 : 8);
  return {onScale, style: {...plainStyle, autocontour: false, zmin: onScale(low), zmax: onScale(high),
    contours: {start: onScale(low) + size, end: onScale(high) - size / 2, size},
    colorbar: {...bar, tickvals: marks.map(onScale), ticktext: marks.map(shortNumber)}}};
}

const titleOf = (axis) => {
  const unit = parameterUnit(axis.parameter);
  return plain(axis.parameter) + (unit ? `, ${unit}` : '');
};

// The axis as far as it was scanned.
function mapAxis(axis, values) {
  const ends = [values[0], values[values.length - 1]], isLog = axis.scale === 'log';
  const marks = isLog ? {tickmode: 'array', tickvals: roundMarks(...ends, true)} : {nticks: 6};
  if (isLog) marks.ticktext = marks.tickvals.map((mark) => number(mark, 6));
  // A little further, so that rounding leaves no mark of a cell at the edge outside.
  const [low, high] = isLog ? ends.map(Math.log10) : ends, further = 1e-6 * (high - low);
  return {title: titleOf(axis), type: isLog ? 'log' : 'linear', range: [low - further, high + further], ...marks,
    showgrid: false, zeroline: false};
}

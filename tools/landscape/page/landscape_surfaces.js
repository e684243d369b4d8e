'use strict';
// Surfaces in 3D. A browser has few WebGL contexts and there may be many surfaces. So this page has two: Plotly's
// hidden one, which makes an image of every surface, and that of one plot, which takes the place of the image that was
// clicked.

const hasWebGl = (() => {
  const context = document.createElement('canvas').getContext('webgl');
  if (!context) return false;
  context.getExtension('WEBGL_lose_context')?.loseContext();
  return true;
})();

const turning = {plot: element('div'), panel: null};
turning.plot.style.height = '100%';
const SURFACE_AXIS = {tickfont: {size: 10.5}, gridcolor: '#dde3ea', zeroline: false, tickmode: 'array'};
let camera = {eye: {x: -1.55, y: -1.8, z: 1.1}, center: {x: 0, y: 0, z: -0.1}};
let drawing = Promise.resolve();

// Plotly's surfaces have no log axes: they stand on the logarithm, marked with the values.
const onSurface = (which, value) => summary[which].scale === 'log' ? Math.log10(value) : value;
function surfaceAxis(which, window) {
  const marks = roundMarks(...window[which], summary[which].scale === 'log');
  return {...SURFACE_AXIS, title: {text: plain(summary[which].parameter), font: {size: 12}},
    range: window[which].map((value) => onSurface(which, value)),
    tickvals: marks.map((mark) => onSurface(which, mark)), ticktext: marks.map((mark) => number(mark, 6))};
}

function surfaceMark(x, y, z, marker) {
  return {type: 'scatter3d', mode: 'markers', x: [onSurface('x', x)], y: [onSurface('y', y)], z: [z], hoverinfo: 'skip',
    marker};
}

function surfaceFigure(panel) {
  const {window, windowIndex} = panel, shown = shownOf(panel), limits = measure.limits(shown);
  const {onScale, style} = colouring({...limits, bar: BAR}), heights = shown.map(onScale), lowest = onScale(limits.low);
  const along = (which) => data[which][windowIndex].map((value) => onSurface(which, value));
  const marks = limits.high > limits.low ? roundMarks(limits.low, limits.high, limits.isLog) : [];
  const traces = [{type: 'surface', x: along('x'), y: along('y'), z: grid(heights), text: grid(cellTexts(panel)),
    colorscale: DEPTHS, cmin: style.zmin, cmax: style.zmax, showscale: false, hovertemplate: '%{text}<extra></extra>',
    lighting: {ambient: 0.8, diffuse: 0.5, specular: 0.05}},
  surfaceMark(window.minimum.x, window.minimum.y, lowest, {symbol: 'diamond', color: MARKS.estimate, size: 5})];
  if (showsTruth(panel)) {
    traces.push(surfaceMark(data.truth.x, data.truth.y, lowest, {symbol: 'circle-open', color: MARKS.path, size: 9}));
  }
  const layout = {font: FONT, margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, paper_bgcolor: '#fff',
    scene: {camera, aspectmode: 'manual', aspectratio: {x: 1, y: 1, z: 0.75},
      xaxis: surfaceAxis('x', window), yaxis: surfaceAxis('y', window),
      zaxis: {...SURFACE_AXIS, title: {text: ''}, tickvals: marks.map(onScale),
        ticktext: marks.map(shortNumber)}}};
  return {data: traces, layout};
}

function drawImage(panel) {
  if (panel.queued || panel === turning.panel) return;
  panel.queued = true;
  drawing = drawing.then(async () => {
    panel.queued = panel.staleSurface = false;
    const {clientWidth: width, clientHeight: height} = panel.surface;
    if (width === 0) return;
    const address = await Plotly.toImage(surfaceFigure(panel), {format: 'png', width, height, scale: 2});
    if (panel === turning.panel) return;
    const image = element('img'), button = element('button');
    image.src = address;
    image.alt = `Surface of the cost: ${windowName(panel.window)}`;
    button.type = 'button';
    button.title = `${isTouch ? 'Tap' : 'Click'} to turn it`;
    button.append(image);
    button.addEventListener('click', () => turn(panel));
    panel.surface.replaceChildren(button);
  }).catch((error) => panel.surface.replaceChildren(`The surface could not be drawn: ${error}`));
}

async function turn(panel) {
  const before = turning.panel;
  turning.panel = panel;
  if (before && before !== panel) drawImage(before);
  panel.surface.replaceChildren(turning.plot);
  const {data: traces, layout} = surfaceFigure(panel);
  await Plotly.react(turning.plot, traces, layout, {displaylogo: false, displayModeBar: false, responsive: true});
  if (!before) turning.plot.on('plotly_relayout', takeCamera);
}

function takeCamera(change) {
  if (!change['scene.camera']) return;
  camera = change['scene.camera'];
  redraw({maps: false, surfaces: true});
}

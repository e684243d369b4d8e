'use strict';
// The map of one window of one setting: contours, the lowest cell, the truth, and cells that failed.

// Narrower maps, px, have their colour bar below.
const NARROW_MAP = 400;

function markTrace(name, x, y, marker, more) {
  return {type: 'scatter', mode: 'markers', name, x, y, marker, hoverinfo: 'skip', cliponaxis: false, ...more};
}

function mapTraces(panel, isNarrow) {
  const {cells, window, windowIndex} = panel, texts = cellTexts(panel), nx = summary.x.cells;
  const x = data.x[windowIndex], y = data.y[windowIndex], shown = shownOf(panel), traces = [];
  const failed = cells.cost.flatMap((cost, cell) => cost === null ? [cell] : []);
  const hovertemplate = '%{text}<extra></extra>';
  if (window.minimum.cost !== null) {
    const {onScale, style} = colouring({...measure.limits(shown), bar: colourBar(measure.title, isNarrow)});
    traces.push({type: 'contour', x, y, z: grid(shown.map(onScale)), text: grid(texts), hovertemplate, ...style});
  }
  traces.push(markTrace('failed', failed.map((cell) => x[cell % nx]), failed.map((cell) => y[Math.floor(cell / nx)]),
    {symbol: 'x', size: 7, color: MARKS.failed},
    {hoverinfo: 'text', text: failed.map((cell) => texts[cell]), hovertemplate}));
  if (showsTruth(panel)) {
    traces.push(markTrace('truth', [data.truth.x], [data.truth.y],
      {symbol: 'circle-open', color: MARKS.path, size: 19, line: {width: 3}}));
  }
  if (window.minimum.cost !== null) {
    traces.push(markTrace('lowest cell', [window.minimum.x], [window.minimum.y],
      {symbol: 'star', color: MARKS.estimate, size: 13, line: {color: '#fff', width: 1}}));
  }
  return traces;
}

function drawMap(panel) {
  const isNarrow = panel.contours.clientWidth < NARROW_MAP, {windowIndex} = panel;
  plot(panel.contours, mapTraces(panel, isNarrow), {x: mapAxis(summary.x, data.x[windowIndex]),
    y: mapAxis(summary.y, data.y[windowIndex]), margin: isNarrow ? {t: 10, r: 12, b: 108} : {t: 10}});
}

'use strict';
// Fields: constants that vary over the cloth, as maps on its rest shape, hatched where the recordings do not tell them.

// Half of a cell.
const halfOf = ({x, y}) => (x.length > 1 ? x[1] - x[0] : y[1] - y[0]) / 2;

// Lines from corner to corner of every other diagonal of cells: one hatching over all that are not determined.
function hatching({x, y, determined}) {
  const half = halfOf({x, y}), lines = {x: [], y: []};
  determined.forEach((row, i) => row.forEach((known, j) => {
    if (known !== 0 || (i + 2 * x.length - j) % 3 !== 0) return;
    lines.x.push(x[j] - half, x[j] + half, null);
    lines.y.push(y[i] - half, y[i] + half, null);
  }));
  return lines;
}

function fieldTraces(field) {
  const unit = UNITS[field.name], [low, high] = extent(field.value.flat()), isLog = high > 4 * low;
  const onScale = (value) => value === null ? null : isLog ? Math.log10(value) : value;
  const marks = high > low ? sparse(roundMarks(low, high, isLog), narrow.matches ? 5 : 8) : [low];
  const sure = (i, j) => field.std ? `<br>± ${number(100 * field.std[i][j], 2)} %` +
    (field.determined[i][j] ? '' : '<br>not determined by the recordings') : '';
  const texts = field.value.map((row, i) => row.map((value, j) => value === null ? ''
    : `${field.name} ${number(value, 4)} ${unit}${sure(i, j)}`));
  const traces = [{type: 'heatmap', x: field.x, y: field.y, z: field.value.map((row) => row.map(onScale)), text: texts,
    zmin: onScale(low), zmax: onScale(high), colorscale: DEPTHS, hoverongaps: false,
    hovertemplate: '%{text}<extra></extra>', colorbar: {...colourBar(`${field.name}, ${unit}`, narrow.matches, 0.02),
      tickvals: marks.map(onScale), ticktext: marks.map(shortNumber)}}];
  if (field.determined && field.determined.flat().includes(0)) {
    const pale = 'rgba(232,236,240,0.65)';
    const z = field.determined.map((row) => row.map((known) => known === 0 ? 1 : null));
    traces.push({type: 'heatmap', x: field.x, y: field.y, z, colorscale: [[0, pale], [1, pale]], showscale: false,
      hoverinfo: 'skip'}, {type: 'scatter', mode: 'lines', name: 'not determined', showlegend: true,
    ...hatching(field), hoverinfo: 'skip', line: {color: 'rgba(31,38,48,0.55)', width: 1}});
  }
  traces.push({type: 'scatter', mode: 'lines', ...field.outline, hoverinfo: 'skip', showlegend: false,
    line: {color: MARKS.estimate, width: 1.2}});
  return traces;
}

function fieldCaption(field) {
  const sure = field.determined
    ? 'Hatched: the recordings do not determine it there, and it is what was believed beforehand: smooth.'
    : 'How sure it is was not estimated.';
  return `On the cloth at rest, seen from the front. ${sure} ${field.line}.`;
}

function showField(field, index) {
  const card = element('section', 'card'), target = element('div', 'plot map');
  card.id = `field-${index}`;
  target.style.maxWidth = '560px';  // bar and legend stay beside a square cloth
  card.append(element('h2', '', `Field of ${field.name}`), target, element('p', 'caption', fieldCaption(field)));
  part('heat-map').closest('.card').before(card);
  const axis = (centres) => ({title: 'm', constrain: 'domain', showgrid: false, zeroline: false, nticks: 6,
    range: [-halfOf(field), centres[centres.length - 1] + 2 * halfOf(field)]});
  const draw = () => plot(target, fieldTraces(field), {x: axis(field.x), y: {...axis(field.y), scaleanchor: 'x'},
    showlegend: true, margin: narrow.matches ? {t: 36, b: 120, r: 10} : {t: 36}});
  draw();
  narrow.addEventListener('change', draw);
}

data.fields.forEach(showField);

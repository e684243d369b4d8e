'use strict';
// The card of a cloth: its constants, the curves that told them, and how it was measured.

const data = JSON.parse(document.getElementById('data').textContent);
const {card, curves} = data;
const CURVE_COLOURS = {measured: '#2d5f9a', fitted: '#e58a3c'};
const LAWS = {arap: 'isotropic (arap)', orthotropic: 'orthotropic, along warp and weft',
  yarn: 'yarns that stiffen, along warp and weft'};
const KNOWN = {fitted: 'fitted', believed: 'believed before the fit, which did not look', assumed: 'not told: assumed, or at a bound'};

const cell = (text, kind = 'number') => element('td', kind, text);
const range = (from, to, digits) => from === null ? '–' : `${number(from, digits)} … ${number(to, digits)}`;

function seenText({seen}) {
  if (!seen) return '–';
  if (seen.quantity === 'strain') return `strain ${range(100 * seen.from, 100 * seen.to, 3)} %`;
  return `curvature ${range(seen.from, seen.to, 3)} 1/m`;
}

function scatterText(name, {scatter, unit}) {
  if (scatter === null) return '–';
  return name === 'k_poisson' ? `${number(scatter, 2)} ${unit}` : `${number(100 * Math.expm1(scatter), 2)} %`;
}

fillTable('constants', ['constant', 'value', '95 % interval', 'specimens differ by', 'seen at', 'known'],
  Object.entries(card.constants).map(([name, constant]) => {
    const title = element('td', '', `${name} `);
    title.append(element('span', 'unit', constant.unit));
    return [title, cell(number(constant.value, 5), 'number estimate'), cell(range(constant.lower95, constant.upper95, 4)),
      cell(scatterText(name, constant)), cell(seenText(constant)), cell(KNOWN[constant.known], '')];
  }));
part('law').textContent = `Law of the membrane: ${LAWS[card.membrane]}. A constant means nothing under another law, and ` +
  'little beyond the range in which it was seen: strains and curvatures that all but 1 % of the cloth and the time ' +
  'stayed between.';

fillTable('recordings', ['recording', 'kind', 'mesh', 'time step', 'largest load'], card.recordings.map((recording) => {
  const name = element('td', '', recording.name);
  name.append(element('br'), element('code', '', `sha256 ${recording.sha256}`));
  return [name, cell(recording.kind, ''), cell(`${count(recording.nodes, 'node')}, edges of ${millimetres(recording.edge_m)}`),
    cell(`${number(1e3 * recording.time_step_s, 4)} ms`),
    cell(recording.load_N === null ? '–' : `${number(recording.load_N, 4)} N`)];
}));

part('curves-card').hidden = curves.length === 0;
for (const {name, strain, measured, fitted} of curves) {
  const box = element('div'), chart = element('div', 'lines');
  box.append(element('h3', '', name), chart);
  part('curves').append(box);
  const show = lineChart(chart, {name: 'force', unit: 'N', along: 'strain', times: strain, lines: {measured, fitted},
    colours: CURVE_COLOURS, jump: (at) => show(at)});
  show(strain[strain.length - 1]);
}

part('about').textContent = card.recordings.map(({name}) => name).join(', ');
document.title += `: ${part('about').textContent}`;

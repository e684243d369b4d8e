'use strict';
// The data of the page, whose names and texts are shown and never run, and what puts numbers and tables into it.

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

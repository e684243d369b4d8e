'use strict';
// What the pages share: numbers in words, elements, and how a page is held.

const part = (id) => document.getElementById(id);
// Plotly would take tags in names for its own.
const plain = (text) => String(text).replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');
const UNITS = {k_stretch: 'N/m', k_bend: 'N m', density: 'kg/m²', drag: 'kg/(m² s)', damping: 'N s/m',
  k_warp: 'N/m', k_weft: 'N/m', k_shear: 'N/m', k_poisson: 'N/m', bend_warp: 'N m', bend_weft: 'N m',
  bend_twist: 'N m', added_mass: 'kg/m²', pressure: 'Pa', 'wind.x': 'm/s', 'wind.y': 'm/s', 'wind.z': 'm/s', 'gust.x': 'm/s',
  'gust.y': 'm/s', 'gust.z': 'm/s', 'gust.frequency': 'rad/s', 'gust.phase': 'rad',
  'gust.wave.x': 'rad/m', 'gust.wave.y': 'rad/m', 'gust.wave.z': 'rad/m', 'wind.shear.x': '1/m', 'wind.shear.y': '1/m',
  'wind.shear.z': '1/m'};
// Of a parameter, whichever recording or knot of the wind it belongs to; none of drag_normal and drag_tangential, whose
// unit depends on the law of the air.
const parameterUnit = (name) => UNITS[name.replace(/@.*/, '').replace(/\.\d+$/, '')] || '';

function number(value, digits) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  const size = Math.abs(value);
  if (size >= 1e7 || (size < 1e-4 && size > 0)) {
    return value.toExponential(digits - 1).replace(/(\.\d*?)0*e/, '$1e').replace('.e', 'e').replace('e+', 'e');
  }
  return Number(value.toPrecision(digits)).toString();
}
const millimetres = (metres) => metres === null || metres === undefined ? '–' : `${number(1e3 * metres, 4)} mm`;
const count = (n, word) => `${n} ${word}${n === 1 ? '' : 's'}`;

// The least and the largest of a list, however long; what failed, null, is left out.
function extent(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return [low, high];
}

function element(tag, className, text) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined) made.textContent = text;
  return made;
}

// The name of SVG's space, which is an address, as the browser spells it: the page holds none.
const SVG_SPACE = (() => {
  const box = element('div');
  box.innerHTML = '<svg></svg>';
  return box.firstChild.namespaceURI;
})();

function svgElement(tag, attributes, text) {
  const made = document.createElementNS(SVG_SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

// An entry of the <select> of that id.
function addOption(id, value, text, selected = false) {
  const made = element('option', '', text);
  made.value = value;
  made.selected = selected;
  part(id).append(made);
}

// The mark of a colour in a legend.
function swatch(colour) {
  const made = element('span', 'swatch');
  made.style.background = colour;
  return made;
}

// Where the head has no room, each cell says what it is.
function fillTable(id, head, rows) {
  const made = rows.map((cells) => {
    const row = element('tr');
    row.append(...cells);
    if (head) cells.forEach((cell, i) => { cell.dataset.label = head[i]; });
    return row;
  });
  if (head) {
    const row = element('tr');
    row.append(...head.map((text) => element('th', '', text)));
    made.unshift(row);
  }
  part(id).replaceChildren(...made);
}

// A finger cannot hover, turn a wheel or hold a key; a phone is too narrow for what stands beside a picture.
const isTouch = matchMedia('(pointer: coarse)').matches;
const narrow = matchMedia('(max-width: 640px)');

'use strict';
// The data of the page, whose names and texts are shown and never run, and what puts numbers and tables into it.

const data = JSON.parse(document.getElementById('data').textContent);
const result = data.result;
// Knots of a wind over time, which has charts of its own.
const isCharted = (name) => result.wind !== undefined && /^wind\.[xyz]\.\d+(@\d+)?$/.test(name);
const COLOURS = {estimate: '#2d5f9a', start: '#a3adb8', interval: '#e58a3c', missed: '#8a6bb0'};

const percent = (share) => share === null || share === undefined ? '–' : `${number(share, 5)} %`;
// "71 to 100 %" of two shares.
const rangeText = ([low, high]) => `${number(100 * low, 3)} to ${percent(100 * high)}`;

function fillList(id, lines) {
  part(id).replaceChildren(...lines.map((line) => element('li', '', line)));
}

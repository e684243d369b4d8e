'use strict';
// What the page shows: names, the values behind the colours, and what is said of a cell.

const data = JSON.parse(part('data').textContent);
const summary = data.summary;

const settingName = (setting) => `${setting.name || 'scene as it is'}, ${setting.contact} mode`;
const windowName = (window) => window.zoom === 1 ? 'Whole range' : `Zoom ${number(window.zoom, 4)}`;
const unitOf = (which) => ` ${parameterUnit(summary[which].parameter)}`.trimEnd();
const valueOf = (which, value, digits) => `${summary[which].parameter} ${number(value, digits)}${unitOf(which)}`;
const placeOf = (x, y, digits = 5) => `${valueOf('x', x, digits)}, ${valueOf('y', y, digits)}`;
const rangeOf = (window) => ['x', 'y'].map((which) => summary[which].parameter + ' ' +
  window[which].map((end) => number(end, 5)).join(' … ') + unitOf(which)).join(', ');

// [ny][nx] of a list with x fastest.
function grid(values) {
  const nx = summary.x.cells;
  return Array.from({length: summary.y.cells}, (_, j) => values.slice(j * nx, (j + 1) * nx));
}

// Colours of the cost above the lowest cell: half the step to the next cell, but no less than this share of the range,
// is where they end. The lowest cell itself would be at minus infinity.
const LEAST_SHARE = 1e-4;

function limitsAbove(values) {
  const [next, high] = extent(values.filter((value) => value > 0)), isLog = high > 0;
  return isLog ? {low: Math.max(LEAST_SHARE * high, next / 2), high, isLog} : {low: 0, high: 0, isLog};
}

function limitsOfCost(values) {
  const [low, high] = extent(values);
  return {low, high, isLog: false};
}

// What colours and heights can show of a cost, the first unless asked otherwise.
const MEASURES = {
  above: {option: 'cost above the lowest cell, logarithmic', title: 'above lowest', unit: '', limits: limitsAbove,
    of: (cost, lowest) => cost - lowest,
    guide: 'Colours tell how far the cost of a cell is above that of the lowest one, on a logarithmic scale'},
  cost: {option: 'cost', title: 'cost', unit: '', limits: limitsOfCost, of: (cost) => cost,
    guide: 'Colours tell the cost of a cell'},
};
const rmseOfRootCost = data.sigma ? data.sigma.rmse_of_root_cost_m : null;
if (rmseOfRootCost !== null) {
  MEASURES.rmse = {option: 'rmse, mm', title: 'rmse, mm', unit: ' mm', limits: limitsOfRmse,
    of: (cost) => 1e3 * rmseOfRootCost * Math.sqrt(cost),
    guide: 'Colours tell the root mean square distance between recorded and predicted points'};
}
let measure = MEASURES.above;

// Of a panel, by cell; null: failed.
function shownOf({cells}) {
  const [lowest] = extent(cells.cost);
  return cells.cost.map((cost) => cost === null ? null : measure.of(cost, lowest));
}

// What is told of every cell that is pointed at.
function cellTexts({cells, windowIndex}) {
  const nx = summary.x.cells, [lowest] = extent(cells.cost);
  return cells.cost.map((cost, cell) => {
    const lines = [plain(valueOf('x', data.x[windowIndex][cell % nx], 7)),
      plain(valueOf('y', data.y[windowIndex][Math.floor(cell / nx)], 7))];
    if (cost === null) return lines.concat(`failed: ${plain(cells.failure[cell] || '')}`).join('<br>');
    lines.push(`cost ${number(cost, 7)}, ${number(cost - lowest, 4)} above the lowest`);
    if (rmseOfRootCost !== null) lines.push(`rmse ${number(MEASURES.rmse.of(cost), 4)} mm`);
    lines.push(count(cells.changes[cell], 'contact event'));
    if (cells.gradient_x) {
      lines.push(`gradient ${number(cells.gradient_x[cell], 5)}, ${number(cells.gradient_y[cell], 5)}`);
    }
    return lines.join('<br>');
  });
}

const isInside = (value, [lower, upper]) => value >= lower && value <= upper;
const showsTruth = ({window}) =>
  data.truth !== null && isInside(data.truth.x, window.x) && isInside(data.truth.y, window.y);

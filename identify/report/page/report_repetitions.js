'use strict';
// Repetitions: of every parameter a forest plot, a table in whose rows the intervals are drawn on one axis.

const LARGEST_SQUARE = 14, SMALLEST_SQUARE = 4;  // px
// How far beyond the estimates that are pooled the axis may reach, in their range.
const AXIS_REACH = 2;
const MARK_ROOM = 18;  // percent of the axis

const isNumber = (value) => Number.isFinite(value);
const isToldBy = (estimate, isLog) => estimate !== null && isNumber(estimate.value) && estimate.std > 0 &&
  (!isLog || estimate.value > 0);

// In the coordinate: 0.12 of a logarithm is 12 %.
function differenceText(value, isLog, unit) {
  if (isLog) return `${number(100 * value, 2)} %`;
  return unit ? `${number(value, 2)} ${unit}` : number(value, 2);
}

// Those of rising marks whose texts have room beside each other.
function spaced(marks, at) {
  const kept = [];
  for (const mark of marks) {
    if (kept.length === 0 || at(mark) - at(kept[kept.length - 1]) > MARK_ROOM) kept.push(mark);
  }
  return kept;
}

// The axis of a parameter, logarithmic for a scale: from values to percent of its width. Intervals that reach much
// farther than the estimates lie apart, as those from very few recordings do, end at its ends.
function forestAxis(intervals, core, isLog) {
  const coordinate = isLog ? Math.log : (value) => value;
  const isOnScale = (value) => isNumber(value) && (!isLog || value > 0);
  const [first, last] = extent(core.filter(isOnScale).map(coordinate));
  const reach = AXIS_REACH * (last - first || 1e-3 * Math.abs(first) || 1);
  const all = intervals.flat().filter(isOnScale).map((value) =>
    Math.min(Math.max(coordinate(value), first - reach), last + reach));
  const [lowest, highest] = extent(all), room = 0.04 * (highest - lowest || reach);
  const low = lowest - room, high = highest + room, ends = isLog ? [low, high].map(Math.exp) : [low, high];
  const at = (value) => !isNumber(value) ? NaN : isOnScale(value) ? 100 * (coordinate(value) - low) / (high - low) : -1;
  const round = roundMarks(...ends, isLog);
  return {at, marks: spaced(round.length > 2 ? round : roundMarks(...ends, false), at)};
}

// As large as its cell, whose width is that of the axis; words beside it say the same.
const emptyPicture = () => svgElement('svg', {class: 'forest', 'aria-hidden': 'true'});

function forestPicture(axis, mean) {
  const picture = emptyPicture(), add = (value, className) => {
    const x = `${axis.at(value)}%`;
    picture.append(svgElement('line', {class: className, x1: x, x2: x, y1: 0, y2: '100%'}));
  };
  for (const mark of axis.marks) add(mark, 'grid');
  if (isNumber(mean)) add(mean, 'mean');
  return picture;
}

// A shape in px around a place.
function addShape(picture, place, path, className) {
  const around = svgElement('svg', {x: `${place}%`, y: '50%', overflow: 'visible'});
  around.append(svgElement('path', {d: path, class: className}));
  picture.append(around);
}

// Where an interval goes on beyond the axis.
function addArrows(picture, [left, right]) {
  if (left < 0) addShape(picture, 0, 'M7 -5L1 0L7 5', 'arrow');
  if (right > 100) addShape(picture, 100, 'M-7 -5L-1 0L-7 5', 'arrow');
}

function addInterval(picture, axis, {lower95, upper95}, className) {
  const ends = [axis.at(lower95), axis.at(upper95)];
  if (!ends.every(isNumber)) return;
  const [x1, x2] = ends.map((place) => `${Math.min(Math.max(place, 0), 100)}%`);
  picture.append(svgElement('line', {class: className, x1, x2, y1: '50%', y2: '50%'}));
  addArrows(picture, ends);
}

const isSeen = (place) => place >= 0 && place <= 100;

function addSquare(picture, axis, value, share, className) {
  const half = Math.max(LARGEST_SQUARE * Math.sqrt(share), SMALLEST_SQUARE) / 2, place = axis.at(value);
  if (isSeen(place)) addShape(picture, place, `M${-half} ${-half}H${half}V${half}H${-half}Z`, className);
}

// As wide as the interval of the mean.
function addDiamond(picture, axis, {mean, lower95, upper95}) {
  const [left, middle, right] = [lower95, mean, upper95].map(axis.at);
  for (const [x, width, path] of [[left, middle - left, 'M0 0L1 -7V7Z'], [middle, right - middle, 'M1 0L0 -7V7Z']]) {
    const half = svgElement('svg', {x: `${x}%`, y: 0, width: `${width}%`, height: '100%', viewBox: '0 -12 1 24',
      preserveAspectRatio: 'none'});
    half.append(svgElement('path', {d: path, class: 'diamond'}));
    picture.append(half);
  }
  addArrows(picture, [left, right]);
}

// Why an estimate is not pooled; empty: it is.
function whyNotPooled(estimate, whyNotUsed, name, {pooled, scale}) {
  if (whyNotUsed !== null) return 'not used';
  if (estimate === null) return `has no ${name}`;
  if (!isToldBy(estimate, scale === 'log')) return `does not tell ${name} alone`;
  return pooled < 2 ? `alone in telling ${name}` : '';
}

// "50.3 (48.1 … 52.7)", or what there is of it.
function intervalWords(value, lower95, upper95) {
  const hasInterval = isNumber(lower95) && isNumber(upper95);
  const digits = hasInterval ? digitsOf((lower95 + upper95) / 2, (upper95 - lower95) / 3.92) : 6;
  const bounds = hasInterval ? `${number(lower95, digits)} … ${number(upper95, digits)}` : '–';
  return isNumber(value) ? [element('b', '', number(value, digits)), ` (${bounds})`] : [bounds];
}

// One row: who, the estimate with its interval in words and drawn, its weight.
function forestRow(title, remark, {value, lower95, upper95}, picture, weight, kind = '') {
  const who = element('td', `who ${kind}`, title), chart = element('td', 'chart');
  if (remark) who.append(' ', element('span', kind === 'misfit' ? 'remark bad' : 'remark', remark));
  chart.append(picture);
  const numbers = element('td', 'number');
  numbers.append(...intervalWords(value, lower95, upper95));
  return [who, numbers, chart, element('td', 'number weight', weight === null ? '' : `${number(100 * weight, 2)} %`)];
}

function recordingRow(recording, estimate, name, parameter, axis) {
  const picture = forestPicture(axis, parameter.mean);
  const why = whyNotPooled(estimate, recording.why_not_used, name, parameter);
  const isOff = estimate !== null && estimate.fits === false, weight = estimate === null ? null : estimate.weight;
  const kind = why ? 'unused' : isOff ? 'misfit' : '';
  const remark = isOff ? 'does not fit the others: ' +
    `${number(Math.abs(estimate.deviation), 3)} joint standard deviations from their mean` : why;
  if (estimate !== null) {
    const largest = Math.max(...parameter.estimates.map((other) => other?.weight || 0));
    addInterval(picture, axis, estimate, `interval ${kind}`);
    addSquare(picture, axis, estimate.value, weight === null ? 0.2 : weight / largest, `square ${kind}`);
  }
  return forestRow(recording.name, remark, estimate || {}, picture, weight, kind);
}

function pooledRows(parameter, joint, axis) {
  const rows = [], add = (title, remark, numbers, draw) => {
    const picture = forestPicture(axis, parameter.mean);
    draw(picture);
    rows.push(forestRow(title, remark, numbers, picture, null, 'pooled'));
  };
  if (isNumber(parameter.mean)) {
    add('Mean', `of ${count(parameter.pooled, 'recording')}`,
      {value: parameter.mean, lower95: parameter.lower95, upper95: parameter.upper95},
      (picture) => addDiamond(picture, axis, parameter));
    const next = {lower95: parameter.next_lower95, upper95: parameter.next_upper95};
    add('Next specimen', isNumber(next.lower95) ? '' : 'told by three recordings or more', next,
      (picture) => addInterval(picture, axis, next, 'next'));
  }
  if (joint) {
    add('Joint fit', 'of all recordings as one', joint, (picture) => {
      addInterval(picture, axis, joint, 'interval joint');
      if (isSeen(axis.at(joint.value))) addShape(picture, axis.at(joint.value), 'M-5 -5L5 5M-5 5L5 -5', 'joint');
    });
  }
  return rows;
}

function axisRow(axis, title) {
  const picture = emptyPicture(), chart = element('td', 'chart axis');
  for (const mark of axis.marks) {
    const place = axis.at(mark), anchor = place < 4 ? 'start' : place > 96 ? 'end' : 'middle';
    picture.append(svgElement('text', {x: `${place}%`, y: 14, 'text-anchor': anchor}, shortNumber(mark)));
  }
  picture.append(svgElement('text', {x: '50%', y: 31, 'text-anchor': 'middle'}, title));
  chart.append(picture);
  return [element('td'), element('td'), chart, element('td')];
}

function axisFor(parameter, joint) {
  const isLog = parameter.scale === 'log', {estimates} = parameter;
  const ends = ({value, lower95, upper95}) => [value, lower95, upper95].filter(isNumber);
  const told = estimates.filter((estimate) => estimate?.weight > 0);
  const basis = told.length > 0 ? told : estimates.filter((estimate) => isToldBy(estimate, isLog));
  const surest = basis.reduce((best, other) => other.std / (isLog ? other.value : 1) <
    best.std / (isLog ? best.value : 1) ? other : best);
  const core = [...basis.map(({value}) => value), ...ends(surest), ...(joint ? [joint.value] : [])];
  const next = [parameter.next_lower95, parameter.next_upper95];
  return forestAxis([core, ...basis.map(ends), ends({...parameter, value: parameter.mean}), next,
    ...(joint ? [ends(joint)] : [])], core, isLog);
}

// The deviation between recordings and what says that it is none of chance.
function scatterText(parameter, unit) {
  const text = (value) => differenceText(value, parameter.scale === 'log', unit), q = parameter.cochran_q;
  const common = parameter.common_error > 0
    ? ` The error of time step and mesh, ${text(parameter.common_error)}, is common to all.` : '';
  const chance = parameter.p_value < 1e-6 ? 'p below 1e-6' : `p ${number(parameter.p_value, 2)}`;
  const bounds = `${text(parameter.scatter_lower95)} … ${text(parameter.scatter_upper95)}`;
  return `Deviation between recordings: ${text(parameter.scatter)}, 95 % interval ${bounds}; their own intervals ` +
    `explain ${text(parameter.typical_std)}. Cochran's Q: ${number(q, 4)} with ` +
    `${count(parameter.pooled - 1, 'degree')} of freedom, ${chance}.${common}`;
}

function showParameter(card, name, parameter, recordings, index) {
  const title = element('h3', '', `${name} `), unit = parameterUnit(name), isLog = parameter.scale === 'log';
  title.append(element('span', 'unit', unit));
  card.append(title, element('p', 'sentence', data.repetition_lines[name]));
  if (!parameter.estimates.some((estimate) => isToldBy(estimate, isLog))) return;
  const joint = result.status === 'pooled' ? null : result.parameters[name] || null, axis = axisFor(parameter, joint);
  const table = element('table', 'stacked forest-table');
  table.id = `repetitions-${index}`;
  card.append(table);
  const rows = recordings.map((recording, r) => recordingRow(recording, parameter.estimates[r], name, parameter, axis));
  fillTable(table.id, ['recording', 'estimate, 95 % interval', '', 'weight'],
    [...rows, ...pooledRows(parameter, joint, axis), axisRow(axis, unit ? `${name}, ${unit}` : name)]);
  if (parameter.pooled > 1) card.append(element('p', 'figures', scatterText(parameter, unit)));
}

function showRepetitions({recordings, parameters}) {
  const card = element('section', 'card'), unused = recordings.filter(({why_not_used: why}) => why !== null);
  card.id = 'repetitions';
  card.append(element('h2', '', 'Repetitions'));
  (document.querySelector('.pair') || part('provenance').closest('.card')).before(card);
  if (unused.length > 0) {
    const list = element('ul');
    list.append(...unused.map(({name, why_not_used: why}) => element('li', '', `${name} is not used: ${why}`)));
    card.append(list);
  }
  Object.entries(parameters).forEach(([name, parameter], i) => showParameter(card, name, parameter, recordings, i));
  card.append(element('p', 'caption', 'Each recording fitted for itself, in brackets 95 % intervals. Squares: the ' +
    'estimates, the larger the more they weigh, red where one does not fit the others, hollow where it is not ' +
    'pooled; lines: their intervals. Diamond: the mean, as wide as its interval; dashed: the mean again. Bar: the ' +
    'interval of the true value of the next specimen.' + (result.status === 'pooled' ? '' : ' Cross: the joint fit.') +
    ' An arrow: the interval goes on.'));
}

showRepetitions(result.repetitions);

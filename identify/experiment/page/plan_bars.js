'use strict';
// What is expected of every parameter: the motion that tells it best, and intervals as bars on an axis of their own.

const data = JSON.parse(part('data').textContent);
const ran = data.candidates.filter(({failure}) => failure === null);

const pairName = ({candidates}) => candidates.join(' and ');

const withUnit = (text, name) => `${text} ${parameterUnit(name)}`.trim();
const intervalText = (name, {lower95, upper95}) => withUnit(`${number(lower95, 4)} .. ${number(upper95, 4)}`, name);

// A standard deviation of q: of a logarithm as a share, which may be large.
function deviation(name, scale, std) {
  if (scale !== 'log') return withUnit(`± ${number(std, 2)}`, name);
  return std < 1 ? `± ${number(100 * std, 2)} %` : `by a factor of ${number(Math.exp(Math.min(std, 700)), 2)}`;
}

function partsText(name, {scale, std: noise, step_error: step, told_share: share}, cloths) {
  const words = [`noise ${deviation(name, scale, noise)}`];
  if (step !== null) words.push(`step ${deviation(name, scale, step)}`);
  if (share < 1) words.push(`told in ${Math.round(share * cloths)} of ${cloths} cloths`);
  return words.join(', ');
}

function fillBest() {
  const rows = data.parameters.map((name) => {
    const {candidate, pair} = data.best[name], best = data.candidates[candidate], both = data.pairs[pair];
    const cells = [element('td', '', name), element('td', 'estimate', best ? best.name : 'none tells it'),
      element('td', 'number', best ? intervalText(name, best.parameters[name]) : '–'),
      element('td', '', both ? pairName(both) : '–')];
    if (both) cells[3].append(element('span', 'unit', ` ${intervalText(name, both.parameters[name])}`));
    return cells;
  });
  const head = ['parameter', 'best motion', '95 % interval', 'best pair'];
  if (data.num_pairs === 0) {
    head.pop();
    for (const cells of rows) cells.pop();
  }
  fillTable('best', head, rows);
}

// Every candidate that ran, and the best pair: {who, expected, cloths, isBest, isPair}.
function rowsOf(name) {
  const {candidate, pair} = data.best[name], both = data.pairs[pair];
  const rows = ran.map((own) => ({who: own.name, expected: own.parameters[name], cloths: own.cloths,
    isBest: own === data.candidates[candidate]}));
  if (both) rows.push({who: pairName(both), expected: both.parameters[name], cloths: both.cloths, isPair: true});
  return rows;
}

// The axis of all intervals: {at: value => share of the width, marks}; null where nothing is told.
function axisOf(rows) {
  const told = rows.map(({expected}) => expected).filter((expected) => expected.told);
  if (told.length === 0) return null;
  const isLog = told[0].scale === 'log', onScale = isLog ? Math.log : (value) => value;
  const [low, high] = roomAround(extent(told.flatMap(({lower95, upper95, value}) =>
    [lower95, upper95, value].map(onScale))));
  const marks = sparse(isLog ? roundMarks(Math.exp(low), Math.exp(high), true) : roundMarks(low, high, false), 5);
  return {marks, at: (value) => (onScale(value) - low) / (high - low)};
}

function placed(className, left, width) {
  const made = element('span', className);
  made.style.left = `${(100 * left).toFixed(3)}%`;
  if (width !== undefined) made.style.width = `${(100 * width).toFixed(3)}%`;
  return made;
}

// The picture alone: the words beside it say as much.
function track({told, in_scene: isThere, lower95, upper95, value}, axis) {
  const made = element('div', `track ${told ? '' : isThere ? 'untold' : 'absent'}`);
  made.setAttribute('aria-hidden', 'true');
  if (!told) return made;
  for (const mark of axis.marks) made.append(placed('line', axis.at(mark)));
  made.append(placed('bar', axis.at(lower95), axis.at(upper95) - axis.at(lower95)), placed('nominal', axis.at(value)));
  return made;
}

function words(name, expected, cloths) {
  const made = element('div', 'what');
  if (expected.told) {
    made.append(element('strong', '', intervalText(name, expected)),
      element('span', 'why', partsText(name, expected, cloths)));
    return made;
  }
  made.append(`not told: ${expected.not_told}`);
  if (expected.made_up_by) made.append(element('span', 'why', `made up for by ${expected.made_up_by}`));
  return made;
}

function parameterBars(name) {
  const rows = rowsOf(name), axis = axisOf(rows), unit = parameterUnit(name), made = element('section', 'parameter');
  const title = element('h3', '', name), list = element('ul', 'bars');
  if (unit) title.append(element('span', 'unit', ` ${unit}`));
  for (const {who, expected, cloths, isBest, isPair} of rows) {
    const item = element('li', [isBest && 'is-best', isPair && 'is-pair'].filter(Boolean).join(' '));
    item.append(element('span', 'who', who + (isBest ? ' (best)' : isPair ? ' (best pair)' : '')),
      track(expected, axis), words(name, expected, cloths));
    list.append(item);
  }
  made.append(title, list);
  if (axis) {
    const line = element('div', 'axis'), numbers = element('div', 'numbers');
    for (const mark of axis.marks) {
      const text = placed('', axis.at(mark));
      text.textContent = number(mark, 6);
      numbers.append(text);
    }
    line.setAttribute('aria-hidden', 'true');
    line.append(numbers);
    made.append(line);
  }
  return made;
}

function fillBars() {
  part('intervals').replaceChildren(...(ran.length > 0 ? data.parameters.map(parameterBars) : []));
  part('bars-caption').textContent = 'About the nominal value, the black line, each parameter on an axis of its own. ' +
    'Noise and step: standard deviations from the noise of the recording and from the time step. Hatched: not told.';
}

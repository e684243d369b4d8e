'use strict';
// What was found, in words and tables: verdict, estimates, tiles, other minima, provenance.

const USABLE = {'yes': ['usable', 'good'], 'with care': ['usable with care', 'warn'], 'no': ['do not use', 'bad']};

// The page is about `names`.
function fillVerdict(names) {
  let [words, kind] = USABLE[result.usable];
  if (result.usable === 'with care' && result.verdict[0].startsWith('do not use')) words = 'use in part';
  if (!['converged', 'pooled'].includes(result.status)) words += `: ${result.status.replace('_', ' ')}`;
  part('status').textContent = words;
  part('status').classList.add(kind);
  part('overall').textContent = result.verdict[0];
  part('overall').classList.add(kind);
  part('about').textContent = names;
  document.title += `: ${names}`;
  fillList('verdict', result.verdict.slice(1));
}

function fillHead() {
  fillVerdict(data.recordings.map((recording) => recording.name).join(', '));
  fillList('limits', data.limits.length > 0 ? data.limits : ['Nothing that can be told.']);
}

// As many digits as tell the ends of an interval apart.
function digitsOf(value, std) {
  const relative = std > 0 ? std / Math.max(Math.abs(value), std) : 0;
  return Math.min(Math.max(2 + Math.ceil(-Math.log10(relative + 2e-16)), 3), 9);
}

function interval(parameter) {
  const {std: noise, lower95, upper95} = parameter;
  if (noise === null && lower95 !== null && upper95 !== null) return `${number(lower95, 5)} … ${number(upper95, 5)}`;
  if (noise === null && lower95 !== null) return `≥ ${number(lower95, 5)}`;
  if (noise === null) return upper95 !== null ? `≤ ${number(upper95, 5)}` : '–';
  const std = Math.hypot(parameter.std, parameter.step_error || 0, parameter.mesh_error || 0);
  const digits = digitsOf(parameter.value, std);
  return `${number(parameter.lower95, digits)} … ${number(parameter.upper95, digits)}`;
}

function fillEstimates() {
  const rows = Object.entries(result.parameters).filter(([name]) => !isCharted(name)).map(([name, parameter]) => {
    const title = element('td', '', `${name} `);
    title.append(element('span', 'unit', parameterUnit(name)));
    const estimate = element('td', 'number estimate', number(parameter.value, 8));
    estimate.dataset.parameter = name;
    const bounds = element('td', 'number', interval(parameter));
    const kind = parameter.usable === 'no' ? 'remark bad' : 'remark';
    if (data.remarks[name]) bounds.append(' ', element('span', kind, data.remarks[name]));
    return [title, estimate, bounds, element('td', 'number', number(parameter.start, 6))];
  });
  fillTable('estimates', ['parameter', 'estimate', '95 % interval', 'start'], rows);
  const isKnown = data.recordings.every((recording) => recording.sigma_is_known);
  const noise = isKnown ? 'Intervals follow from the noise that the recordings state.'
    : 'Intervals take the remaining error for noise: the recordings do not state any.';
  const has = (part) => Object.values(result.parameters).some((parameter) => Number.isFinite(parameter[part]));
  const parts = [has('step_error') && 'the time step', has('mesh_error') && 'the mesh'].filter(Boolean);
  part('estimates-caption').textContent =
    parts.length > 0 ? `${noise} They count with the errors of ${parts.join(' and ')}, too.` : noise;
}

function fillTiles() {
  const holdout = result.holdout, seconds = result.seconds.total;
  const tiles = [['rmse', millimetres(result.rmse_m), `start: ${millimetres(data.start_rmse_m)}`, 'rmse'],
    ['fit', percent(result.fit_percent), `start: ${percent(data.start_fit_percent)}; 0 %: a cloth at rest`, 'fit'],
    ['run time', `${number(seconds, 3)} s`, `${count(result.iterations, 'iteration')}, ${count(result.rollouts, 'rollout')}`,
      'seconds']];
  if (holdout) {
    tiles.push(['rmse held out', millimetres(holdout.rmse_m), `nominal: ${millimetres(holdout.nominal_rmse_m)}`, 'holdout']);
    const bands = holdout.bands;
    if (bands && Number.isFinite(bands.inside)) {
      tiles.push(['bands of 90 % held', percent(100 * bands.inside),
        `of what was held out, by ${count(bands.draws, 'rollout')}; a right prediction: ` +
          rangeText(bands.inside_if_right), 'bands']);
    }
  }
  part('tiles').replaceChildren(...tiles.map(([what, value, beside, id]) => {
    const tile = element('div', 'tile');
    const shown = element('div', 'value', value);
    shown.id = `tile-${id}`;
    tile.append(element('div', 'what', what), shown, element('div', 'beside', beside));
    return tile;
  }));
}

function fillStarts() {
  part('starts-card').hidden = !result.starts;
  if (!result.starts) return;
  const names = Object.keys(result.parameters), total = result.starts.starts.length;
  fillTable('starts', ['starts that ended there', ...names, 'rmse', 'cost'], result.starts.minima.map((minimum) =>
    [`${minimum.num_starts} of ${total}`, ...names.map((name) => number(minimum.values[name], 6)),
      millimetres(minimum.rmse_m), number(minimum.cost, 5)].map((text) => element('td', 'number', text))));
}

function codeCell(text) {
  const cell = element('td');
  cell.append(element('code', '', text));
  return cell;
}

const originRows = ({flags, version, git}) =>
  [['command line', codeCell(`identify ${flags}`)], ['clothid', codeCell(`${version}, git ${git}`)]];

const fillOrigin = (rows) =>
  fillTable('provenance', null, rows.map(([name, cell]) => [element('th', '', name), cell]));

function fillProvenance() {
  const {provenance, seconds} = result;
  const rows = [...originRows(provenance),
    ['seconds', element('td', '', `${number(seconds.total, 3)} in all; summed over recordings: rollouts ` +
      `${number(seconds.rollout, 3)}, derivatives ${number(seconds.derivative, 3)}; solver ${number(seconds.solver, 3)}`)],
    ['work', element('td', '', `${count(result.rollouts, 'rollout')}, ${count(result.sweeps, 'sweep')}, Jacobian ` +
      `${result.jacobian}, ${count(provenance.threads, 'thread')}, seed ${provenance.seed}`)]];
  for (const recording of data.recordings) {
    const cell = element('td', '', `${recording.name}: ${count(recording.frames, 'frame')}, ${count(recording.points, 'point')}` +
      ` on a cloth of ${count(recording.nodes, 'node')}; rmse ${millimetres(recording.rmse_m)}, at the start ` +
      `${millimetres(recording.start_rmse_m)}`);
    cell.append(element('br'), element('code', '', `sha256 ${recording.sha256}`));
    rows.push(['recording', cell]);
  }
  fillOrigin(rows);
}

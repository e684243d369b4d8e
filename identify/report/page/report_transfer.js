'use strict';
// Who predicts whom: a row per fitted recording, a column per predicted one.

function transferCell(predicted, unit) {
  const cell = element('td', '', `${number(100 * predicted.inside, 3)} %`);
  const length = (value) => unit === 'N' ? `${number(value, 3)} N` : millimetres(value);
  const until = predicted.worth_until_s;
  const worth = until === null ? 'to the end' : `${number(until, 3)} s`;
  const [near, far] = predicted.median_rmse_if_right;
  cell.append(element('br'), element('span', 'unit', `right: ${rangeText(predicted.inside_if_right)}; misses by ` +
    `${length(predicted.median_rmse)}, right: ${length(near)} to ${length(far)}; CRPS ${length(predicted.crps)}, ± ` +
    `${length(predicted.half_width)}; worth something ${worth}`));
  return cell;
}

function showTransfer(rows) {
  const card = element('section', 'card'), table = element('table', 'stacked');
  card.id = 'transfer';
  table.id = 'transfer-table';
  card.append(element('h2', '', 'Who predicts whom'), table);
  (document.querySelector('.pair') || part('provenance').closest('.card')).before(card);
  const find = (row, name) => row.predicted.find((predicted) => predicted.name === name);
  const empty = (row, name) => element('td', '', row.name === name ? '' : row.why_not || '–');
  fillTable(table.id, ['fitted', ...rows.map(({name}) => name)], rows.map((row) => [element('td', '', row.name),
    ...rows.map(({name}) => find(row, name) ? transferCell(find(row, name), row.unit) : empty(row, name))]));
  card.append(element('p', 'caption', 'Each recording was fitted for itself and predicts the others, which it has ' +
    'not seen: so much of them lies in bands of 90 %. Right: where that lies for a right prediction, nine ' +
    'times in ten, as errors of one motion go together. Missed: by the median of the bands, as root mean square of a ' +
    'coordinate. Worth something: until when, over the time so far, that is less than a cloth misses that stays ' +
    'where it starts.'));
}

showTransfer(result.transfer);

'use strict';
// The page of a scan: a panel for every window of every setting, drawn when it comes into sight.

const panels = [];

function drawWhatIsStale(panel) {
  if (!panel.isVisible) return;
  if (panel.staleMap && panel.contours.clientWidth > 0) {
    panel.staleMap = false;
    drawMap(panel);
  }
  if (!panel.staleSurface || !panel.hasSurface || panel.surface.clientWidth === 0) return;
  drawImage(panel);
}

function redraw({maps, surfaces}) {
  for (const panel of panels) {
    panel.staleMap = panel.staleMap || maps;
    panel.staleSurface = panel.staleSurface || surfaces;
    drawWhatIsStale(panel);
  }
}

const sight = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    const panel = panels.find((candidate) => candidate.card === entry.target);
    panel.isVisible = entry.isIntersecting;
    drawWhatIsStale(panel);
  }
}, {rootMargin: '300px'});

// Pictures are as wide as their panel.
const widths = new ResizeObserver((entries) => {
  for (const entry of entries) {
    const panel = panels.find((candidate) => candidate.card === entry.target);
    if (Math.abs(panel.width - entry.contentRect.width) < 2) continue;
    panel.width = entry.contentRect.width;
    panel.staleMap = panel.staleSurface = true;
    drawWhatIsStale(panel);
  }
});

function mark(kind, sign, text) {
  const item = element('li');
  item.append(element('span', `sign ${kind}`, sign), element('span', '', text));
  return item;
}

function marksOf(panel) {
  const {window} = panel, list = element('ul', 'marks'), lowest = window.minimum;
  if (lowest.cost !== null) {
    const rmse = rmseOfRootCost === null ? '' : `, rmse ${number(MEASURES.rmse.of(lowest.cost), 4)} mm`;
    list.append(mark('lowest', '★',
      `lowest cell: ${placeOf(lowest.x, lowest.y)}; cost ${number(lowest.cost, 5)}${rmse}`));
  }
  if (showsTruth(panel)) list.append(mark('truth', '◯', `truth: ${placeOf(data.truth.x, data.truth.y)}`));
  if (window.failed_cells > 0) {
    list.append(mark('failed', '✕', `${window.failed_cells} of ${count(window.cells, 'cell')} failed`));
  }
  return list;
}

function captionOf({roughness, per_rollout: perRollout}) {
  const parts = [`roughness ${number(roughness.off_quadratic, 2)}`,
    `second differences ${number(roughness.second_difference, 2)}`];
  if (roughness.gradient_gap !== null) parts.push(`gradient gap ${number(roughness.gradient_gap, 2)}`);
  parts.push(`${number(perRollout.contact_changes, 4)} contact events per rollout`);
  return parts.join(', ') + (roughness.missing ? ` (${roughness.missing})` : '');
}

function makePanel(title, window, windowIndex, cells) {
  const panel = {window, windowIndex, cells, card: element('section', 'card panel'), width: 0, staleMap: true,
    staleSurface: true, isVisible: false, contours: element('div', 'contours')};
  const views = element('div', 'views');
  panel.hasSurface = hasWebGl && window.minimum.cost !== null;
  panel.surface = element('div', 'surface', panel.hasSurface ? 'drawing …'
    : hasWebGl ? '' : 'This browser has no WebGL, which surfaces need; landscape.png shows them.');
  views.append(panel.contours, panel.surface);
  panel.card.append(element('h3', '', title), views, marksOf(panel), element('p', 'caption', captionOf(window)));
  panels.push(panel);
  sight.observe(panel.card);
  widths.observe(panel.card);
  return panel.card;
}

// Windows below each other, settings side by side; where there is one setting, its windows.
function makeGroups() {
  const {settings} = summary, {windows} = settings[0], isOne = settings.length === 1;
  document.body.classList.toggle('wide', settings.length > 3);
  const makeGroup = (title, cards) => {
    const group = element('div', 'group'), area = element('div', 'panels');
    area.append(...cards);
    group.append(element('h2', '', title), area);
    part('groups').append(group);
  };
  const cellsOf = (setting, window) => data.cells[setting * windows.length + window];
  const titled = (window) => `${windowName(window)}: ${rangeOf(window)}`;
  if (isOne) {
    makeGroup('', windows.map((window, w) => makePanel(titled(window), window, w, cellsOf(0, w))));
    return;
  }
  windows.forEach((window, w) => makeGroup(titled(window), settings.map((setting, s) =>
    makePanel(settingName(setting), setting.windows[w], w, cellsOf(s, w)))));
}

function makeNumbers() {
  const columns = [
    ['minimum', (w) => number(w.minimum.cost, 5)],
    [`at ${summary.x.parameter}`, (w) => number(w.minimum.x, 5)],
    [`at ${summary.y.parameter}`, (w) => number(w.minimum.y, 5)],
    ['range', (w) => number(w.range, 3)],
    ['roughness', (w) => number(w.roughness.off_quadratic, 3)],
    ['second differences', (w) => number(w.roughness.second_difference, 3)],
    ['gradient gap', (w) => number(w.roughness.gradient_gap, 3)],
    ['contact events', (w) => number(w.per_rollout.contact_changes, 5)],
    ['joined', (w) => number(w.per_rollout.nodes_joined, 4)],
    ['left', (w) => number(w.per_rollout.nodes_left, 4)],
    ['branch switches', (w) => number(w.per_rollout.branch_switches, 4)],
    ['obstacle switches', (w) => number(w.per_rollout.obstacle_switches, 4)],
    ['contacts per step', (w) => number(w.contacts_per_step, 4)],
    ['failed cells', (w) => `${w.failed_cells} of ${w.cells}`],
    ['substeps', (w) => w.substeps.toString()],
  ];
  const rows = summary.settings.flatMap((setting) => setting.windows.map((window) =>
    [element('td', '', settingName(setting)), element('td', '', windowName(window)),
      ...columns.map(([, value]) => element('td', 'number', value(window)))]));
  fillTable('numbers', ['setting', 'window', ...columns.map(([name]) => name)], rows);
}

const SIGMA_SOURCES = {recorded: 'as recorded', given: 'given by --sigma', estimated: 'estimated from the recording',
  unknown: 'a guess: the recording states none, and --sigma was not given'};
function sigmaText(sigma) {
  if (!sigma) return 'that of the recording';
  const size = sigma.sigma_m === null ? 'different from point to point' : millimetres(sigma.sigma_m);
  return `${size}, ${SIGMA_SOURCES[sigma.source]}`;
}

function makeProvenance() {
  const {provenance, sigma} = data, rows = [['clothid', `${provenance.version}, git ${provenance.git}`],
    ['recording', `sha256 ${provenance.input_sha256}`], ['sigma of a coordinate', sigmaText(sigma)]];
  const truth = Object.entries(provenance.truth);
  if (truth.length > 0) {
    rows.push(['truth', `${truth.map(([name, value]) => `${name} ${number(value, 7)}`).join(', ')}: ` +
      'its own motion is compared with, in place of the recorded one']);
  }
  fillTable('provenance', null, rows.map(([name, text]) => [element('th', '', name), element('td', '', text)]));
}

function fillHead() {
  const {x, y, settings} = summary, windows = settings.flatMap((setting) => setting.windows);
  const sum = (of) => windows.reduce((total, window) => total + of(window), 0);
  const failed = sum((window) => window.failed_cells), cells = sum((window) => window.cells);
  part('status').textContent = failed > 0 ? `${failed} of ${cells} cells failed` : 'every cell simulated';
  part('status').classList.add(failed === cells ? 'bad' : failed > 0 ? 'warn' : 'good');
  part('about').textContent = `${x.parameter} and ${y.parameter}: ${count(settings.length, 'setting')}, ` +
    `${count(settings[0].windows.length, 'window')} of ${x.cells} × ${y.cells} cells`;
  document.title = `Landscape of the cost over ${x.parameter} and ${y.parameter}`;
  const [point, click] = isTouch ? ['Tap', 'tap'] : ['Point at', 'click'];
  part('hint').textContent = `Contours between cells are interpolated. ${point} a map for the values of a cell; ${click} a ` +
    'surface to turn it, which turns all others along.';
}

function showMeasure(name) {
  measure = MEASURES[name];
  part('guide').textContent = `${measure.guide}: the light valley is where both parameters fit best. The cost is half ` +
    'the sum of squared residuals in standard deviations.';
  redraw({maps: true, surfaces: true});
  if (turning.panel) turn(turning.panel);
}

function makeControls() {
  for (const [name, {option}] of Object.entries(MEASURES)) addOption('measure', name, option);
  part('measure').addEventListener('change', (event) => showMeasure(event.target.value));
  const show = () => {
    part('groups').className = part('show').value;
    redraw({maps: false, surfaces: false});
  };
  // On a phone surfaces would be far below each other.
  part('show').value = narrow.matches ? 'maps' : 'both';
  part('show').addEventListener('change', show);
  part('licences-details').addEventListener('toggle', () => {
    part('licences-shown').textContent = part('licences').textContent;
  });
  show();
}

fillHead();
makeGroups();
makeNumbers();
makeProvenance();
makeControls();
showMeasure('above');

'use strict';
// The motions side by side: replays of the nominal cloths in the colours of what each node tells, and curves of what
// each frame tells. All of them share one canvas of WebGL, and a clock while they are in step.

const UNSEEN_COLOUR = [0.72, 0.74, 0.77], DECADES = 3, INFORMATION = {'': '#8a6bb0'};
const panels = [];
// Where all are while they are in step, s since their starts.
const clock = {time: 0, isPlaying: false, last: 0};

const isInStep = () => part('in-step').checked;
const longest = () => Math.max(...panels.map(({length}) => length), 0);

// Information [J d]^2 of a node: what colour it has, and how well it would tell the parameter if it were alone.
function columnOf({candidate}, name) { return candidate.information.parameters[name]; }

function largestOf(panel, name) {
  if (part('colours').value === 'own') return columnOf(panel, name)?.largest || 0;
  return Math.max(...panels.map((other) => columnOf(other, name)?.largest || 0));
}

async function colourNodes(panel, name) {
  const column = columnOf(panel, name), largest = largestOf(panel, name), {replay} = panel;
  panel.fillKey(name, column, largest);
  if (!replay) return;
  replay.colours = uniformColours(replay.points, UNSEEN_COLOUR);
  if (column && column.largest > 0) {
    const values = await unpackErrors(column.nodes, column.largest);
    values.forEach((value, node) => replay.colours.set(
      errorColour(1 + Math.log10(value / largest) / DECADES), 3 * node));
  }
  panel.isDirty = true;
}

// What the colours mean, in words of a fit: a node that tells i has the standard deviation 1/sqrt(i).
function keyOf(target, candidate) {
  return (name, column, largest) => {
    target.replaceChildren();
    if (!column || !(column.largest > 0)) {
      target.append(`${name}: ${column ? 'no node tells it' : 'its scene does not have it'}`);
      return;
    }
    const {scale} = candidate.parameters[name], bar = element('span', 'scale');
    bar.style.background = `linear-gradient(to right, ${SCALE.map((c) => `rgb(${c})`).join(', ')})`;
    const alone = (information) => deviation(name, scale, 1 / Math.sqrt(information));
    target.append('one node alone: ', alone(largest / 10 ** DECADES), bar, alone(largest));
  };
}

function makeButton(text, act) {
  const made = element('button', '', text);
  made.type = 'button';
  made.addEventListener('click', act);
  return made;
}

function playPanel(panel, isPlaying) {
  panel.isPlaying = isPlaying;
  panel.button.textContent = isPlaying ? 'Pause' : 'Play';
  panel.button.setAttribute('aria-label', `${isPlaying ? 'Pause' : 'Play'} ${panel.candidate.name}`);
  if (isPlaying && panel.time >= panel.length) showTime(panel, 0);
}

// `time`: s since its start.
function showTime(panel, time) {
  panel.time = Math.min(Math.max(time, 0), panel.length);
  panel.scrubber.value = panel.time;
  if (!panel.replay) return;
  const {times} = panel.replay, frame = frameAt(times, times[0] + panel.time + 1e-9);
  panel.label.textContent = `${times[frame].toFixed(3)} s`;
  if (panel.moveMark) panel.moveMark(times[frame]);
  panel.isDirty ||= frame !== panel.frame;
  panel.frame = frame;
}

function playAll(isPlaying) {
  clock.isPlaying = isPlaying;
  part('play').textContent = isPlaying ? 'Pause' : 'Play';
  if (isPlaying && clock.time >= longest()) clock.time = 0;
  for (const panel of panels) playPanel(panel, isPlaying);
}

function showAll(time) {
  clock.time = Math.min(Math.max(time, 0), longest());
  part('scrubber').value = clock.time;
  part('time').textContent = `${clock.time.toFixed(2)} s of ${longest().toFixed(2)} s`;
  for (const panel of panels) showTime(panel, clock.time);
}

// Where one motion is told to go, and with it all that are in step.
function jump(panel, time) {
  if (isInStep()) {
    playAll(false);
    showAll(time);
  } else {
    playPanel(panel, false);
    showTime(panel, time);
  }
}

function isVisible(canvas) {
  const box = canvas.getBoundingClientRect();
  return box.bottom > 0 && box.top < innerHeight;
}

function advance(now) {
  const elapsed = Math.min(now - clock.last, 250) / 1e3 * Number(part('speed').value);
  clock.last = now;
  if (isInStep() && clock.isPlaying) {
    showAll(clock.time >= longest() ? 0 : clock.time + elapsed);
  } else if (!isInStep()) {
    for (const panel of panels) {
      if (panel.isPlaying) showTime(panel, panel.time >= panel.length ? 0 : panel.time + elapsed);
    }
  }
  for (const panel of panels) {
    if (!panel.isDirty || !panel.replay || !isVisible(panel.canvas)) continue;
    panel.isDirty = false;
    panel.viewer.draw(panel.frame, {});
  }
  requestAnimationFrame(advance);
}

// What would help, the best first.
function improvementList({improvements, parameters, worst_told: worst}) {
  const helping = improvements.filter(({factors, tells}) => tells.length > 0 ||
    Object.entries(factors).some(([name, factor]) => parameters[name].in_scene && factor < 0.995));
  if (helping.length === 0) return [];
  const list = element('ol'), title = element('h4', '', 'What would help most');
  list.append(...helping.map(({what, with: partner, factors, tells}) => {
    const widths = Object.entries(factors).filter(([name]) => parameters[name].in_scene || tells.includes(name))
      .map(([name, factor]) => `${name} × ${number(factor, 2)}`).join(', ');
    const made = element('li', '', `${partner ? `${partner} as well` : what}: ${widths}`);
    if (tells.length > 0) made.append(element('strong', '', `; tells ${tells.join(' and ')}`));
    return made;
  }));
  return [title, list,
    element('p', 'caption', `Widths of intervals, 1 as they are; for ${worst}, the least told, first.`)];
}

function aboutMotion(candidate) {
  const start = {rest: 'start estimated, at rest', moving: 'start estimated, in motion'}[candidate.start] ||
    'start known';
  const seen = candidate.points < candidate.nodes ? `${candidate.points} of ${candidate.nodes} nodes seen`
    : count(candidate.points, 'point');
  return `${number(candidate.duration_s, 3)} s, ${count(candidate.frames, 'frame')}, ${seen}, ${start}`;
}

function notesOf({replay, failed_cloths: failed}) {
  const notes = [...replay.notes || []];
  if (replay.every > 1) notes.push(`Every ${replay.every}th frame, to keep this file small.`);
  if (failed.length > 0) {
    notes.push(`${count(failed.length, 'cloth')} could not be simulated; the first: ${failed[0]}`);
  }
  return notes.length > 0 ? [element('p', 'caption', notes.join(' '))] : [];
}

// The curve of a parameter in place of another.
function drawCurve(panel, name) {
  const column = columnOf(panel, name), {times} = panel.candidate.information, target = element('div', 'lines');
  panel.curve.replaceChildren();
  panel.moveMark = null;
  if (!column || !(column.total > 0)) return;
  panel.curve.append(target);
  panel.moveMark = lineChart(target, {name: `told of ${name} by a frame`, unit: '%', times,
    lines: {'': column.frames.map((value) => 100 * value / column.total)}, colours: INFORMATION, height: 130,
    jump: (time) => jump(panel, time - times[0])});
  if (column.forces > 0) {
    panel.curve.append(
      element('p', 'caption', `Forces hold ${number(100 * column.forces / column.total, 2)} % of it.`));
  }
}

function makePanel(candidate, brush) {
  const card = element('section', 'card motion'), stage = element('div', 'stage'), canvas = element('canvas');
  const controls = element('div', 'controls'), scrub = element('div', 'scrub'), scrubber = element('input');
  const key = element('p', 'caption key'), curve = element('div'), label = element('span', 'time');
  const panel = {candidate, canvas, scrubber, label, curve, frame: 0, time: 0, length: candidate.duration_s,
    isPlaying: false, isDirty: true, replay: null, fillKey: keyOf(key, candidate), viewer: makeViewer(canvas, brush)};
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `Replay of ${candidate.name}`);
  Object.assign(scrubber, {type: 'range', min: 0, max: panel.length, step: 'any', value: 0});
  scrubber.setAttribute('aria-label', `Time of ${candidate.name}`);
  scrubber.addEventListener('input', () => jump(panel, Number(scrubber.value)));
  panel.button = makeButton('Play', () =>
    (isInStep() ? playAll(!clock.isPlaying) : playPanel(panel, !panel.isPlaying)));
  stage.append(canvas);
  scrub.append(scrubber);
  controls.append(panel.button, scrub, label);
  card.append(element('h3', '', candidate.name), element('p', 'caption', aboutMotion(candidate)), stage, key, controls,
    curve, ...improvementList(candidate), ...notesOf(candidate));
  panel.stage = stage;
  panel.controls = controls;
  playPanel(panel, false);
  return {panel, card};
}

function showMissing(panel, reason) {
  panel.controls.hidden = true;
  panel.stage.replaceWith(element('p', 'missing', reason));
}

async function loadPanel(panel) {
  const {replay} = panel.candidate;
  if (replay.left_out || !panel.viewer) {
    showMissing(panel, replay.left_out || 'This browser has no WebGL 2, which the replay needs.');
    return;
  }
  const unpacked = await unpackReplay(replay);
  panel.viewer.load(unpacked);
  panel.replay = unpacked;
  panel.length = unpacked.times[unpacked.frames - 1] - unpacked.times[0];
  panel.scrubber.max = panel.length;
  const redraw = () => { panel.isDirty = true; };
  listenToPointers(panel.canvas, panel.viewer, redraw);
  new ResizeObserver(redraw).observe(panel.canvas);
}

async function chooseParameter() {
  const name = part('parameter').value;
  for (const panel of panels) {
    drawCurve(panel, name);
    await colourNodes(panel, name);
    showTime(panel, panel.time);
  }
}

function listenToCommonControls() {
  for (const factor of [0.1, 0.25, 0.5, 1, 2]) addOption('speed', factor, `${factor} ×`, factor === 0.5);
  data.parameters.forEach((name) => addOption('parameter', name, name));
  part('play').addEventListener('click', () => playAll(!(clock.isPlaying || panels.some((panel) => panel.isPlaying))));
  part('scrubber').addEventListener('input', (event) => {
    playAll(false);
    showAll(Number(event.target.value));
  });
  part('in-step').addEventListener('change', () => {
    playAll(false);
    if (isInStep()) showAll(clock.time);
  });
  part('reset').addEventListener('click', () => panels.forEach((panel) => {
    if (!panel.replay) return;
    panel.viewer.reset();
    panel.isDirty = true;
  }));
  for (const id of ['parameter', 'colours']) part(id).addEventListener('change', chooseParameter);
}

async function fillMotions() {
  const brush = makeBrush(element('canvas'));
  for (const candidate of ran) {
    const {panel, card} = makePanel(candidate, brush);
    panels.push(panel);
    part('motions').append(card);
  }
  listenToCommonControls();
  await Promise.all(panels.map((panel) => loadPanel(panel).catch((error) =>
    showMissing(panel, `The replay cannot be shown: ${error}`))));
  part('scrubber').max = longest();
  await chooseParameter();
  showAll(0);
  part('motions-caption').textContent = `Colours: what a node tells of the parameter, all other unknowns following ` +
    `so as to undo the most; blue tells a thousandth of what red does, or less, grey is not seen. ${POINTER_HINT}`;
  requestAnimationFrame(advance);
}

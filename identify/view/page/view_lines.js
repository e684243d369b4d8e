'use strict';
// Lines over time, or another quantity that rises, with a mark: small enough for a page without a library.

const LINE_COLOURS = {x: '#2d5f9a', y: '#e58a3c', z: '#3c8d5f'};

// From the least to the largest with a little room; of a constant that room alone.
function roomAround([low, high]) {
  const room = high > low ? 0.05 * (high - low) : 0.5 * Math.abs(low) || 1;
  return [low - room, high + room];
}

function nearest(times, time) {
  let best = 0;
  times.forEach((other, i) => { if (Math.abs(other - time) < Math.abs(times[best] - time)) best = i; });
  return best;
}

// {name, unit, times, lines: {x: [values], ..}} into `target`; null is a gap. A click jumps to its time, which shows the
// frame. `along` says what `times` are, "NAME, UNIT". What is returned moves the mark to a time.
function lineChart(target, {name, unit, times, lines, along = 'time, s', colours = LINE_COLOURS, height = 200,
  jump = jumpToTime}) {
  const margin = {left: 58, right: 12, top: 26, bottom: 34}, span = [times[0], times[times.length - 1]];
  const range = roomAround(extent(Object.values(lines).flat())), last = span[1] > span[0] ? span[1] : span[0] + 1;
  let mark = null, across = () => 0, now = span[0];
  const legend = element('div', 'legend');
  target.append(legend);

  function draw() {
    const width = Math.max(target.clientWidth, 160);
    across = (time) => margin.left + (width - margin.left - margin.right) * (time - span[0]) / (last - span[0]);
    const up = (value) => height - margin.bottom -
      (height - margin.top - margin.bottom) * (value - range[0]) / (range[1] - range[0]);
    const svg = svgElement('svg', {width, height, role: 'img', 'aria-label': `${name} over ${along.split(',')[0]}, ${unit}`});
    for (const value of sparse(roundMarks(...range, false), 6)) {
      const y = up(value);
      svg.append(svgElement('line', {x1: margin.left, x2: width - margin.right, y1: y, y2: y, class: 'grid'}),
        svgElement('text', {x: margin.left - 6, y: y + 4, 'text-anchor': 'end'}, number(value, 6)));
    }
    for (const time of sparse(roundMarks(span[0], last, false), width < 420 ? 4 : 8)) {
      svg.append(svgElement('text', {x: across(time), y: height - 16, 'text-anchor': 'middle'}, String(time)));
    }
    svg.append(svgElement('text', {x: width - margin.right, y: height - 2, 'text-anchor': 'end'}, along),
      svgElement('text', {x: 4, y: 14}, unit));
    for (const [axis, values] of Object.entries(lines)) {
      let path = '', pen = 'M';
      values.forEach((value, i) => {
        if (value !== null) path += `${pen}${across(times[i]).toFixed(1)} ${up(value).toFixed(1)}`;
        pen = value === null ? 'M' : 'L';
      });
      svg.append(svgElement('path', {d: path, stroke: colours[axis], class: 'curve'}));
    }
    mark = svgElement('line', {y1: margin.top, y2: height - margin.bottom, class: 'mark'});
    svg.append(mark);
    svg.addEventListener('click', (event) => {
      const x = event.clientX - svg.getBoundingClientRect().left;
      jump(span[0] + (last - span[0]) * (x - margin.left) / (width - margin.left - margin.right));
    });
    target.replaceChildren(legend, svg);
    show(now);
  }

  function show(time) {
    now = Math.min(Math.max(time, span[0]), last);
    mark.setAttribute('x1', across(now));
    mark.setAttribute('x2', across(now));
    const i = nearest(times, now);
    legend.replaceChildren(...Object.entries(lines).map(([axis, values]) => {
      const made = element('span', '', `${axis ? `${name} ${axis}` : name}: ${number(values[i], 3)} ${unit}`);
      made.prepend(swatch(colours[axis]));
      return made;
    }));
  }

  draw();
  new ResizeObserver(draw).observe(target);
  return show;
}

'use strict';
// The wind over time: fitted profiles with their 95 % intervals, one chart for each component of each recording.

const WIND_BAND = 'rgba(45,95,154,0.18)';

function windTraces(times, {values, lower95, upper95, start}) {
  const line = (y, more) => ({type: 'scatter', mode: 'lines', x: times, y, ...more});
  const hidden = {hoverinfo: 'skip', showlegend: false, line: {width: 0}};
  return [line(lower95, hidden),
    line(upper95, {...hidden, fill: 'tonexty', fillcolor: WIND_BAND}),
    line(start, {name: 'start', line: {color: COLOURS.start, width: 1.5, dash: 'dash'},
      hovertemplate: '%{y:.3g} m/s at %{x:.4g} s<extra>start</extra>'}),
    line(values, {name: 'estimate', mode: 'lines+markers', line: {color: COLOURS.estimate, width: 2}, marker: {size: 6},
      hovertemplate: '%{y:.3g} m/s at %{x:.4g} s<extra>estimate</extra>'})];
}

function showWind({recordings, smoothness, smoothness_source: source}) {
  const card = element('section', 'card'), area = element('div', 'multiples');
  card.id = 'wind';
  const believed = smoothness === null ? '' : ` Believed to wander by ${number(smoothness, 3)} m/s in a second for` +
    ` residuals as large as sigma, ${source}.`;
  card.append(element('h2', '', 'Wind over time'), area,
    element('p', 'caption', `With its 95 % interval; dashed: the start. Linear between the knots, which are marked, constant beyond.${believed}`));
  part('heat-map').closest('.card').before(card);
  recordings.forEach(({profile, fitted}, index) => {
    for (const wind of fitted) {
      const target = element('div', 'plot');
      area.append(target);
      const name = `wind.${wind.component}${recordings.length > 1 ? ` of ${data.recordings[index].name}` : ''}`;
      plot(target, windTraces(profile.times, wind), {x: {title: 'time, s'}, y: {title: 'm/s'}, margin: {t: 28},
        ...heading(name)});
    }
  });
}

showWind(result.wind);

// Measurements: rates, latencies, and the counts and losses of each stage.

// Three digits and the letter of a power of a thousand.
function short(value) {
  if (!(value > 0)) return ['0', ''];
  const [divisor, letter] = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, '']].find(([least]) => value >= least) ?? [1, ''];
  const part = value / divisor;
  return [part.toFixed(part >= 100 || divisor === 1 && part >= 10 ? 0 : part >= 10 ? 1 : 2), letter];
}
const count = (value) => short(value).join('\u202f').trim();
const whole = (value) => value < 1e4 ? String(value) : count(value);
const ms = (value) => value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
const perSecond = (value) => value >= 10 || value === 0 ? String(Math.round(value)) : value.toFixed(1);

function put(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}

// Stages with their counts: name, meaning, total, rate, and whether the count is a loss.
const STAGES = [
  ['source', (all, rates) => [
    ['events', 'received', all.events, rates.events],
    ['packets', 'received', all.packets, rates.packets],
    ['rejected', 'events outside the sensor or out of order', all.rejected, rates.rejected, true],
    ['malformed', 'packets that could not be decoded', all.malformed, rates.malformed, true],
  ]],
  ['queue', (all, rates) => [
    ['packets', 'let through', Math.max(0, all.packets - all.dropped_packets), Math.max(0, rates.packets - rates.dropped_packets)],
    ['lost packets', 'dropped, the oldest first', all.dropped_packets, rates.dropped_packets, true],
    ['lost events', 'in dropped packets', all.dropped_events, rates.dropped_events, true],
  ]],
  ['front end', (all, rates) => [
    ['processed', 'events', all.followed, rates.followed],
    ['propagated', 'poses by the filter, after those of the network', all.propagated.poses, rates.propagated],
    ['stalls', 'of the source', all.stalls, 0, true],
    ['jumps back', 'of time: another recording began', all.restarts, 0, true],
  ]],
  ['network', (all, rates) => [
    ['inputs', 'representations inferred', all.images, rates.images],
    ['poses', 'of the network', all.network.poses, rates.network],
    ['repeated', 'strides without a change', all.repeated, rates.repeated],
    ['skipped', 'strides while it was busy', all.skipped_strides, rates.skipped_strides],
  ]],
  ['sinks', (all, rates) => [
    ['poses', 'sent to them', all.network.poses + all.propagated.poses, rates.network + rates.propagated],
    ['lost poses', 'dropped by sinks that could not keep up', all.dropped_poses, rates.dropped_poses, true],
  ]],
];

// Throughput is shown per second, and as a total at the end; losses always as totals.
function showStages(all, rates, isOver) {
  const footer = byId('stages');
  if (!footer.children.length) {
    footer.append(...STAGES.map(([name]) => {
      const [stage, heading, list] = ['section', 'h2', 'dl'].map((tag) => document.createElement(tag));
      stage.className = 'stage';
      heading.textContent = name;
      stage.append(heading, list);
      return stage;
    }));
  }
  STAGES.forEach(([, counts], k) => {
    const list = footer.children[k].lastChild;
    counts(all, rates).forEach(([name, meaning, total, rate, isLoss], row) => {
      if (!list.children[2 * row]) list.append(document.createElement('dt'), document.createElement('dd'));
      const [label, value] = [list.children[2 * row], list.children[2 * row + 1]];
      label.textContent = name;
      value.textContent = isLoss || isOver ? whole(total) : `${count(rate)}/s`;
      label.title = value.title = `${name}: ${meaning}; ${total.toLocaleString('en')} since the start, ${count(rate)}/s in the last second`;
      value.className = !isLoss || !total ? '' : rate > 0 ? 'now' : 'some';
    });
  });
}

const COLUMNS = [0, 1, 2, 3];

function showLatencies(point, all) {
  const rows = SERIES.flatMap(([name]) => {
    const { p50_ms, p95_ms, p99_ms, max_ms, poses } = all[name];
    return [
      [name, 'first', `${name}, last second`, point[name]],
      [name, 'all', `${name}, since the start`, poses ? [p50_ms, p95_ms, p99_ms, max_ms] : null],
    ];
  });
  const body = byId('latencies');
  rows.forEach(([name, kind, label, values], k) => {
    const row = body.rows[k] ?? body.insertRow();
    row.className = `${name} ${kind}`;
    if (!row.cells.length) row.append(document.createElement('th'), ...COLUMNS.map(() => document.createElement('td')));
    row.cells[0].textContent = label;
    for (const j of COLUMNS) row.cells[j + 1].textContent = values ? ms(values[j]) : '–';
  });
}
const values4 = () => [0, 1, 2, 3];

function showFigures({ state, network, propagated, t_us, figures: { point, rates, report } }) {
  const [events, letter] = short(rates.events);
  put('events-rate', events);
  put('events-unit', `${letter} events/s`);
  put('network-rate', perSecond(rates.network));
  put('propagated-rate', perSecond(rates.propagated));
  put('network-late', network ? `${ms(network.latency_ms)} ms late` : '–');
  put('propagated-late', propagated ? `${ms(propagated.latency_ms)} ms late` : '–');
  put('clock', t_us === null ? '' : `t = ${(t_us / 1e6).toFixed(2)} s`);
  const last = points.at(-1);
  takePoint(point);
  if (points.at(-1) === last) return;
  showStages(report, rates, state === 'ended');
  showLatencies(point, report);
  drawPlot();
  drawSpark();
}

// Latency and the rate of events over the last ten seconds.

const SHOWN_S = 10;
const points = [];
const SERIES = [['network', NETWORK], ['propagated', PROPAGATED]];

function takePoint(point) {
  const last = points.at(-1);
  if (last && point.at_s <= last.at_s) return;
  points.push(point);
  while (points[0].at_s < point.at_s - SHOWN_S - 1) points.shift();
}

// 1, 2 and 5 times powers of ten that reach over all that is shown, as logarithms.
function steps(values) {
  const [low, high] = [Math.min(...values) / 1.3, Math.max(...values) * 1.3];
  const all = [];
  for (let power = -4; power < 6; power++) {
    for (const digit of [1, 2, 5]) all.push(digit * 10 ** power);
  }
  const from = all.findLastIndex((step) => step <= low), to = all.findIndex((step) => step >= high);
  return all.slice(Math.max(0, from), to < 0 ? all.length : to + 1);
}

function drawPlot() {
  const { context, width, height } = prepared(byId('plot'));
  context.font = '11px system-ui, "DejaVu Sans", sans-serif';
  context.fillStyle = '#7d8a98';
  const values = points.flatMap(({ network, propagated }) => [network, propagated])
    .flatMap((late) => late ? late.slice(0, 3) : []).filter((ms) => ms > 0);
  if (!values.length) {
    context.textAlign = 'center';
    context.fillText('no poses yet', width / 2, height / 2);
    return;
  }
  const [left, right, top, bottom] = [40, width - 4, 6, height - 17];
  const marks = steps(values), low = Math.log(marks[0]), high = Math.log(marks.at(-1));
  const now = points.at(-1).at_s;
  const x = (s) => right - (now - s) / SHOWN_S * (right - left);
  const y = (ms) => bottom - (Math.log(Math.max(ms, 1e-4)) - low) / (high - low) * (bottom - top);
  context.lineWidth = 1;
  context.textBaseline = 'middle';
  context.textAlign = 'right';
  // Labels that would touch each other are left out, those of powers of ten last.
  const isRoom = (bottom - top) / (marks.length - 1) > 14;
  for (const mark of marks) {
    const isPower = Math.abs(Math.log10(mark) - Math.round(Math.log10(mark))) < 1e-6;
    context.strokeStyle = isPower ? '#26303c' : '#19212a';
    context.beginPath();
    context.moveTo(left, y(mark));
    context.lineTo(right, y(mark));
    context.stroke();
    if (isPower || isRoom) context.fillText(String(+mark.toPrecision(1)), left - 6, y(mark));
  }
  context.textBaseline = 'alphabetic';
  for (const ago of [10, 5, 0]) {
    context.textAlign = ago === 10 ? 'left' : ago === 0 ? 'right' : 'center';
    context.fillText(ago ? `${ago} s ago` : 'now', x(now - ago), height - 3);
  }
  context.save();
  context.beginPath();
  context.rect(left, 0, right - left, height);
  context.clip();
  for (const [name, colour] of SERIES) drawSeries(context, name, colour, x, y);
  context.restore();
}

function drawSeries(context, name, colour, x, y) {
  const runs = [[]];
  for (const point of points) {
    if (point[name]) runs.at(-1).push(point);
    else if (runs.at(-1).length) runs.push([]);
  }
  context.lineJoin = 'round';
  for (const run of runs.filter((run) => run.length)) {
    const line = (k, thickness, alpha, dash = []) => {
      context.beginPath();
      for (const point of run) context.lineTo(x(point.at_s), y(point[name][k]));
      context.setLineDash(dash);
      [context.lineWidth, context.globalAlpha, context.strokeStyle] = [thickness, alpha, colour];
      context.stroke();
    };
    context.beginPath();
    for (const point of run) context.lineTo(x(point.at_s), y(point[name][0]));
    for (const point of run.toReversed()) context.lineTo(x(point.at_s), y(point[name][2]));
    [context.globalAlpha, context.fillStyle] = [0.12, colour];
    context.fill();
    line(2, 1, 0.55, [3, 3]);
    line(1, 1, 0.7);
    line(0, 2.2, 1);
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
}

function drawSpark() {
  const { context, width, height } = prepared(byId('events-spark'));
  if (points.length < 2) return;
  const most = Math.max(...points.map((point) => point.events), 1), now = points.at(-1).at_s;
  const place = ({ at_s, events }) => [width - (now - at_s) / SHOWN_S * width, height - 4 - events / most * (height - 22)];
  context.beginPath();
  for (const point of points) context.lineTo(...place(point));
  context.lineWidth = 1.5;
  context.lineJoin = 'round';
  context.strokeStyle = '#6f8296';
  context.stroke();
  context.lineTo(width, height);
  context.lineTo(place(points[0])[0], height);
  context.fillStyle = '#6f829622';
  context.fill();
}

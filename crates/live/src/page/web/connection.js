// The connection: messages are drawn with the next frame of the screen; a lost connection is retried.

const SILENCE_MS = 4000, RETRY_MS = 1000;
const LABELS = {
  connecting: 'connecting',
  waiting: 'waiting for events',
  live: 'live',
  stalled: 'stalled: no events',
  ended: 'ended',
  lost: 'disconnected, trying again',
};
let lastMessage = 0;

function showState(state) {
  const badge = byId('state');
  if (badge.dataset.state === state && badge.textContent === LABELS[state]) return;
  badge.dataset.state = state;
  badge.textContent = LABELS[state];
  document.title = `${scene.about?.title ?? 'evpose'}: ${LABELS[state]}`;
  const veil = byId('veil');
  veil.hidden = !['lost', 'waiting'].includes(state);
  veil.textContent = LABELS[state];
}

function show() {
  scene.isDrawn = true;
  drawScene();
  if (scene.frame) showFigures(scene.frame);
}

function redraw() {
  if (!scene.isDrawn) return;
  scene.isDrawn = false;
  requestAnimationFrame(show);
}

function takeMessage(message) {
  if (message.kind === 'about') {
    scene.about = message;
    scene.frame = null;
    points.length = 0;
    message.history.forEach(takePoint);
    put('title', message.title);
    put('source', message.source);
    put('sensor', `${message.sensor.width}\u2009×\u2009${message.sensor.height} px`);
  } else {
    scene.frame = message;
    showState(message.state);
  }
  redraw();
}

function connect() {
  const socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/ws`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { lastMessage = performance.now(); };
  socket.onmessage = ({ data }) => {
    lastMessage = performance.now();
    if (typeof data === 'string') takeMessage(JSON.parse(data));
    else takeEventImage(data);
  };
  // A server that was killed does not close the connection.
  const watch = setInterval(() => {
    if (socket.readyState === WebSocket.OPEN && performance.now() - lastMessage > SILENCE_MS) socket.close();
    if (performance.now() - lastMessage > SILENCE_MS) showState('lost');
  }, 500);
  socket.onclose = () => {
    clearInterval(watch);
    showState('lost');
    setTimeout(connect, RETRY_MS);
  };
}

new ResizeObserver(() => {
  redraw();
  drawPlot();
  drawSpark();
}).observe(document.body);
connect();

// The connection: what comes is shown with the next picture of the screen; when it breaks, it is tried again.

const SILENCE_MS = 4000, AGAIN_MS = 1000;
const SAID = {
  connecting: 'connecting',
  waiting: 'waiting for events',
  live: 'live',
  stalled: 'stalled: no events',
  ended: 'ended',
  lost: 'disconnected, trying again',
};
let heard = 0;

function showState(state) {
  const badge = byId('state');
  if (badge.dataset.state === state && badge.textContent === SAID[state]) return;
  badge.dataset.state = state;
  badge.textContent = SAID[state];
  document.title = `${scene.about?.title ?? 'evpose'}: ${SAID[state]}`;
  const veil = byId('veil');
  veil.hidden = !['lost', 'waiting'].includes(state);
  veil.textContent = SAID[state];
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

function takeWords(words) {
  if (words.kind === 'about') {
    scene.about = words;
    scene.frame = null;
    points.length = 0;
    words.history.forEach(takePoint);
    put('title', words.title);
    put('source', words.source);
    put('sensor', `${words.sensor.width}\u2009×\u2009${words.sensor.height} px`);
  } else {
    scene.frame = words;
    showState(words.state);
  }
  redraw();
}

function connect() {
  const socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/ws`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { heard = performance.now(); };
  socket.onmessage = ({ data }) => {
    heard = performance.now();
    if (typeof data === 'string') takeWords(JSON.parse(data));
    else takePicture(data);
  };
  // A server that was stopped rather than ended says nothing, not even farewell.
  const watch = setInterval(() => {
    if (socket.readyState === WebSocket.OPEN && performance.now() - heard > SILENCE_MS) socket.close();
    if (performance.now() - heard > SILENCE_MS) showState('lost');
  }, 500);
  socket.onclose = () => {
    clearInterval(watch);
    showState('lost');
    setTimeout(connect, AGAIN_MS);
  };
}

new ResizeObserver(() => {
  redraw();
  drawPlot();
  drawSpark();
}).observe(document.body);
connect();

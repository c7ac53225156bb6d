// The scene: events and poses.

const byId = (id) => document.getElementById(id);
const view = byId('view');
const ON = [77, 163, 255], OFF = [255, 122, 64], DARK = [15, 20, 26];
const NETWORK = '#c3a2ff', PROPAGATED = '#62f0b4';

// Colour of a cell's byte (ON in the upper four bits, OFF in the lower) in the byte order of ImageData.
const palette = Uint32Array.from({ length: 256 }, (_, cell) => {
  const [on, off] = [(cell >> 4) / 15, (cell & 15) / 15].map((bright) => bright ** 0.75);
  const mixed = DARK.map((dark, c) => Math.min(255, dark + (ON[c] - dark) * on + (OFF[c] - dark) * off));
  return (255 << 24 | mixed[2] << 16 | mixed[1] << 8 | mixed[0]) >>> 0;
});

const scene = { about: null, frame: null, cells: null, image: null, pixels: null, isDrawn: true };

// A run of dark cells is a 0 and its length.
function takeEventImage(buffer) {
  const size = new DataView(buffer), bytes = new Uint8Array(buffer, 4);
  const width = size.getUint16(0, true), height = size.getUint16(2, true);
  if (!width || !height) return;
  if (scene.cells?.width !== width || scene.cells?.height !== height) {
    scene.cells = new OffscreenCanvas(width, height);
    scene.image = new ImageData(width, height);
    scene.pixels = new Uint32Array(scene.image.data.buffer);
  }
  let at = 0;
  for (let k = 0; k < bytes.length; k++) {
    if (bytes[k]) {
      scene.pixels[at++] = palette[bytes[k]];
    } else {
      const end = at + bytes[++k];
      scene.pixels.fill(palette[0], at, end);
      at = end;
    }
  }
  scene.cells.getContext('2d').putImageData(scene.image, 0, 0);
}

// A context in CSS pixels, sharp on any screen.
function prepared(canvas) {
  const sharp = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [across, down] = [Math.round(width * sharp), Math.round(height * sharp)];
  if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
  const context = canvas.getContext('2d');
  context.setTransform(sharp, 0, 0, sharp, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

function drawScene() {
  const { context, width, height } = prepared(view);
  const { about, frame } = scene;
  if (!about) return;
  const { width: columns, height: rows } = about.sensor;
  const scale = Math.min(width / columns, height / rows);
  context.translate((width - columns * scale) / 2, (height - rows * scale) / 2);
  context.save();
  context.beginPath();
  context.rect(0, 0, columns * scale, rows * scale);
  context.clip();
  if (frame && about.skeleton === 'hand') drawHandModel(context, frame, scale);
  if (scene.cells) {
    const side = about.cell_px * scale;
    context.imageSmoothingEnabled = side < 1.5;
    // Additive, so that events are visible on the hand, too.
    context.globalCompositeOperation = 'lighter';
    context.drawImage(scene.cells, 0, 0, scene.cells.width * side, scene.cells.height * side);
    context.globalCompositeOperation = 'source-over';
  }
  if (frame) drawPoses(context, frame, scale);
  context.restore();
  context.strokeStyle = '#1c242e';
  context.strokeRect(0.5, 0.5, columns * scale - 1, rows * scale - 1);
}

// A pose fades until a newer one arrives.
const strength = (pose, state) => state === 'ended' ? 1 : Math.max(0.2, Math.min(1, 1.25 - pose.age_ms / 800));

function drawHandModel(context, { network, propagated, state }, scale) {
  const newest = propagated ?? network;
  if (!newest) return;
  context.globalAlpha = strength(newest, state);
  if (newest.vertices) drawMesh(context, newest.vertices, scale);
  else drawHand(context, newest.joints, scale);
  context.globalAlpha = 1;
}

function drawPoses(context, { network, propagated, state }, scale) {
  if (network) {
    context.globalAlpha = strength(network, state);
    drawDots(context, network, scale, !propagated);
  }
  if (propagated) {
    context.globalAlpha = strength(propagated, state);
    drawLines(context, propagated.joints, scale, PROPAGATED);
  }
  context.globalAlpha = 1;
}

// Pairs of joints that a bone connects.
function* bones(joints) {
  const { about } = scene;
  for (const [a, b] of about.bones) if (joints[a] && joints[b]) yield [joints[a], joints[b]];
  // A neck, which the table of limbs leaves out.
  const [head, left, right] = ['head', 'shoulder_l', 'shoulder_r'].map((name) => joints[about.joints.indexOf(name)]);
  if (head && left && right) yield [head, [(left[0] + right[0]) / 2, (left[1] + right[1]) / 2]];
}

function path(context, pairs, scale) {
  context.beginPath();
  for (const [a, b] of pairs) {
    context.moveTo(a[0] * scale, a[1] * scale);
    context.lineTo(b[0] * scale, b[1] * scale);
  }
}

function drawLines(context, joints, scale, colour) {
  path(context, bones(joints), scale);
  context.lineCap = context.lineJoin = 'round';
  context.lineWidth = 5.5;
  context.strokeStyle = '#05080ba0';
  context.stroke();
  context.lineWidth = 2;
  context.strokeStyle = colour;
  context.shadowColor = colour;
  context.shadowBlur = 7;
  context.stroke();
  context.shadowBlur = 0;
}

function drawDots(context, { joints, tenths }, scale, isAlone) {
  if (isAlone) drawLines(context, joints, scale, NETWORK);
  const whole = context.globalAlpha, radius = scene.about.skeleton === 'hand' ? 4 : 5.5;
  joints.forEach((joint, k) => {
    if (!joint) return;
    context.globalAlpha = whole * (0.25 + 0.75 * Math.min(1, (tenths?.[k] ?? 10) / 10));
    context.beginPath();
    context.arc(joint[0] * scale, joint[1] * scale, radius, 0, 2 * Math.PI);
    context.fillStyle = NETWORK;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = '#0b0e14';
    context.stroke();
  });
  context.globalAlpha = whole;
}

// Draws on a layer first, so that overlapping parts share one opacity.
function drawLayer(context, alpha, draw) {
  const layer = drawLayer.layer ??= document.createElement('canvas');
  const { canvas } = context;
  if (layer.width !== canvas.width || layer.height !== canvas.height) {
    [layer.width, layer.height] = [canvas.width, canvas.height];
  }
  const own = layer.getContext('2d');
  own.setTransform(1, 0, 0, 1, 0, 0);
  own.clearRect(0, 0, layer.width, layer.height);
  own.setTransform(context.getTransform());
  draw(own);
  const whole = context.globalAlpha;
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = whole * alpha;
  context.drawImage(layer, 0, 0);
  context.restore();
}

// Triangles, the farthest first, lit from above, left of the camera, by the normals of their corners.
function drawMesh(context, vertices, scale) {
  const faces = scene.about.faces ?? [];
  const normals = vertices.map(() => [0, 0, 0]);
  const visible = faces.filter(([i, j, k]) => {
    const a = vertices[i], b = vertices[j], c = vertices[k];
    if (!a || !b || !c) return false;
    const u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [i, j, k]) normal.forEach((part, n) => { normals[corner][n] += part; });
    // Outward and towards the camera: the others are hidden.
    return normal[2] < 0;
  });
  const lights = normals.map((normal) => {
    const light = (-0.42 * normal[0] - 0.58 * normal[1] - 0.7 * normal[2]) / (Math.hypot(...normal) || 1);
    return 0.28 + 0.72 * Math.max(0, light);
  });
  const triangles = visible.map(([i, j, k]) => [
    vertices[i][2] + vertices[j][2] + vertices[k][2],
    (lights[i] + lights[j] + lights[k]) / 3,
    vertices[i], vertices[j], vertices[k],
  ]);
  triangles.sort((one, other) => other[0] - one[0]);
  drawLayer(context, 0.62, (own) => {
    own.lineJoin = 'round';
    own.lineWidth = 0.8;
    for (const [, light, ...corners] of triangles) {
      own.fillStyle = own.strokeStyle = `rgb(${[190, 178, 222].map((c) => Math.round(c * light)).join()})`;
      own.beginPath();
      for (const [x, y] of corners) own.lineTo(x * scale, y * scale);
      own.closePath();
      own.fill();
      own.stroke();
    }
  });
}

// Fingers as strokes with a lit side, around a palm.
function drawHand(context, joints, scale) {
  const named = (name) => joints[scene.about.joints.indexOf(name)];
  const palm = ['wrist', 'thumb1', 'index1', 'middle1', 'ring1', 'pinky1'].map(named);
  if (palm.some((joint) => !joint)) return;
  const width = 0.2 * scale * Math.hypot(palm[3][0] - palm[0][0], palm[3][1] - palm[0][1]);
  drawLayer(context, 0.6, (own) => {
    own.lineCap = own.lineJoin = 'round';
    for (const [colour, part, shift] of [['#3b3350', 1, 0], ['#7e70a6', 0.78, -0.05], ['#b9abdf', 0.4, -0.14]]) {
      own.save();
      own.translate(shift * width, shift * width);
      own.strokeStyle = own.fillStyle = colour;
      own.lineWidth = part * width;
      path(own, bones(joints), scale);
      own.stroke();
      own.beginPath();
      for (const [x, y] of palm) own.lineTo(x * scale, y * scale);
      own.closePath();
      if (part > 0.5) own.fill();
      if (part > 0.5) own.stroke();
      own.restore();
    }
  });
}

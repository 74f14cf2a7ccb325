// Plays the stream that the page holds. A click or the space bar pauses, arrows step; `#t=1.5` in the address shows
// that second and waits, `#draw=2d` does without WebGL.
const canvas = document.querySelector('canvas'), asked = new URLSearchParams(location.hash.slice(1));
const text = document.getElementById('stream').textContent;
const { fields, frames } = openStream(Uint8Array.from(atob(text), letter => letter.charCodeAt(0)));
const look = lookOf(fields), plays = Number(fields.plays || 1);
const rate = (fields.rate || '25').split('/').reduce((n, d) => n / d);
const first = frames[0].start, last = frames[frames.length - 1];
const duration = last.start + (last.length || 1 / rate) - first;

// WebGL: every sample of a pixel belongs to just one triangle, so that no ground shows between them.
let gl = asked.get('draw') == '2d' ? null
  : canvas.getContext('webgl2', { antialias: look.smooth, depth: false, preserveDrawingBuffer: true });
function prepare() {
  const program = gl.createProgram();
  const shader = (kind, code) => {
    const made = gl.createShader(kind);
    gl.shaderSource(made, '#version 300 es\n' + code);
    gl.compileShader(made);
    gl.attachShader(program, made);
  };
  shader(gl.VERTEX_SHADER, 'in vec2 p;in vec4 c;uniform vec2 s;flat out vec4 v;' +
    'void main(){gl_Position=vec4(p*s+vec2(-1,1),0,1);v=c;}');
  shader(gl.FRAGMENT_SHADER, 'precision highp float;flat in vec4 v;out vec4 o;void main(){o=vec4(v.rgb*v.a,v.a);}');
  gl.bindAttribLocation(program, 0, 'p');
  gl.bindAttribLocation(program, 1, 'c');
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.enableVertexAttribArray(0);
  gl.enableVertexAttribArray(1);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 12, 0);
  gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, 12, 8);
  gl.uniform2f(gl.getUniformLocation(program, 's'), 2 / farX(), -2 / farY());
}
function drawByGl({ corners, colours }) {
  const count = 3 * colours.length, buffer = new ArrayBuffer(12 * count);
  const places = new Float32Array(buffer), words = new Uint32Array(buffer);
  for (let i = 0; i < count; i++) {
    places[3 * i] = corners[2 * i];
    places[3 * i + 1] = corners[2 * i + 1];
    words[3 * i + 2] = colours[i / 3 | 0];
  }
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clear(gl.COLOR_BUFFER_BIT);
  gl.bufferData(gl.ARRAY_BUFFER, buffer, gl.STREAM_DRAW);
  gl.drawArrays(gl.TRIANGLES, 0, count);
}
function drawByHand(found) {
  const picture = new ImageData(canvas.width, canvas.height);
  paint(found, new Uint32Array(picture.data.buffer), canvas.width, canvas.height);
  canvas.getContext('2d').putImageData(picture, 0, 0);
}
if (gl) prepare();
canvas.addEventListener('webglcontextlost', event => event.preventDefault());
canvas.addEventListener('webglcontextrestored', () => {
  prepare();
  draw();
});

// The frame that was read last.
let current = -1;
// Reads on to a frame, for a tenth of a second at most: returns whether it came there.
function readTo(wanted) {
  const began = performance.now();
  let from = wanted;
  while (!frames[from].isKey) from--;
  if (current < from || current > wanted) current = from - 1;
  while (current < wanted) {
    readFrame(frames[++current]);
    if (performance.now() - began > 100) break;
  }
  return current == wanted;
}
function draw() {
  const found = shapes(look);
  if (gl) drawByGl(found);
  else drawByHand(found);
}
// As large as the window allows, each pixel one of the screen's.
function fit() {
  const dots = devicePixelRatio || 1, scale = Math.min(innerWidth / S.width, innerHeight / S.height) * dots;
  const width = Math.max(1, Math.round(S.width * scale)), height = Math.max(1, Math.round(S.height * scale));
  canvas.style.width = width / dots + 'px';
  canvas.style.height = height / dots + 'px';
  if (canvas.width == width && canvas.height == height) return;
  canvas.width = width;
  canvas.height = height;
  if (current >= 0) draw();
}

// When the clip's first moment was, by the page's clock; or for how long it had played when it was paused.
let zero = null, played = 0;
const frameAt = time => {
  let low = 0, high = frames.length;
  while (high - low > 1) {
    const middle = low + high >> 1;
    // A screen's clock is no more exact than this.
    if (frames[middle].start - first <= time + 1e-6) low = middle;
    else high = middle;
  }
  return low;
};
// Shows what is due when the clip has played for `time` seconds; returns how long it has then.
function show(time) {
  const turns = Math.floor(time / duration), over = plays > 0 && turns >= plays;
  const wanted = over ? frames.length - 1 : frameAt(time - turns * duration), before = current;
  const there = readTo(wanted);
  if (current != before) draw();
  // Who cannot keep up plays more slowly.
  return there ? time : turns * duration + frames[current].start - first;
}
const isOver = () => frames.length < 2 || (plays > 0 && played >= plays * duration);
function tick(now) {
  if (zero === null) return;
  const time = (now - zero) / 1000;
  played = show(Math.max(0, time));
  if (played < time) zero = now - played * 1000;
  if (isOver()) zero = null;
  else requestAnimationFrame(tick);
}
function play() {
  if (frames.length < 2 || zero !== null) return;
  if (isOver()) played = 0;
  zero = performance.now() - played * 1000;
  requestAnimationFrame(tick);
}
const pause = () => zero = null;
const toggle = () => zero === null ? play() : pause();
// One frame on or back.
function step(by) {
  pause();
  const turns = Math.floor(played / duration), frame = (current + by + frames.length) % frames.length;
  played = Math.min(turns, (plays || Infinity) - 1) * duration + frames[frame].start - first;
  while (!readTo(frame));
  draw();
}
addEventListener('resize', fit);
addEventListener('click', toggle);
addEventListener('keydown', event => {
  const act = { ' ': toggle, ArrowRight: () => step(1), ArrowLeft: () => step(-1) }[event.key];
  if (!act || event.repeat && event.key == ' ') return;
  event.preventDefault();
  act();
});
fit();
if (asked.has('t')) {
  played = Number(asked.get('t'));
  while (show(played) < played && !isOver());
} else play();
if (current < 0) show(0);

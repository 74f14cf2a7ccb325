// Reads a mesh stream (.polyreel, docs/mesh-stream.md) and paints its frames; needs no page, only JavaScript.
'use strict';

const NONE = -1, CORNERS = 4, SUBPIXEL = 256;

// Models: two estimates and the bits seen, numbered by whoever takes them.
let modelCount = 0;
const take = n => (modelCount += n) - n;
const NUMBER = 164, DIFFERENCE = 14 + NUMBER, BYTE = 256, CLASSES = 8, AREAS = 4;
const takeRows = () => ({ down: take(NUMBER), along: take(NUMBER), across: take(NUMBER), fractions: take(4 * BYTE), offGrid: take(1) });
const M = {
  count: take(NUMBER), lives: take(1), alpha: take(1), rows: takeRows(), births: takeRows(),
  moves: take(16), dies: take(4), offGrid: take(1), across: take(6 * DIFFERENCE), down: take(6 * DIFFERENCE),
  same: take(8), best: take(48), second: take(2), third: take(1),
  kept: take(12 * AREAS), green: take(4 * CLASSES * AREAS * DIFFERENCE), red: take(4 * CLASSES * DIFFERENCE),
  blue: take(4 * CLASSES * DIFFERENCE), redByGreen: take(4 * 60 * DIFFERENCE), blueByRed: take(4 * 72 * DIFFERENCE),
  opacity: take(4 * DIFFERENCE),
};
const quick = new Uint16Array(modelCount), slow = new Uint16Array(modelCount), seen = new Uint8Array(modelCount);

// The range decoder.
let data, at, end, code, range;
const nextByte = () => at < end ? data[at++] : 0;
function begin(from, to) {
  at = from;
  end = to;
  range = 4294967295;
  code = 0;
  for (let i = 0; i < 4; i++) code = code * 256 + nextByte();
}
function narrow(bound) {
  const one = code >= bound;
  if (one) {
    code -= bound;
    range -= bound;
  } else range = bound;
  while (range < 16777216) {
    range *= 256;
    code = code * 256 + nextByte();
  }
  return +one;
}
const clamped = p => p < 32 ? 32 : p > 65504 ? 65504 : p;
function learned(m, bit) {
  const rate = 32 - Math.clz32(seen[m] + 1), q = rate < 4 ? rate : 4, s = rate < 7 ? rate : 7;
  if (seen[m] < 64) seen[m]++;
  if (bit) {
    quick[m] -= quick[m] >> q;
    slow[m] -= slow[m] >> s;
  } else {
    quick[m] += (65536 - quick[m]) >> q;
    slow[m] += (65536 - slow[m]) >> s;
  }
  return bit;
}
function pair(a, b) {
  const one = narrow((range >>> 16) * clamped((quick[a] + slow[a] + quick[b] + slow[b]) >> 2));
  learned(a, one);
  return learned(b, one);
}
const bit = m => learned(m, narrow((range >>> 16) * clamped((quick[m] + slow[m]) >> 1)));
const steady = m => learned(m, narrow((range >>> 16) * clamped(slow[m])));
const even = () => narrow(range >>> 1);
function plain(count) {
  let n = 0;
  while (count-- > 0) n = n * 2 + even();
  return n;
}
function byte(m, leftOut) {
  let node = 1;
  while (node < 256 >> leftOut) node = node * 2 + steady(m + node);
  return node << leftOut & 255;
}
function number(m) {
  let digits = 0, n = 1;
  while (digits < 32 && bit(m + digits)) digits++;
  for (let k = 1; k <= digits; k++)
    n = n * 2 + (k < 3 ? steady(m + 32 + 4 * digits + 2 * (k - 1) + n % 2) : even());
  return n - 1;
}
function difference(m) {
  return difference2(m, NONE);
}
// The same by two models, if there is a second.
function difference2(m, other) {
  const next = i => other == NONE ? bit(m + i) : pair(m + i, other + i);
  if (!next(0)) return 0;
  const negative = next(1);
  let n = 0;
  while (n < 12 && next(2 + n)) n++;
  if (n == 12) n += number(m + 14);
  return negative ? -n - 1 : n + 1;
}

// What is left of each edge: for a vertex the edges that leave it, with other end, apex and triangle.
function halfEdges(vertices, triangles) {
  const starts = new Int32Array(vertices + 1), edges = new Int32Array(3 * triangles.length);
  for (const v of triangles) starts[v + 1]++;
  for (let v = 0; v < vertices; v++) starts[v + 1] += starts[v];
  const next = starts.slice();
  for (let t = 0; t < triangles.length; t += 3)
    for (let i = 0; i < 3; i++) {
      const place = 3 * next[triangles[t + i]]++;
      edges[place] = triangles[t + (i + 1) % 3];
      edges[place + 1] = triangles[t + (i + 2) % 3];
      edges[place + 2] = t / 3;
    }
  return { starts, edges };
}
// The place of the edge from a to b.
function leftOf({ starts, edges }, a, b) {
  for (let i = starts[a]; i < starts[a + 1]; i++) if (edges[3 * i] == b) return 3 * i;
  return NONE;
}

// The frame that was read last.
const S = { width: 0, height: 0, grid: 0, x: [], y: [], triangles: [], edges: null, colours: [], wrong: [] };
const farX = () => S.width * SUBPIXEL, farY = () => S.height * SUBPIXEL;
const damaged = () => { throw Error('the stream is damaged'); };

function readRows(m, count, x, y) {
  let column = 0, row = 0;
  while (count-- > 0) {
    const down = number(m.down);
    row += down;
    column = down ? number(m.across) : column + number(m.along);
    if (column > S.width || row > S.height) damaged();
    const border = column == 0 || row == 0 || column >= S.width - 1 || row >= S.height - 1;
    const fractions = m.fractions + (border ? 2 * BYTE : 0);
    const leftOut = S.grid && !bit(m.offGrid) ? S.grid : 0;
    x.push(column * SUBPIXEL + byte(fractions, leftOut));
    y.push(row * SUBPIXEL + byte(fractions + BYTE, leftOut));
  }
}

// Where vertices of the frame before went: NONE for the dead, 0 for those that stay, 1 for those that moved.
function readFates() {
  const { x, y, edges } = S, toX = x.slice(), toY = y.slice(), fates = new Int8Array(x.length);
  const dead = -1, floor = Math.floor;
  for (let v = CORNERS; v < x.length; v++) {
    let known = 0, moved = 0, died = 0, sumX = 0, sumY = 0, spread = 0, firstX, firstY;
    for (let i = edges.starts[v]; i < edges.starts[v + 1]; i++) {
      const u = edges.edges[3 * i];
      if (u < CORNERS || u >= v) continue;
      if (fates[u] == dead) {
        died++;
        continue;
      }
      const dx = toX[u] - x[u], dy = toY[u] - y[u];
      if (!known++) [firstX, firstY] = [dx, dy];
      moved += fates[u];
      sumX += dx;
      sumY += dy;
      spread = Math.max(spread, Math.abs(firstX - dx), Math.abs(firstY - dy));
    }
    if (!bit(M.moves + 4 * Math.min(known, 3) + Math.min(moved, 3))) continue;
    if (bit(M.dies + Math.min(died, 3))) {
      fates[v] = dead;
      continue;
    }
    const n = known || 1, mean = sum => floor((2 * sum + n) / (2 * n));
    const kind = !known ? 5 : known == 1 ? 4 : spread < 16 ? 0 : spread < 64 ? 1 : spread < 256 ? 2 : 3;
    const line = 2 ** (S.grid && !bit(M.offGrid) ? S.grid : 0);
    const place = (from, sum, m) => line * (floor((from + mean(sum)) / line + 0.5) + difference(m + kind * DIFFERENCE));
    if (x[v] != 0 && x[v] != farX()) toX[v] = place(x[v], sumX, M.across);
    if (y[v] != 0 && y[v] != farY()) toY[v] = place(y[v], sumY, M.down);
    fates[v] = 1;
  }
  return { toX, toY, fates };
}

// The vertices on the frame's border, the inside to the left of who walks along them.
function border(x, y) {
  const sides = [[], [], [], []], right = farX(), bottom = farY();
  for (let v = 0; v < x.length; v++) {
    if (y[v] == 0 && x[v] < right) sides[0].push(v);
    else if (x[v] == right && y[v] < bottom) sides[1].push(v);
    else if (y[v] == bottom && x[v] > 0) sides[2].push(v);
    else if (x[v] == 0) sides[3].push(v);
  }
  const by = [v => x[v], v => y[v], v => -x[v], v => -y[v]];
  return sides.flatMap((side, i) => side.sort((a, b) => by[i](a) - by[i](b)));
}

// Grows the triangles from the border; `moved` and `edges` are those of the frame before, if there was one.
function readTriangles(x, y, moved, edges) {
  const ring = border(x, y), count = 2 * x.length - ring.length - 2, { floor, max, min } = Math;
  const open = x.map(() => []), touching = new Int32Array(x.length), reached = new Uint8Array(x.length);
  const triangles = [], before = [], queue = [];
  const orient = (a, b, c) => (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]);
  const isOpen = (a, b) => {
    const list = open[a];
    for (let i = 0; i < list.length; i += 2) if (list[i] == b) return true;
    return false;
  };
  const openEdge = (a, b, right) => {
    open[a].push(b, right);
    touching[a]++;
    touching[b]++;
    queue.push(a, b);
  };
  // Returns the triangle on the right; undefined if it was not open.
  const close = (a, b) => {
    const list = open[a];
    for (let i = 0; i < list.length; i += 2)
      if (list[i] == b) {
        touching[a]--;
        touching[b]--;
        return list.splice(i, 2)[1];
      }
  };
  const canBe = v => !reached[v] || touching[v] > 0;
  // Vertices in the cells of a grid.
  const cell = max(SUBPIXEL, floor(Math.sqrt(floor(2 * farX() * farY() / x.length))));
  const columns = floor(farX() / cell) + 1, rows = floor(farY() / cell) + 1;
  const place = v => floor(y[v] / cell) * columns + floor(x[v] / cell);
  const starts = new Int32Array(columns * rows + 1), inCells = new Int32Array(x.length);
  for (let v = 0; v < x.length; v++) starts[place(v) + 1]++;
  for (let i = 0; i < columns * rows; i++) starts[i + 1] += starts[i];
  const next = starts.slice();
  for (let v = 0; v < x.length; v++) inCells[next[place(v)]++] = v;
  // Asks where the apex over (a, b) stands among the likely ones.
  const ask = (a, b, except) => {
    const found = [], cotangents = [];
    let closes = false;
    const ahead = open[b].length == 2 && orient(a, b, open[b][0]) > 0 ? open[b][0] : NONE;
    const margin = min(max(cell, Math.abs(x[a] - x[b]), Math.abs(y[a] - y[b])), 8 * cell);
    const first = (p, q) => floor(max(0, min(p, q) - margin) / cell);
    const last = (p, q, most) => min(floor((max(p, q) + margin) / cell), most - 1);
    const left = first(x[a], x[b]), top = first(y[a], y[b]);
    const right = last(x[a], x[b], columns), bottom = last(y[a], y[b], rows);
    const many = (right - left + 1) * (bottom - top + 1) > 400;
    for (let row = top; row <= bottom && !many; row++)
      for (let i = starts[row * columns + left]; i < starts[row * columns + right + 1]; i++) {
        const c = inCells[i];
        if (c == a || c == b || c == except || !canBe(c)) continue;
        const area = orient(a, b, c);
        if (area <= 0 || (ahead != NONE && ahead != c && orient(b, ahead, c) <= 0)) continue;
        const cotangent = ((x[a] - x[c]) * (x[b] - x[c]) + (y[a] - y[c]) * (y[b] - y[c])) / area;
        let k = found.length;
        while (k > 0 && (cotangent < cotangents[k - 1] || (cotangent == cotangents[k - 1] && c < found[k - 1]))) k--;
        if (k == 3) continue;
        if (k == 0) closes = isOpen(b, c) || isOpen(c, a);
        found.splice(k, 0, c);
        cotangents.splice(k, 0, cotangent);
        found.length = cotangents.length = min(3, found.length);
      }
    const gap = cotangents[1] - cotangents[0];
    let sure = 7;
    if (found.length > 1) sure = [1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4].filter(step => gap > step).length;
    const wide = cotangents[0] < 0.25 ? 0 : cotangents[0] < 1 ? 16 : 32;
    for (let i = 0; i < found.length; i++)
      if (bit(i == 0 ? M.best + sure + 8 * closes + wide : i == 1 ? M.second + closes : M.third)) return found[i];
    return plain(32 - Math.clz32(x.length));
  };
  for (let i = 0; i < ring.length; i++) {
    openEdge(ring[i], ring[(i + 1) % ring.length], NONE);
    reached[ring[i]] = 1;
  }
  for (let head = 0; head < queue.length; head += 2) {
    const a = queue[head], b = queue[head + 1], right = close(a, b);
    if (right === undefined) continue;
    if (triangles.length == 3 * count) damaged();
    let apex = NONE, old = NONE, except = NONE;
    const edge = edges ? leftOf(edges, a, b) : NONE;
    if (edge != NONE) {
      const o = edges.edges[edge + 1];
      if (o < x.length && canBe(o) && orient(a, b, o) > 0) {
        const same = right == NONE || before[right] != NONE;
        if (bit(M.same + 4 * same + moved[a] + moved[b] + moved[o])) {
          apex = o;
          old = edges.edges[edge + 2];
        } else except = o;
      }
    }
    if (apex == NONE) apex = ask(a, b, except);
    if (!(apex < x.length) || apex == a || apex == b || orient(a, b, apex) <= 0) damaged();
    reached[apex] = 1;
    const t = before.length;
    triangles.push(a, b, apex);
    before.push(old);
    if (close(b, apex) === undefined) openEdge(apex, b, t);
    if (close(apex, a) === undefined) openEdge(a, apex, t);
  }
  return { triangles, before };
}

// Colours of the triangles that have grown, RGBA one after another, and how wrong each was.
function readColours({ triangles, before }, x, y, moved, edges, alpha, findPlace) {
  const count = before.length, colours = new Uint8Array(4 * count), wrong = new Uint16Array(count);
  const reds = new Uint16Array(count), far = v => [1, 2, 4, 8, 20].filter(step => v >= step).length;
  const kept = new Uint8Array(count), fans = new Float64Array(5 * moved.length), { floor, abs } = Math;
  for (let t = 0; t < count; t++) {
    const corners = [triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]], known = [];
    for (let i = 0; i < 3; i++) {
      const edge = leftOf(edges, corners[(i + 1) % 3], corners[i]);
      if (edge != NONE && edges.edges[edge + 2] < t) known.push(edges.edges[edge + 2]);
    }
    const [p, q, s] = corners, twice = (x[q] - x[p]) * (y[s] - y[p]) - (y[q] - y[p]) * (x[s] - x[p]);
    const area = [2097152, 8388608, 33554432].filter(step => twice >= step).length;
    const n = known.length, old = before[t], isNew = old == NONE, isMoved = isNew || corners.some(v => moved[v]);
    const learn = () => {
      for (const v of corners) {
        for (let c = 0; c < 4; c++) fans[5 * v + c] += colours[4 * t + c];
        fans[5 * v + 4]++;
      }
    };
    if (!isNew) {
      const keepers = known.filter(u => kept[u]).length, some = !keepers ? 0 : keepers == n ? 2 : 1;
      if (bit(M.kept + 12 * area + 6 * isMoved + 2 * some + (S.wrong[old] > 0))) {
        kept[t] = 1;
        for (let c = 0; c < 4; c++) colours[4 * t + c] = S.colours[4 * old + c];
        learn();
        continue;
      }
    }
    let mean = floor(known.reduce((sum, u) => sum + wrong[u], 0) / (n || 1));
    const around = c => {
      let sum = 0, m = n;
      for (const u of known) sum += colours[4 * u + c];
      if (!m) for (const v of corners) {
        sum += fans[5 * v + c];
        m += fans[5 * v + 4];
      }
      return m ? floor((2 * sum + m) / (2 * m)) : c == 3 ? 255 : 128;
    };
    const place = isNew && findPlace ? findPlace(corners) : NONE, there = c => S.colours[4 * place + c];
    let expected = around, kind = isNew ? 0 : isMoved ? 1 : 2;
    if (!isNew) {
      mean = (mean + S.wrong[old]) >> 1;
      expected = c => S.colours[4 * old + c];
    } else if (place != NONE) {
      kind = 3;
      mean = (mean + abs(there(1) - around(1)) + (abs(there(0) - around(0)) >> 1)) >> 1;
      expected = c => floor((2 * there(c) + around(c)) / 3);
    } else if (n > 1) {
      const greens = known.map(u => colours[4 * u + 1]);
      mean = (mean + Math.max(...greens) - Math.min(...greens)) >> 1;
    }
    const group = kind * CLASSES + [1, 3, 6, 10, 16, 26, 45].filter(step => mean >= step).length;
    const g = difference(M.green + (group * AREAS + area) * DIFFERENCE);
    const red = floor(known.reduce((sum, u) => sum + reds[u], 0) / (n || 1));
    const byGreen = ((kind * 6 + far(abs(g))) * 2 + (g < 0)) * 5 + [1, 2, 4, 8].filter(step => red >= step).length;
    const r = difference2(M.red + group * DIFFERENCE, M.redByGreen + byGreen * DIFFERENCE);
    const byRed = ((kind * 6 + far(abs(r))) * 2 + (r < 0)) * 6 + far(abs(g));
    const b = difference2(M.blue + group * DIFFERENCE, M.blueByRed + byRed * DIFFERENCE);
    const a = alpha ? difference(M.opacity + kind * DIFFERENCE) : 0;
    colours[4 * t] = expected(0) + g + r;
    colours[4 * t + 1] = expected(1) + g;
    colours[4 * t + 2] = expected(2) + g + b;
    colours[4 * t + 3] = alpha ? expected(3) + a : 255;
    reds[t] = abs(r);
    learn();
    wrong[t] = Math.max(1, abs(g) + (abs(r) >> 1) + (abs(b) >> 1));
  }
  return { colours, wrong };
}

function readKey() {
  quick.fill(32768);
  slow.fill(32768);
  seen.fill(0);
  const x = [0, farX(), 0, farX()], y = [0, 0, farY(), farY()];
  readRows(M.rows, number(M.count), x, y);
  // The lasting numbers of vertices are passed over.
  const next = plain(32) * 4294967296 + plain(32);
  let digits = 0;
  while (digits < 32 && 2 ** digits <= next - 1) digits++;
  for (let v = CORNERS; v < x.length; v++) if (bit(M.lives)) plain(digits);
  finish(x, y, x.map(() => 0), null, null);
}

function readDelta() {
  const { toX, toY, fates } = readFates(), bornX = [], bornY = [];
  readRows(M.births, number(M.count), bornX, bornY);
  const x = [], y = [], moved = [], numbers = [], back = [];
  let born = 0;
  const bear = () => {
    x.push(bornX[born]);
    y.push(bornY[born++]);
    moved.push(1);
    back.push(NONE);
  };
  for (let v = 0; v < fates.length; v++) {
    numbers.push(fates[v] < 0 ? NONE : x.length);
    if (fates[v] >= 0) {
      x.push(toX[v]);
      y.push(toY[v]);
      moved.push(fates[v]);
      back.push(v);
    } else if (born < bornX.length) bear();
  }
  while (born < bornX.length) bear();
  // Edges of the frame before in the numbers of this one; those of triangles that lost a vertex lie nowhere.
  const old = S.triangles.slice();
  for (let t = 0; t < old.length; t += 3) {
    for (let i = t; i < t + 3; i++) old[i] = numbers[old[i]];
    if (old[t] < 0 || old[t + 1] < 0 || old[t + 2] < 0) old.fill(x.length, t, t + 3);
  }
  finish(x, y, moved, halfEdges(x.length + 1, old), corners => placeOf(corners, x, y, back));
}

// The triangle of the frame before in which the middle of a new one lay.
function placeOf(corners, x, y, back) {
  const { x: oldX, y: oldY, edges, triangles } = S, from = corners.find(v => back[v] != NONE);
  if (from === undefined) return NONE;
  let t = edges.edges[3 * edges.starts[back[from]] + 2], sumX = 0, sumY = 0;
  for (const v of corners) {
    sumX += back[v] == NONE ? x[v] : oldX[back[v]];
    sumY += back[v] == NONE ? y[v] : oldY[back[v]];
  }
  const px = Math.floor(sumX / 3), py = Math.floor(sumY / 3);
  for (let steps = 0; steps < 32; steps++) {
    let edge = NONE;
    for (let i = 0; i < 3 && edge == NONE; i++) {
      const a = triangles[3 * t + i], b = triangles[3 * t + (i + 1) % 3];
      if ((oldX[b] - oldX[a]) * (py - oldY[a]) - (oldY[b] - oldY[a]) * (px - oldX[a]) >= 0) continue;
      edge = leftOf(edges, b, a);
      if (edge == NONE) return t;
    }
    if (edge == NONE) return t;
    t = edges.edges[edge + 2];
  }
  return t;
}

function finish(x, y, moved, edges, findPlace) {
  const grown = readTriangles(x, y, moved, edges);
  const alpha = bit(M.alpha), now = halfEdges(x.length, grown.triangles);
  const painted = readColours(grown, x, y, moved, now, alpha, findPlace);
  Object.assign(S, { x, y, triangles: grown.triangles, edges: now }, painted);
}

// Opens a stream: its header's fields, and its frames with their times in seconds.
function openStream(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  data = bytes;
  if (view.getUint16(8, true) != 2) throw Error('the stream is of another version');
  S.grid = bytes[10];
  S.width = view.getUint32(12, true);
  S.height = view.getUint32(16, true);
  const fields = {}, frames = [], seconds = i => Number(view.getBigInt64(i, true)) / Number(view.getBigInt64(i + 8, true));
  for (let i = 20; i + 9 <= bytes.length;) {
    const kind = String.fromCharCode(bytes[i]), from = i + 9, to = from + view.getUint32(i + 1, true);
    if (to > bytes.length) break;
    if (kind == 'H')
      for (const line of new TextDecoder().decode(bytes.subarray(from, to)).split('\n')) {
        const cut = line.indexOf('=');
        if (cut > 0) fields[line.slice(0, cut)] = line.slice(cut + 1);
      }
    else if (kind != 'E')
      frames.push({ isKey: kind == 'K', start: seconds(from), length: seconds(from + 16), from: from + 32, to });
    i = to;
  }
  return { fields, frames };
}
function readFrame({ isKey, from, to }) {
  begin(from, to);
  if (isKey) readKey();
  else readDelta();
}

// The triangles to paint, of facets and of lines: corners in 1/256 pixel (x, y, x, y, x, y), and a colour of 32 bits.
function shapes(look) {
  const corners = [], colours = [], { x, y, triangles, edges } = S, seenColours = graded(look);
  const word = (r, g, b, a) => a ? (r | g << 8 | b << 16 | a << 24) >>> 0 : 0;
  for (let t = 0; 3 * t < triangles.length; t++) {
    for (let i = 3 * t; i < 3 * t + 3; i++) corners.push(x[triangles[i]], y[triangles[i]]);
    colours.push(word(...seenColours.subarray(4 * t, 4 * t + 4)));
  }
  if (look.outline) {
    const [r, g, b, opacity] = look.outline, half = look.width * SUBPIXEL / 2;
    for (const [alpha, p, q] of lines(look)) {
      const colour = word(r, g, b, Math.floor((opacity * alpha + 127) / 255));
      const turn = Math.atan2(y[q] - y[p], x[q] - x[p]), ring = [];
      for (let k = 0; k < 8; k++) {
        const angle = turn + Math.PI / 2 + (k - (k > 3)) * Math.PI / 3, v = k < 4 ? p : q;
        ring.push([x[v] + half * Math.cos(angle), y[v] + half * Math.sin(angle)]);
      }
      for (let k = 2; k < 8; k++) {
        corners.push(...ring[0], ...ring[k - 1], ...ring[k]);
        colours.push(colour);
      }
    }
  }
  return { corners, colours };
}

// Lines along edges: how opaque the more opaque side is, and the ends; the most opaque last.
function lines({ contrast }) {
  const { triangles, edges, colours } = S, found = [];
  for (let t = 0; 3 * t < triangles.length; t++)
    for (let i = 0; i < 3; i++) {
      const a = triangles[3 * t + i], b = triangles[3 * t + (i + 1) % 3], edge = leftOf(edges, b, a);
      const other = edge == NONE ? NONE : edges.edges[edge + 2];
      if (other > t) continue;
      let alpha = colours[4 * t + 3], step = 0;
      if (other != NONE) {
        alpha = Math.max(alpha, colours[4 * other + 3]);
        for (let c = 0; c < 4; c++) step = Math.max(step, Math.abs(colours[4 * t + c] - colours[4 * other + c]));
      }
      if (alpha && (!contrast || step > contrast)) found.push([alpha, a, b]);
    }
  return found.sort((l, m) => l[0] - m[0]);
}

// Colours with saturation and wash.
function graded({ saturation, wash }) {
  if (saturation == 1 && wash == 0) return S.colours;
  const colours = S.colours.slice();
  for (let i = 0; i < colours.length; i += 4) {
    const grey = (4899 * colours[i] + 9617 * colours[i + 1] + 1868 * colours[i + 2] + 8192) >> 14;
    for (let c = i; c < i + 3 && colours[i + 3]; c++) {
      const vivid = Math.min(255, Math.max(0, grey + saturation * (colours[c] - grey)));
      colours[c] = Math.round(255 * (vivid / 255) ** (1 - wash));
    }
  }
  return colours;
}

function lookOf(fields) {
  const value = (name, usual) => fields[name] === undefined ? usual : Number(fields[name]);
  const hex = (fields.outline || '').match(/[0-9a-f]{2}/gi);
  return {
    outline: hex && [0, 1, 2, 3].map(c => hex[c] ? parseInt(hex[c], 16) : 255),
    width: value('outline-width', 1), contrast: value('outline-contrast', 0),
    saturation: value('saturation', 1), wash: value('wash', 0), smooth: fields.edges != 'hard',
  };
}

// Paints shapes on 32-bit pixels, `scale` pixels a pixel of the stream: a pixel belongs to the triangle that holds its
// centre, so that neighbours share out the pixels without gap or overlap.
function paint({ corners, colours }, pixels, width, height) {
  const scaleX = width / farX() * SUBPIXEL, scaleY = height / farY() * SUBPIXEL;
  const half = SUBPIXEL / 2, first = v => Math.ceil((v - half) / SUBPIXEL);
  for (let t = 0; t < colours.length; t++) {
    const p = [];
    for (let i = 0; i < 6; i += 2)
      p.push([Math.round(corners[6 * t + i] * scaleX), Math.round(corners[6 * t + i + 1] * scaleY)]);
    p.sort((a, b) => a[1] - b[1]);
    const [[ax, ay], [bx, by], [cx, cy]] = p, bend = first(by), last = Math.min(first(cy), height);
    for (let row = Math.max(first(ay), 0); row < last; row++) {
      const y = row * SUBPIXEL + half, long = first(ax + (y - ay) * (cx - ax) / (cy - ay));
      const short = first(row < bend ? ax + (y - ay) * (bx - ax) / (by - ay) : bx + (y - by) * (cx - bx) / (cy - by));
      const left = Math.max(Math.min(long, short), 0), right = Math.min(Math.max(long, short), width);
      if (left < right) pixels.fill(colours[t], row * width + left, row * width + right);
    }
  }
}

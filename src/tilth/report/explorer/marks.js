// SPDX-License-Identifier: BSD-3-Clause
// What is drawn over a picture in pixels: rulers, grid lines, supports, arrows, water.
"use strict";
// Returns a colour of the light page as it is on the present one.
Tilth.tint = function (colour) {
  if (!Tilth.dark() || !/^#[0-9a-f]{6}$/i.test(colour)) return colour;
  return `#${[1, 3, 5].map((at) => Math.round(0.5 * parseInt(colour.slice(at, at + 2), 16) + 115).toString(16).padStart(2, "0")).join("")}`;
};

Tilth.Marks = class {
  constructor(ctx, scene) {
    this.ctx = ctx; this.scene = scene; this.width = scene.pixels.x; this.height = scene.pixels.y; this.place = new THREE.Vector3();
    ctx.lineJoin = "round"; ctx.setLineDash([]); ctx.globalAlpha = 1;
  }

  // Returns where a place in the body is in the picture [pixel].
  at(x, y, z = 0) {
    const [a, b, c] = this.scene.middle;
    this.place.set(x - a, y - b, this.scene.plane ? 0 : z - c).project(this.scene.camera);
    return [(0.5 + 0.5 * this.place.x) * this.width, (0.5 - 0.5 * this.place.y) * this.height];
  }

  // Returns where row `i` of columns is, and where it is after a step of `vector` from there.
  row(columns, i) { return this.at(...columns.slice(0, this.scene.body.dim).map((column) => column[i])); }

  draw() {
    const { scene } = this, axes = scene.right();
    if (axes) this.grid(axes);
    if (scene.dots && scene.plane) this.dots();
    for (const mark of scene.marks) { this.colour = Tilth.tint(mark.colour || "#888888"); this[mark.kind](mark); }
    if (axes) this.rulers(axes);
  }

  stroke(pairs, width, dash = []) {
    const { ctx } = this;
    ctx.strokeStyle = this.colour; ctx.lineWidth = width; ctx.setLineDash(dash); ctx.beginPath();
    let [x, y] = [NaN, NaN];
    for (const [from, to] of pairs) { if (Math.hypot(from[0] - x, from[1] - y) > 0.01 || Number.isNaN(x)) ctx.moveTo(...from); ctx.lineTo(...to); [x, y] = to; }
    ctx.stroke(); ctx.setLineDash([]);
  }

  // Places along an axis that are seen, from side to side.
  range(axis, ends) {
    const { scene } = this, side = ends[1] === "x" ? this.width : this.height, start = scene.low.slice(), end = scene.low.slice();
    start[axis] = 0; end[axis] = 1;
    const k = ends[1] === "x" ? 0 : 1, zero = this.at(...start)[k], one = this.at(...end)[k];
    const of = (pixel) => (pixel - zero) / (one - zero);
    return { low: Math.min(of(0), of(side)), high: Math.max(of(0), of(side)), pixel: (value) => zero + value * (one - zero) };
  }

  grid([across, up]) {
    const { ctx, scene } = this;
    if (!scene.grid.length) return;
    ctx.strokeStyle = Tilth.colour("--text"); ctx.globalAlpha = 0.22; ctx.lineWidth = 0.6; ctx.beginPath();
    const x = this.range(across, "xx"), y = this.range(up, "yy");
    const [l, r] = [scene.low[across], scene.high[across]].map(x.pixel), [b, t] = [scene.low[up], scene.high[up]].map(y.pixel);
    for (const place of scene.grid[across]) { ctx.moveTo(x.pixel(place), b); ctx.lineTo(x.pixel(place), t); }
    for (const place of scene.grid[up]) { ctx.moveTo(l, y.pixel(place)); ctx.lineTo(r, y.pixel(place)); }
    ctx.stroke(); ctx.globalAlpha = 1;
  }

  // The points themselves, where they are far enough apart.
  dots() {
    const { ctx, scene } = this, apart = (scene.spacing() * scene.camera.zoom) / scene.unit, { centre, count } = scene.soil;
    if (apart < 5) return;
    ctx.fillStyle = "#000"; ctx.globalAlpha = 0.35; ctx.beginPath();
    const [a, b] = scene.middle, r = Math.min(0.14 * apart, 2.5);
    for (let i = 0; i < count; i++) { const [x, y] = this.at(centre[3 * i] + a, centre[3 * i + 1] + b); if (x < -9 || y < -9 || x > this.width + 9 || y > this.height + 9) continue; ctx.moveTo(x + r, y); ctx.arc(x, y, r, 0, 7); }
    ctx.fill(); ctx.globalAlpha = 1;
  }

  rulers([across, up]) {
    const { ctx, scene, width, height } = this, { left, bottom } = Tilth.Scene.rulers, { axes, length } = scene.body, unit = length ? ` [${length}]` : "";
    const x = this.range(across, "xx"), y = this.range(up, "yy"), text = Tilth.colour("--text");
    ctx.globalAlpha = 0.85; ctx.fillStyle = Tilth.colour("--view"); ctx.fillRect(0, 0, left, height); ctx.fillRect(0, height - bottom, width, bottom); ctx.globalAlpha = 1;
    ctx.strokeStyle = ctx.fillStyle = text; ctx.lineWidth = 1; ctx.font = "11px system-ui"; ctx.beginPath(); ctx.moveTo(left, 0); ctx.lineTo(left, height - bottom); ctx.lineTo(width, height - bottom);
    const labels = Tilth.ticks(x.low, x.high, width / 90).map((place) => [x.pixel(place), Tilth.text(place)]).filter(([at]) => at > left + 2 && at < width - 8);
    const heights = Tilth.ticks(y.low, y.high, height / 50).map((place) => [y.pixel(place), Tilth.text(place)]).filter(([at]) => at > 16 && at < height - bottom - 4);
    for (const [at] of labels) { ctx.moveTo(at, height - bottom); ctx.lineTo(at, height - bottom + 4); }
    for (const [at] of heights) { ctx.moveTo(left, at); ctx.lineTo(left - 4, at); }
    ctx.stroke(); ctx.textAlign = "center";
    for (const [at, words] of labels) ctx.fillText(words, at, height - bottom + 15);
    ctx.textAlign = "right";
    for (const [at, words] of heights) ctx.fillText(words, left - 7, at + 4);
    ctx.fillText(axes[across] + unit, width - 4, height - 4); ctx.textAlign = "left";
    ctx.fillText(axes[up] + unit, 4, 12);
  }

  // A support at each node, with its tip there, on the side away from the soil; none upon another.
  support({ position, support, axis, sign }) {
    const { ctx, scene } = this, n = position[0].length, taken = new Set(), out = [0, 0, 0], apart = scene.flat() ? 15 : 30;
    out[axis] = sign;
    const [from, to] = [scene.middle, scene.middle.map((each, k) => each + out[k] * scene.radius)].map((place) => this.at(...place));
    if (n > 25 && support !== "cross" && Math.hypot(to[0] - from[0], to[1] - from[1]) < 1) return;  // seen from the front
    for (let i = 0; i < n; i++) {
      const place = position.map((column) => column[i]), [x, y] = this.at(...place), [u, v] = this.at(...place.map((each, k) => each + out[k] * scene.radius));
      const key = `${Math.round(x / apart)} ${Math.round(y / apart)}`, long = Math.hypot(u - x, v - y);
      if (taken.has(key)) continue;
      taken.add(key);
      ctx.save(); ctx.translate(x, y); ctx.strokeStyle = this.colour; ctx.fillStyle = Tilth.colour("--view"); ctx.lineWidth = 1.1; ctx.beginPath();
      if (support === "cross" || long < (0.05 * scene.radius) / scene.unit) { ctx.moveTo(-3, -3); ctx.lineTo(3, 3); ctx.moveTo(-3, 3); ctx.lineTo(3, -3); }
      else {
        ctx.transform((v - y) / long, (x - u) / long, (u - x) / long, (v - y) / long, 0, 0);
        if (support === "roller") ctx.arc(0, 3.6, 3.6, 0, 7); else { ctx.moveTo(0, 0); ctx.lineTo(5, 7.2); ctx.lineTo(-5, 7.2); ctx.closePath(); }
        ctx.fill(); ctx.moveTo(-6.5, 8.2); ctx.lineTo(6.5, 8.2);
        for (const at of [-4, 0, 4]) { ctx.moveTo(at + 1, 8.2); ctx.lineTo(at - 2, 11.5); }
      }
      ctx.stroke(); ctx.restore();
    }
  }

  // Arrows of at most 42 pixels, with their tail, middle or tip at the places.
  arrows({ position, vector, pivot }) {
    const { ctx, scene } = this, n = position[0].length, span = scene.radius, back = { tail: 0, middle: 0.5, tip: 1 }[pivot];
    const scale = (42 * scene.unit) / (scene.camera.zoom * span);
    ctx.strokeStyle = ctx.fillStyle = this.colour; ctx.lineWidth = 1.8;
    for (let i = 0; i < n; i++) {
      const place = position.map((column) => column[i]), [x, y] = this.at(...place), [u, v] = this.at(...place.map((each, k) => each + vector[k][i] * span));
      const [dx, dy] = [(u - x) * scale, (v - y) * scale], long = Math.hypot(dx, dy);
      if (long < 2) { ctx.beginPath(); ctx.moveTo(x - 3, y - 3); ctx.lineTo(x + 3, y + 3); ctx.moveTo(x - 3, y + 3); ctx.lineTo(x + 3, y - 3); ctx.stroke(); continue; }
      ctx.save(); ctx.translate(x - back * dx, y - back * dy); ctx.rotate(Math.atan2(dy, dx));
      const head = Math.min(10, long); ctx.beginPath(); ctx.moveTo(0, 0); ctx.lineTo(long - 0.7 * head, 0); ctx.stroke();
      ctx.beginPath(); ctx.moveTo(long, 0); ctx.lineTo(long - head, 0.42 * head); ctx.lineTo(long - head, -0.42 * head); ctx.closePath(); ctx.fill(); ctx.restore();
    }
  }

  pairs(position) {
    const found = [];
    for (let i = 0; i < position[0].length; i++) found.push([this.at(position[0][i], position[1][i]), this.at(position[2][i], position[3][i])]);
    return found;
  }

  path({ position, dash, water }) {
    const pairs = this.pairs(position);
    this.stroke(pairs, water ? 1.8 : 1.4, dash);
    const { scene, ctx } = this;
    if (!water) return;
    const [left, right] = [0.9, 0.9].map((share) => this.at(scene.low[0] + share * (scene.high[0] - scene.low[0]), 0)[0]), seen = pairs.find(([from, to]) => from[0] <= left && to[0] >= right);
    if (!seen) return;
    const [[x, y], [u, v]] = seen, at = y + ((v - y) * (left - x)) / (u - x || 1);
    ctx.beginPath(); ctx.moveTo(left, at); ctx.lineTo(left - 6, at - 10); ctx.lineTo(left + 6, at - 10); ctx.closePath(); ctx.fillStyle = Tilth.colour("--view"); ctx.fill(); ctx.stroke();
  }

  // A boundary, the soil on the left of its segments: a line, with hatching or rollers on the other side.
  edge({ position, support, dash }) {
    const pairs = this.pairs(position), strokes = [], { ctx } = this, roller = support === "roller", every = roller ? 26 : 7;
    this.stroke(pairs, 2.4, dash);
    let left = 0.5 * every;
    for (const [[x, y], [u, v]] of pairs) {
      const long = Math.hypot(u - x, v - y), s = (u - x) / long, t = (v - y) / long;
      if (!(long > 0)) continue;
      for (; left < long; left += every) {
        const at = [x + left * s, y + left * t], move = (along, out) => [at[0] + along * s - out * t, at[1] + along * t + out * s];
        if (!roller) strokes.push([at, move(-5, 8)]);
        else {
          ctx.beginPath(); ctx.arc(...move(0, 4), 3.2, 0, 7); ctx.fillStyle = Tilth.colour("--view"); ctx.fill(); ctx.strokeStyle = this.colour; ctx.lineWidth = 1.1; ctx.stroke();
          strokes.push([move(-7, 8), move(7, 8)]); for (const along of [-3, 1, 5]) strokes.push([move(along, 8), move(along - 3, 11.5)]);
        }
      }
      left -= long;
    }
    this.stroke(strokes, 1.1);
  }

  // Soil that was removed: hatched in the plane, small dots in space.
  removed({ position, half }) {
    const { ctx, scene } = this, n = position[0].length;
    ctx.save(); ctx.beginPath();
    for (let i = 0; i < n; i++) {
      if (scene.plane) { const [x, y] = this.at(position[0][i] - half[0][i], position[1][i] + half[1][i]), [u, v] = this.at(position[0][i] + half[0][i], position[1][i] - half[1][i]); ctx.rect(x, y, u - x, v - y); }
      else { const [x, y] = this.row(position, i); ctx.rect(x - 0.7, y - 0.7, 1.4, 1.4); }
    }
    if (!scene.plane) { ctx.globalAlpha = 0.4; ctx.fillStyle = this.colour; ctx.fill(); ctx.restore(); return; }
    ctx.clip(); ctx.beginPath(); ctx.strokeStyle = this.colour; ctx.lineWidth = 1;
    for (let at = -this.height; at < this.width; at += 8) { ctx.moveTo(at, this.height); ctx.lineTo(at + this.height, 0); }
    ctx.stroke(); ctx.restore();
  }
};

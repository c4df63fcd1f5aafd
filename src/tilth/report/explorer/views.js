// SPDX-License-Identifier: BSD-3-Clause
// Pictures beside the body at all outputs: the set-up, mechanisms, contact, and outputs on paper.
"use strict";
Tilth.View = class {
  static async start(number) {
    const described = Tilth.data.views[number], place = Tilth.element(`view-${number}`), view = new Tilth.View(place);
    if (described.steps) { view.outputs = described; Tilth.figures.push(view); return view; }
    const all = (list) => Promise.all(list.map((each) => Tilth.rounded(each, "page")));
    const frames = await Promise.all(described.frames.map(async (frame) => ({
      ...frame, position: await all(frame.position), edges: await all(frame.domain),
      lines: await Promise.all(frame.lines.map(async (part) => ({ ...part, position: await all(part.position) }))),
    })));
    const mark = async (each) => {
      const found = { ...each };
      for (const name of ["position", "vector", "half"]) if (each[name]) found[name] = await all(each[name]);
      return found;
    };
    for (const [k, panel] of described.panels.entries()) {
      const values = panel.values ? await Tilth.rounded(panel.values, "page") : null;
      view.add(k, described, frames[panel.frame], values, { ...panel, marks: await Promise.all(panel.marks.map(mark)), grid: described.grid });
    }
    Tilth.figures.push(view);
    return view;
  }

  constructor(place) { this.place = place; this.scenes = []; this.panels = [...place.querySelectorAll(".panel")]; }

  // Draws a frame in a panel.
  add(k, body, frame, values, { drawn, look, low, high, map, marks = [], grid = [], bar }) {
    const scene = this.scenes[k] = this.scenes[k] || new Tilth.Scene(this.panels[k].querySelector(".picture"), body, Tilth.data.maps);
    Object.assign(scene, { drawn, marks, grid, dots: map === "bodies" && marks.length > 0, view: look || "space" });
    scene.look(); scene.setFrame(frame);
    if (values) scene.setValues(values);
    scene.setScale(low, high, map); scene.resize();
    this.bars = this.bars || [];
    const canvas = this.panels[k].querySelector(".bar canvas");
    if (bar && canvas) this.bars.push(() => Tilth.bar(canvas, map, low, high));
  }

  redraw() {
    if (this.outputs && Tilth.paper) this.print();
    for (const scene of this.scenes) if (scene) scene.redraw();
    for (const bar of this.bars || []) bar();
  }

  // Outputs on paper are those of the body at all outputs: their numbers are read beforehand.
  async prepare() {
    if (!this.outputs || !Tilth.view) return;
    const { body } = Tilth.view, field = body.fields.find((each) => each.name === this.outputs.field);
    this.ready = [];
    for (const step of this.outputs.steps) {
      const index = body.frames.findIndex((each) => each.step === step);
      if (index < 0 || !field) { this.ready.push(null); continue; }
      const frame = await Tilth.view.load(index);
      this.ready.push({ frame, values: await Tilth.view.values(index, frame, field) });
    }
    this.field = field;
  }

  print() {
    const { field } = this;
    if (!field) return;
    this.place.querySelector(".label").textContent = field.title;
    this.bars = [() => Tilth.bar(this.place.querySelector(".bar canvas"), field.map, field.low, field.high)];
    this.ready.forEach((each, k) => {
      this.panels[k].hidden = !each;
      if (each) this.add(k, Tilth.view.body, each.frame, each.values, { drawn: this.outputs.drawn, low: field.low, high: field.high, map: field.map });
    });
  }
};

// Draws the colours of values between two, with labels.
Tilth.bar = function (canvas, map, low, high) {
  const width = Math.min(canvas.parentElement.clientWidth, 420), height = 34, ratio = Tilth.sharp, ctx = canvas.getContext("2d"), colours = Tilth.data.maps[map];
  if (!width) return;
  Object.assign(canvas, { width: width * ratio, height: height * ratio }); Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  ctx.scale(ratio, ratio);
  const left = 28, long = width - 2 * left;
  for (let k = 0; k < long; k++) { const at = 3 * Math.round((255 * k) / long); ctx.fillStyle = `rgb(${colours.slice(at, at + 3).join(",")})`; ctx.fillRect(left + k, 2, 1.5, 12); }
  ctx.strokeStyle = ctx.fillStyle = Tilth.colour("--text"); ctx.font = "11px system-ui"; ctx.textAlign = "center"; ctx.lineWidth = 1; ctx.strokeRect(left, 2, long, 12);
  for (const value of Tilth.ticks(low, high, 4)) { const at = left + (long * (value - low)) / (high - low); ctx.beginPath(); ctx.moveTo(at, 14); ctx.lineTo(at, 18); ctx.stroke(); ctx.fillText(Tilth.text(value), at, 30); }
};

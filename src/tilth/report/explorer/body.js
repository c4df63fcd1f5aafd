// SPDX-License-Identifier: BSD-3-Clause
// The body at all outputs: chooses output, field and colours, and shows a point's values.
"use strict";
Tilth.Body = class {
  static start() { return Tilth.data.body && new Tilth.Body(Tilth.data.body, Tilth.data.maps); }

  constructor(body, maps) {
    this.body = body; this.maps = maps; this.kept = new Map(); this.index = 0; this.picked = null; this.latest = 0;
    Tilth.element("explore-body").hidden = false;
    const plane = body.dim === 2, get = (id) => Tilth.element(`body-${id}`);
    this.field = get("field"); this.drawn = get("drawn"); this.scale = get("scale"); this.time = get("time");
    body.fields.forEach((field, k) => this.field.add(new Option(field.title, k)));
    this.field.value = body.fields.findIndex((field) => field.name === body.start);
    for (const [name, text] of [...(plane ? [["field", "continuous field"]] : []), ["domains", "domains"], ["points", "points"]]) this.drawn.add(new Option(text, name));
    this.time.max = body.frames.length - 1;
    try { this.scene = new Tilth.Scene(get("canvas"), body, maps, true); Tilth.figures.push(this); }
    catch (error) { Tilth.element("explore-body").hidden = true; throw error; }
    this.scene.drawn = this.drawn.value;
    if (!plane) this.scene.triad = new Tilth.Triad(get("triad"), body.axes);
    this.time.oninput = () => this.show(Number(this.time.value), true);
    this.field.onchange = this.scale.onchange = () => this.show(this.index);
    get("low").oninput = get("high").oninput = () => this.show(this.index);
    this.drawn.onchange = () => { this.scene.setDrawn(this.drawn.value); };
    for (const kind of ["tracked", "rigid", "boundary"]) {
      const any = body.frames.some((frame) => frame.lines.some((part) => part.kind === kind));
      get(kind).parentElement.hidden = !any;
      if (!plane && kind === "boundary") { get(kind).checked = false; this.scene.shown.boundary = false; }
      get(kind).onchange = () => { this.scene.shown[kind] = get(kind).checked; this.scene.draw(); };
    }
    get("reset").onclick = () => { this.scene.look(); this.scene.resize(); };
    get("play").onclick = () => this.play();
    get("axes").textContent = plane ? "Drag to move, wheel to enlarge, click a point." : `Drag to turn, wheel to enlarge, click a point. Lengths in ${body.length || "their unit"}.`;
    const notes = ["Displacements are not magnified.", ...body.notes]; get("notes").textContent = notes.join(" ");
    if (!plane) this.sections(get("sections"));
    this.clicks(get("canvas"));
    this.time.value = body.frames.length - 1;
    this.ready = this.show(body.frames.length - 1);
  }

  redraw() { if (!Tilth.paper) this.scene.redraw(); }

  // Returns the numbers of an output, without its values; the last few are kept.
  async load(index) {
    if (this.kept.has(index)) return this.kept.get(index);
    const stored = this.body.frames[index], columns = (list) => Promise.all(list.map((each) => Tilth.rounded(each)));
    const [position, edges, lines] = await Promise.all([columns(stored.position), columns(stored.domain),
      Promise.all(stored.lines.map(async (part) => ({ ...part, position: await columns(part.position) })))]);
    const frame = { count: stored.count, enlarged: stored.enlarged, position, edges, lines, columns: new Map() };
    this.kept.set(index, frame);
    if (this.kept.size > Math.max(12, 1e6 / Math.max(frame.count, 1))) this.forget(this.kept.keys().next().value);
    return frame;
  }

  forget(index) {
    const { soil } = this.kept.get(index);
    if (soil) soil.dispose();
    if (soil && soil.field) soil.field.dispose();
    this.kept.delete(index);
  }

  async column(index, frame, number) {
    if (!frame.columns.has(number)) frame.columns.set(number, await Tilth.rounded(this.body.frames[index].values[number]));
    return frame.columns.get(number);
  }

  async values(index, frame, field) {
    if (frame.latest && frame.latest.field === field) return frame.latest.values;
    const parts = await Promise.all(field.columns.map((number) => this.column(index, frame, number)));
    if (field.operation === "value") return parts[0];
    const values = new Float32Array(frame.count);
    for (let i = 0; i < frame.count; i++) values[i] = Tilth.Body.operations[field.operation](parts.map((part) => part[i]));
    frame.latest = { field, values };
    return values;
  }

  async show(index, moving = false) {
    const ticket = ++this.latest, field = this.body.fields[Number(this.field.value)];
    const frame = await this.load(index), values = await this.values(index, frame, field);
    if (ticket !== this.latest) return;
    const moved = this.scene.frame !== frame;
    if (moved) { this.scene.setFrame(frame); this.scene.frame = frame; }
    this.index = index; this.scene.setValues(values);
    this.colours(field, index);
    const { step, time, stage, total } = this.body.frames[index], unit = this.body.time_unit ? ` ${this.body.time_unit}` : "";
    Tilth.element("body-when").textContent = `${stage ? `${stage}: ` : ""}step ${step}, time ${Tilth.text(time, 4)}${unit}, ${total.toLocaleString("en")} points`;
    if (moving) this.scene.move(); else this.scene.draw();
    if (this.picked !== null) await this.tell();
  }

  colours(field, index) {
    const own = this.scale.value === "own", low = Tilth.element("body-low"), high = Tilth.element("body-high");
    let range = [field.low, field.high], map = field.map;
    if (this.scale.value === "frame") {
      const found = this.body.frames[index].ranges[this.body.fields.indexOf(field)];
      if (found) range = map === "coolwarm" ? [-1, 1].map((sign) => sign * Math.max(-found[0], found[1], 1e-30)) : found;
    }
    if (own && low.value !== "" && high.value !== "" && Number(low.value) < Number(high.value)) range = [Number(low.value), Number(high.value)];
    else if (own) [low.value, high.value] = range.map((each) => Number(each.toPrecision(4)));
    Tilth.element("body-limits").hidden = !own;
    if (!own) low.value = high.value = "";
    this.scene.setScale(range[0], range[1], map);
    Tilth.element("body-title").textContent = field.title;
    const stops = []; for (let k = 0; k <= 16; k++) stops.push(`rgb(${this.maps[map].slice(3 * Math.round(15.9375 * k), 3 * Math.round(15.9375 * k) + 3).join(",")})`);
    Tilth.element("body-bar").style.background = `linear-gradient(to right, ${stops.join(",")})`;
    Tilth.element("body-ticks").replaceChildren(...[0, 0.5, 1].map((at) => { const mark = document.createElement("span"); mark.textContent = Tilth.text(range[0] + at * (range[1] - range[0]), 4); return mark; }));
  }

  play() {
    const button = Tilth.element("body-play");
    if (this.timer) { clearInterval(this.timer); this.timer = null; button.textContent = "\u25b6"; return; }
    button.textContent = "\u23f8";
    this.timer = setInterval(() => { const next = (this.index + 1) % this.body.frames.length; this.time.value = next; this.show(next, true); }, 200);
  }

  // Sliders that cut the body along each axis.
  sections(place) {
    place.hidden = false;
    this.body.axes.forEach((axis, k) => {
      const label = document.createElement("label"), side = document.createElement("select"), slider = document.createElement("input"), reading = document.createElement("span");
      side.id = `body-cut-${axis}`; slider.id = `body-place-${axis}`; label.append(`section ${axis}`, side, slider, reading);
      for (const [text, sign] of [["none", 0], ["hide beyond", 1], ["hide before", -1]]) side.add(new Option(text, sign));
      const [low, high] = [this.body.low[k], this.body.high[k]];
      Object.assign(slider, { type: "range", min: 0, max: 1000, value: 500, disabled: true });
      side.onchange = slider.oninput = () => {
        const sign = Number(side.value), at = low + ((high - low) * slider.value) / 1000;
        slider.disabled = sign === 0; reading.textContent = sign ? `${Tilth.text(at, 3)} ${this.body.length}` : ""; this.scene.setSection(k, sign, at);
      };
      place.append(label);
    });
  }

  clicks(canvas) {
    let from = null;
    canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; });
    canvas.addEventListener("pointerup", (event) => {
      if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) > 4) return;
      const box = canvas.getBoundingClientRect(); this.pick(event.clientX - box.left, event.clientY - box.top);
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step && this.body.frames[this.index + step]) { this.time.value = this.index + step; this.show(this.index + step); event.preventDefault(); }
    });
  }

  async pick(x, y) {
    const row = this.scene.pick(x, y);
    this.picked = row < 0 ? null : (await this.ids(this.index))[row];
    await this.tell();
  }

  async ids(index) { return new Uint32Array((await Tilth.bytes("body", this.body.frames[index].id)).buffer); }

  // Shows all values of the picked point at this output.
  async tell() {
    const place = Tilth.element("body-picked"), index = this.index;
    if (this.picked === null) { place.replaceChildren(); return; }
    const frame = await this.load(index), row = (await this.ids(index)).indexOf(this.picked);
    if (row < 0) { place.textContent = `Point ${this.picked} is not there at this output.`; return; }
    const table = document.createElement("table"), add = (name, value) => { const line = table.insertRow(); const head = document.createElement("th"); head.textContent = name; line.append(head); line.insertCell().textContent = value; };
    add("point", String(this.picked));
    this.body.axes.forEach((axis, k) => add(`${axis} ${this.body.length && `[${this.body.length}]`}`, Tilth.text(frame.position[k][row])));
    const values = await Promise.all(this.body.fields.map((field) => this.values(index, frame, field)));
    this.body.fields.forEach((field, k) => add(field.title, Tilth.text(values[k][row], 4)));
    if (index === this.index) place.replaceChildren(table);
  }
};

Tilth.Body.operations = {
  magnitude: (parts) => Math.hypot(...parts),
  mean: ([xx, yy, zz]) => (xx + yy + zz) / 3,
  von_mises: ([xx, yy, zz, xy = 0, yz = 0, xz = 0]) => {
    const mean = (xx + yy + zz) / 3, square = (xx - mean) ** 2 + (yy - mean) ** 2 + (zz - mean) ** 2 + 2 * (xy ** 2 + yz ** 2 + xz ** 2);
    return Math.sqrt(1.5 * square);
  },
};

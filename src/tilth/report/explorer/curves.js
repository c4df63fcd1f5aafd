// SPDX-License-Identifier: BSD-3-Clause
// Curves of all columns: pick the axes, zoom, read, download.
"use strict";
Tilth.Curves = class {
  static async start() {
    const curves = Tilth.data.curves, bytes = await Tilth.bytes("curves", curves.blob);
    const all = new Float64Array(bytes.buffer);
    const columns = curves.names.map((_, k) => all.subarray(k * curves.rows, (k + 1) * curves.rows));
    return new Tilth.Curves(curves, columns);
  }

  constructor(curves, columns) {
    this.curves = curves; this.columns = columns; this.plot = null;
    this.x = Tilth.element("curve-x"); this.y = Tilth.element("curve-y"); this.place = Tilth.element("curve-plot");
    for (const select of [this.x, this.y]) for (const name of curves.names) select.add(new Option(name, name));
    [this.x.value, this.y.value] = curves.pairs[0];
    this.x.onchange = this.y.onchange = () => this.draw();
    Tilth.element("curve-whole").onclick = () => this.draw();
    Tilth.element("curve-csv").onclick = () => this.download();
    Tilth.element("explore-curves").hidden = false;
    if (curves.rows < curves.steps) Tilth.element("curve-notes").textContent = `${curves.rows.toLocaleString("en")} of ${curves.steps.toLocaleString("en")} rows are shown; all are in history.csv.`;
    new ResizeObserver(() => this.plot && this.plot.setSize(this.size())).observe(this.place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.draw();
  }

  size() { return { width: Math.max(this.place.clientWidth, 200), height: this.place.clientWidth < 500 ? 260 : 340 }; }
  column(name) { return this.columns[this.curves.names.indexOf(name)]; }

  limits(values) {
    let low = Infinity, high = -Infinity;
    for (const value of values) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
    if (!(low <= high)) return [0, 1];
    const margin = 0.03 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low - margin, high + margin];
  }

  // Draws the line through all rows in their order, which need not be that of x.
  path(plot) {
    const xs = this.column(this.x.value), ys = this.column(this.y.value), line = new Path2D(), dots = new Path2D(), ratio = uPlot.pxRatio;
    let open = false;
    for (let i = 0; i < xs.length; i++) {
      if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) { open = false; continue; }
      const x = plot.valToPos(xs[i], "x", true), y = plot.valToPos(ys[i], "y", true);
      if (open) line.lineTo(x, y); else line.moveTo(x, y);
      open = true;
      if (xs.length <= 80) { dots.moveTo(x + 2.5 * ratio, y); dots.arc(x, y, 2.5 * ratio, 0, 2 * Math.PI); }
    }
    const { ctx, bbox } = plot, colour = this.colour("--curve");
    ctx.save(); ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    this.stages(plot);
    ctx.strokeStyle = ctx.fillStyle = colour; ctx.lineWidth = 1.6 * ratio; ctx.lineJoin = "round"; ctx.stroke(line); ctx.fill(dots); ctx.restore();
  }

  // Lines between stages, with their names, where x is the time.
  stages(plot) {
    if (!this.x.value.startsWith("time")) return;
    const { ctx, bbox } = plot, ratio = uPlot.pxRatio;
    ctx.strokeStyle = ctx.fillStyle = this.colour("--faint"); ctx.lineWidth = ratio; ctx.font = `${11 * ratio}px system-ui`;
    for (const [name, begin, end] of this.curves.stages) {
      const x = plot.valToPos(end, "x", true), from = plot.valToPos(begin, "x", true);
      ctx.setLineDash([4 * ratio, 3 * ratio]); ctx.beginPath(); ctx.moveTo(x, bbox.top); ctx.lineTo(x, bbox.top + bbox.height); ctx.stroke();
      ctx.save(); ctx.beginPath(); ctx.rect(from, bbox.top, x - from, 20 * ratio); ctx.clip(); ctx.fillText(name, from + 4 * ratio, bbox.top + 13 * ratio); ctx.restore();
    }
    ctx.setLineDash([]);
  }

  colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

  draw() {
    if (this.plot) this.plot.destroy();
    const xs = this.column(this.x.value), ys = this.column(this.y.value), [xl, xh] = this.limits(xs), [yl, yh] = this.limits(ys);
    const axis = (label) => ({ label, stroke: this.colour("--text"), grid: { stroke: this.colour("--line"), width: 1 }, ticks: { stroke: this.colour("--line") }, values: (_, marks) => marks.map((mark) => Tilth.text(mark)) });
    const options = {
      ...this.size(), legend: { show: false },
      scales: { x: { time: false, range: (_, low, high) => [low ?? xl, high ?? xh] }, y: { range: (_, low, high) => [low ?? yl, high ?? yh] } },
      axes: [axis(this.x.value), { ...axis(this.y.value), size: 78 }],
      series: [{}, { paths: () => null, points: { show: false } }],
      cursor: { drag: { x: true, y: true, uni: 25 }, points: { show: false } },
      hooks: { draw: [(plot) => this.path(plot)], setCursor: [(plot) => this.read(plot)] },
    };
    // uPlot's own x must ascend: it gets the ends of the axes, and the line is drawn above.
    this.plot = new uPlot(options, [[xl, xh], [yl, yh]], this.place);
    this.mark = document.createElement("div"); this.mark.className = "curve-mark"; this.mark.hidden = true; this.plot.over.append(this.mark);
  }

  read(plot) {
    const { left, top } = plot.cursor, xs = this.column(this.x.value), ys = this.column(this.y.value);
    let best = -1, least = 60;
    if (left >= 0) for (let i = 0; i < xs.length; i++) {
      const away = Math.hypot(plot.valToPos(xs[i], "x") - left, plot.valToPos(ys[i], "y") - top);
      if (away < least) { least = away; best = i; }
    }
    if (!this.mark) return;
    this.mark.hidden = best < 0;
    if (best < 0) return;
    this.mark.style.left = `${plot.valToPos(xs[best], "x")}px`; this.mark.style.top = `${plot.valToPos(ys[best], "y")}px`;
    Tilth.element("curve-reading").textContent = `step ${this.column("step")[best]}: ${this.x.value} = ${Tilth.text(xs[best], 6)}, ${this.y.value} = ${Tilth.text(ys[best], 6)}`;
  }

  csv() {
    const quoted = (name) => (/[",\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name);
    const rows = [this.curves.names.map(quoted).join(",")];
    for (let i = 0; i < this.curves.rows; i++) rows.push(this.columns.map((column) => column[i]).join(","));
    return rows.join("\n") + "\n";
  }

  download() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([this.csv()], { type: "text/csv" })); link.download = "curves.csv";
    link.click(); URL.revokeObjectURL(link.href);
  }
};

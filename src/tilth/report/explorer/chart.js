// SPDX-License-Identifier: BSD-3-Clause
// A chart: uPlot has the axes, the zoom and the pointer; lines need not ascend along x.
"use strict";
Tilth.Chart = class {
  // `chart` as described in the page, with numbers in place of those of the blobs; `place` is an
  // element as wide as it may be; `read` is told the nearest point under the pointer.
  constructor(place, chart, read = null) {
    this.place = place; this.chart = chart; this.told = read; this.plot = null;
    new ResizeObserver(() => this.plot && !Tilth.paper && this.plot.setSize(this.size())).observe(place);
    Tilth.figures.push(this);
    this.redraw();
  }

  static async load(chart) {
    const numbers = async (line) => {
      const own = { ...line };
      for (const name of ["x", "y", "upper"]) if (name in line) own[name] = await Tilth.exact(line[name]);
      return own;
    };
    return { ...chart, lines: await Promise.all(chart.lines.map(numbers)) };
  }

  size() { const width = Math.max(this.place.clientWidth, 180); return { width, height: Math.round(Math.min(340, Math.max(210, 0.58 * width))) }; }

  // Returns what the axis shows: all numbers with a margin.
  limits(axis) {
    const { chart } = this, log = axis === "y" && chart.logarithmic;
    let low = Infinity, high = -Infinity;
    const add = (value) => { if (Number.isFinite(value) && (!log || value > 0)) { low = Math.min(low, value); high = Math.max(high, value); } };
    for (const line of chart.lines) { line[axis].forEach(add); if (axis === "y" && line.upper) line.upper.forEach(add); }
    if (axis === "x") { (chart.stages || []).forEach(([, begin, end]) => { add(begin); add(end); }); (chart.span || []).forEach(add); }
    if (axis === "y" && chart.lines.some((line) => ["stems", "bars"].includes(line.kind))) add(0);
    if (!(low <= high)) return log ? [0.1, 1] : [0, 1];
    if (log) return [low / 1.5, high * 1.5];
    const margin = 0.03 * (high - low) || 0.05 * Math.abs(high) || 1, given = (axis === "y" && chart.limits) || [];
    return [given[0] ?? low - margin, given[1] ?? high + margin];
  }

  redraw() {
    if (this.plot) this.plot.destroy();
    const [xl, xh] = this.limits("x"), [yl, yh] = this.limits("y"), log = this.chart.logarithmic;
    const whole = (axis) => (this.chart.whole || "").includes(axis) && { incrs: [1, 2, 5].flatMap((each) => [each, 10 * each, 100 * each, 1e3 * each, 1e4 * each, 1e5 * each]).sort((one, other) => one - other) };
    const axis = (more) => ({ stroke: Tilth.colour("--text"), grid: { stroke: Tilth.colour("--line"), width: 1 }, ticks: { stroke: Tilth.colour("--line") }, values: (_, marks) => marks.map((mark) => (mark === null ? "" : Tilth.text(mark))), ...more });
    const options = {
      ...this.size(), legend: { show: false },
      scales: { x: { time: false, range: (_, low, high) => [low ?? xl, high ?? xh] }, y: { distr: log ? 3 : 1, range: (_, low, high) => [low ?? yl, high ?? yh] } },
      axes: [axis({ size: 32, ...whole("x") }), axis({ size: 62, ...whole("y"), ...(log && { splits: (_, __, low, high) => Tilth.decades(low, high) }) })],
      series: [{}, { paths: () => null, points: { show: false } }],
      cursor: { drag: { x: true, y: true, uni: 25 }, points: { show: false } },
      hooks: { draw: [(plot) => this.path(plot)], setCursor: [(plot) => this.read(plot)] },
    };
    // uPlot's own x must ascend: it gets the ends of the axes, and the lines are drawn above.
    this.plot = new uPlot(options, [[xl, xh], [yl, yh]], this.place);
    this.mark = document.createElement("div"); this.mark.className = "curve-mark"; this.mark.hidden = true;
    this.tip = document.createElement("div"); this.tip.className = "curve-tip"; this.tip.hidden = true;
    this.plot.over.append(this.mark, this.tip);
  }

  path(plot) {
    const { ctx, bbox } = plot, { chart } = this;
    this.ratio = uPlot.pxRatio;
    this.at = (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
    ctx.save(); ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    if (chart.span) {
      const [from, to] = chart.span.map((each) => plot.valToPos(each, "x", true));
      ctx.fillStyle = Tilth.colour("--mark"); ctx.fillRect(from, bbox.top, Math.max(to - from, 2), bbox.height);
    }
    const thin = (colour, dash, from, to) => { ctx.strokeStyle = colour; ctx.lineWidth = this.ratio; ctx.setLineDash(dash.map((each) => each * this.ratio)); ctx.beginPath(); ctx.moveTo(...from); ctx.lineTo(...to); ctx.stroke(); ctx.setLineDash([]); };
    for (const place of chart.across || []) { const y = plot.valToPos(place, "y", true); thin(Tilth.colour("--faint"), [5, 4], [bbox.left, y], [bbox.left + bbox.width, y]); }
    for (const [place, colour] of chart.upright || []) { const x = plot.valToPos(place, "x", true); thin(Tilth.colour(`--c${colour}`), [2, 3], [x, bbox.top], [x, bbox.top + bbox.height]); }
    this.stages(plot, thin);
    for (const line of chart.lines) this.line(plot, line);
    ctx.font = `${11 * this.ratio}px system-ui`; ctx.fillStyle = Tilth.colour("--text"); ctx.textAlign = "left"; ctx.textBaseline = "alphabetic";
    for (const [x, y, words] of chart.words || []) { const [left, top] = this.at(x, y); ctx.fillText(words.length > 16 ? `${words.slice(0, 15)}\u2026` : words, left + 5 * this.ratio, top - 5 * this.ratio); }
    ctx.restore();
  }

  line(plot, { x, y, upper, kind = "line", dash = [], width = 1.6, colour }) {
    const { ctx } = plot, { at, ratio } = this, stroke = new Path2D(), signs = new Path2D(), r = 2.5 * ratio;
    const zero = plot.valToPos(0, "y", true), full = 2 * Math.PI, known = (i) => Number.isFinite(x[i]) && Number.isFinite(y[i]);
    ctx.strokeStyle = ctx.fillStyle = Tilth.colour(`--c${colour}`); ctx.lineWidth = width * ratio; ctx.lineJoin = "round";
    if (kind === "band") { this.band(ctx, x, y, upper); return; }
    if (kind === "bars") {
      ctx.globalAlpha = 0.55;
      for (let i = 0; i < y.length; i++) { const [left, top] = at(x[i], y[i]), [right] = at(x[i + 1], 0); ctx.fillRect(left, top, Math.max(right - left - ratio, 1), zero - top); }
      ctx.globalAlpha = 1; return;
    }
    let open = false;
    for (let i = 0; i < x.length; i++) {
      if (!known(i)) { open = false; continue; }
      const [left, top] = at(x[i], y[i]);
      if (kind === "line") {
        if (open) stroke.lineTo(left, top); else stroke.moveTo(left, top);
        open = true;
        if (x.length <= 80 && !dash.length) { signs.moveTo(left + r, top); signs.arc(left, top, r, 0, full); }
      } else if (kind === "stems") { stroke.moveTo(left, zero); stroke.lineTo(left, top); signs.moveTo(left + r, top); signs.arc(left, top, r, 0, full); }
      else if (kind === "crosses") { const s = 2 * r; stroke.moveTo(left - s, top - s); stroke.lineTo(left + s, top + s); stroke.moveTo(left - s, top + s); stroke.lineTo(left + s, top - s); }
      else if (kind === "squares") signs.rect(left - 1.6 * r, top - 1.6 * r, 3.2 * r, 3.2 * r);
      else if (kind === "rings") { stroke.moveTo(left + 1.8 * r, top); stroke.arc(left, top, 1.8 * r, 0, full); }
      else { signs.moveTo(left + 1.3 * r, top); signs.arc(left, top, 1.3 * r, 0, full); }
    }
    if (kind === "rings") { const fill = ctx.fillStyle; ctx.fillStyle = Tilth.colour("--paper"); ctx.fill(stroke); ctx.fillStyle = fill; }
    ctx.setLineDash(dash.map((each) => each * ratio));
    if (kind === "stems") { ctx.globalAlpha = 0.35; ctx.lineWidth = ratio; }
    ctx.stroke(stroke); ctx.globalAlpha = kind === "dots" ? 0.7 : 1; ctx.setLineDash([]); ctx.fill(signs); ctx.globalAlpha = 1;
  }

  band(ctx, x, lower, upper) {
    const area = new Path2D();
    x.forEach((each, i) => { const place = this.at(each, lower[i]); if (i) area.lineTo(...place); else area.moveTo(...place); });
    for (let i = x.length - 1; i >= 0; i--) area.lineTo(...this.at(x[i], upper[i]));
    ctx.globalAlpha = 0.3; ctx.fill(area); ctx.globalAlpha = 1;
  }

  // Lines between stages, with their names where these have room.
  stages(plot, thin) {
    const { ctx, bbox } = plot, { ratio } = this;
    for (const [name, begin, end] of this.chart.stages || []) {
      const x = plot.valToPos(end, "x", true), from = plot.valToPos(begin, "x", true);
      thin(Tilth.colour("--faint"), [4, 3], [x, bbox.top], [x, bbox.top + bbox.height]);
      ctx.save(); ctx.beginPath(); ctx.rect(from, bbox.top, x - from, bbox.height); ctx.clip();
      ctx.font = `${11 * ratio}px system-ui`; ctx.fillStyle = Tilth.colour("--faint"); ctx.textAlign = "left"; ctx.textBaseline = "alphabetic";
      if (ctx.measureText(name).width < x - from - 6 * ratio) ctx.fillText(name, from + 4 * ratio, bbox.top + 13 * ratio);
      else { ctx.translate(from + 12 * ratio, bbox.top + 4 * ratio); ctx.rotate(0.5 * Math.PI); ctx.fillText(name, 0, 0); }
      ctx.restore();
    }
  }

  // Shows the numbers of the point nearest to the pointer.
  read(plot) {
    if (!this.mark) return;
    const { left, top } = plot.cursor;
    let best = null, least = 60;
    if (left >= 0) for (const line of this.chart.lines) for (let i = 0; i < line.y.length; i++) {
      const x = line.kind === "bars" ? 0.5 * (line.x[i] + line.x[i + 1]) : line.x[i];
      const away = Math.hypot(plot.valToPos(x, "x") - left, plot.valToPos(line.y[i], "y") - top);
      if (away < least) { least = away; best = { line, x, y: line.y[i], row: i }; }
    }
    this.mark.hidden = this.tip.hidden = !best;
    if (!best) return;
    const [x, y] = [plot.valToPos(best.x, "x"), plot.valToPos(best.y, "y")], right = x > 0.5 * plot.over.clientWidth;
    Object.assign(this.mark.style, { left: `${x}px`, top: `${y}px` });
    Object.assign(this.tip.style, { left: right ? "" : `${x + 10}px`, right: right ? `${plot.over.clientWidth - x + 10}px` : "", top: `${Math.max(y - 30, 0)}px` });
    this.tip.textContent = `${best.line.label ? `${best.line.label}: ` : ""}${Tilth.text(best.x, 6)}, ${Tilth.text(best.y, 6)}`;
    if (this.told) this.told(best);
  }
};

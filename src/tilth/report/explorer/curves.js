// SPDX-License-Identifier: BSD-3-Clause
// Curves of all columns: pick the axes, zoom, read, download.
"use strict";
Tilth.Curves = class {
  static async start() {
    const curves = Tilth.data.curves;
    return new Tilth.Curves(curves, await Promise.all(curves.columns.map(Tilth.exact)));
  }

  constructor(curves, columns) {
    this.curves = curves; this.columns = columns;
    this.x = Tilth.element("curve-x"); this.y = Tilth.element("curve-y");
    for (const select of [this.x, this.y]) for (const name of curves.names) select.add(new Option(name, name));
    [this.x.value, this.y.value] = curves.pairs[0];
    this.x.onchange = this.y.onchange = () => this.draw();
    Tilth.element("curve-whole").onclick = () => this.chart.redraw();
    Tilth.element("curve-csv").onclick = () => this.download();
    Tilth.element("explore-curves").hidden = false;
    if (curves.rows < curves.steps) Tilth.element("curve-notes").textContent = `${curves.rows.toLocaleString("en")} of ${curves.steps.toLocaleString("en")} rows are shown; all are in history.csv.`;
    this.chart = new Tilth.Chart(Tilth.element("curve-plot"), this.described(), (found) => this.read(found));
    this.label();
  }

  column(name) { return this.columns[this.curves.names.indexOf(name)]; }

  described() {
    const stages = this.x.value.startsWith("time") ? this.curves.stages : [];
    return { lines: [{ x: this.column(this.x.value), y: this.column(this.y.value), label: "", colour: 0 }], stages };
  }

  label() { for (const axis of ["x", "y"]) Tilth.element(`curve-label-${axis}`).textContent = this[axis].value; }
  draw() { this.chart.chart = this.described(); this.label(); this.chart.redraw(); }

  read({ x, y, row }) { Tilth.element("curve-reading").textContent = `step ${this.column("step")[row]}: ${this.x.value} = ${Tilth.text(x, 6)}, ${this.y.value} = ${Tilth.text(y, 6)}`; }

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

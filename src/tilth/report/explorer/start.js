// SPDX-License-Identifier: BSD-3-Clause
// Draws all that the page has; what fails is told and leaves the rest.
"use strict";
(async () => {
  const attempt = async (begin) => { try { return await begin(); } catch (error) { Tilth.failed(error); return null; } };
  Tilth.charts = [];
  for (const [number, chart] of Tilth.data.charts.entries()) {
    await attempt(async () => Tilth.charts.push(new Tilth.Chart(Tilth.element(`chart-${number}`).querySelector(".plot"), await Tilth.Chart.load(chart))));
  }
  if (Tilth.data.curves) Tilth.curves = await attempt(() => Tilth.Curves.start());
  if (Tilth.data.body) await attempt(async () => { Tilth.view = Tilth.Body.start(); await Tilth.view.ready; });
  Tilth.views = [];
  for (const number of Tilth.data.views.keys()) Tilth.views.push(await attempt(() => Tilth.View.start(number)));
  for (const view of Tilth.views) if (view) await attempt(() => view.prepare());
  for (const view of Tilth.views) if (view) await attempt(() => view.redraw());
  Tilth.ready = true;
})();

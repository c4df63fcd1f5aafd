// SPDX-License-Identifier: BSD-3-Clause
// On paper all figures are drawn anew: light, as wide as a page of A4, without the screen's controls.
"use strict";
addEventListener("beforeprint", () => {
  Tilth.paper = true; document.documentElement.classList.add("on-paper"); Tilth.redraw();
});
addEventListener("afterprint", () => {
  Tilth.paper = false; document.documentElement.classList.remove("on-paper"); Tilth.redraw();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => Tilth.redraw());

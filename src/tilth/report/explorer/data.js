// SPDX-License-Identifier: BSD-3-Clause
// The numbers inside the page: described by JSON, stored deflated and in base64.
"use strict";
const Tilth = { data: JSON.parse(document.getElementById("tilth-data").textContent), figures: [], paper: false };
for (const table of document.querySelectorAll("details.numbers")) table.open = false;

// Charts have at least this many pixels over those of the layout: sharp edges, on paper too.
Tilth.sharp = 2;
{
  const own = Object.getOwnPropertyDescriptor(window, "devicePixelRatio");
  if (own && own.get) Object.defineProperty(window, "devicePixelRatio", { ...own, get: () => Math.max(Tilth.sharp, own.get.call(window)) });
}

// Whether colours are those for a dark screen.
Tilth.dark = () => !Tilth.paper && matchMedia("(prefers-color-scheme: dark)").matches;
Tilth.colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Draws all figures again: for paper, for the screen, in other colours.
Tilth.redraw = function () { for (const figure of Tilth.figures) figure.redraw(); };

// Returns the bytes of blob `number` of a group ("page" or "body").
Tilth.bytes = async function (group, number) {
  const text = atob(document.getElementById(`${group}-blob-${number}`).textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

// Returns numbers stored with 16 bits: all low bytes, then all high ones; NaN where there is none.
Tilth.rounded = async function (stored, group = "body") {
  const bytes = await Tilth.bytes(group, stored.blob);
  const count = bytes.length / 2, values = new Float32Array(count);
  const step = (stored.high - stored.low) / 65534;
  for (let i = 0; i < count; i++) {
    const place = bytes[i] + 256 * bytes[i + count];
    values[i] = place === 65535 ? NaN : stored.low + place * step;
  }
  return values;
};

// Returns numbers stored with all digits.
Tilth.exact = async (number) => new Float64Array((await Tilth.bytes("page", number)).buffer);

// Returns a number in at most `digits` digits, for people.
Tilth.text = function (value, digits = 5) {
  if (value === null || !Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-3)) {
    return value.toExponential(digits - 2).replace(/\.?0+e/, "e").replace("e+", "e").replace("-", "\u2212");
  }
  return String(Number(value.toPrecision(digits))).replace("-", "\u2212");
};

Tilth.element = (id) => document.getElementById(id);

Tilth.failed = function (error) {
  const place = Tilth.element("explorer-failure");
  place.hidden = false;
  for (const table of document.querySelectorAll("details.numbers")) table.open = true;
  place.textContent = `A part of this page cannot be shown by this browser: ${error.message || error}. The tables remain.`;
};

// Returns round numbers between two, about `count` of them.
Tilth.ticks = function (low, high, count) {
  const rough = (high - low) / Math.max(count, 1), power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((each) => each * power >= rough) * power, found = [];
  if (!(step > 0)) return [low];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) found.push(k * step);
  return found;
};

// Returns powers of ten between two numbers, at most about eight.
Tilth.decades = function (low, high) {
  const first = Math.ceil(Math.log10(low)), last = Math.floor(Math.log10(high)), step = Math.max(1, Math.ceil((last - first) / 8)), found = [];
  for (let power = last; power >= first; power -= step) found.unshift(10 ** power);
  return found;
};

// SPDX-License-Identifier: BSD-3-Clause
// The numbers inside the page: described by JSON, stored deflated and in base64.
"use strict";
const Tilth = { data: JSON.parse(document.getElementById("tilth-data").textContent) };

// Returns the bytes of blob `number` of a group ("curves" or "body").
Tilth.bytes = async function (group, number) {
  const text = atob(document.getElementById(`${group}-blob-${number}`).textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

// Returns numbers stored with 16 bits: all low bytes, then all high ones; NaN where there is none.
Tilth.rounded = async function (stored) {
  const bytes = await Tilth.bytes("body", stored.blob);
  const count = bytes.length / 2, values = new Float32Array(count);
  const step = (stored.high - stored.low) / 65534;
  for (let i = 0; i < count; i++) {
    const place = bytes[i] + 256 * bytes[i + count];
    values[i] = place === 65535 ? NaN : stored.low + place * step;
  }
  return values;
};

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
  place.textContent = `A part of this page cannot be shown by this browser: ${error.message || error}. The figures below remain.`;
};

// SPDX-License-Identifier: BSD-3-Clause
// The directions of the axes in a view of space, in a corner of the picture.
"use strict";
Tilth.Triad = class {
  constructor(place, names) {
    const make = (kind) => place.appendChild(document.createElementNS(place.namespaceURI, kind));
    place.style.display = "block";
    this.axes = names.map((name) => ({ line: make("line"), text: make("text"), name }));
    for (const { text, name } of this.axes) text.textContent = name;
  }

  // Takes the camera of the picture.
  turn(camera) {
    camera.updateMatrixWorld();
    const [right, up] = [0, 1].map((column) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, column).toArray());
    this.axes.forEach(({ line, text }, k) => {
      for (const [name, value] of [["x1", 0], ["y1", 0], ["x2", 27 * right[k]], ["y2", -27 * up[k]]]) line.setAttribute(name, value);
      text.setAttribute("x", 36 * right[k]); text.setAttribute("y", -36 * up[k]);
    });
  }
};

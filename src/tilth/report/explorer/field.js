// SPDX-License-Identifier: BSD-3-Clause
// A continuous field in the plane, made once for an output and a field, then drawn as one texture:
// weighted means of the values on a grid that is finer than the domains, and where there is soil.
"use strict";
Tilth.Field = class {
  constructor(soil) {
    const [x, y] = [0, 1].map((axis) => soil.limits(axis)), area = Math.max((x[1] - x[0]) * (y[1] - y[0]), 1e-300);
    const [least, typical] = [0.05, 0.5].map((share) => Math.min(soil.quantile(0, share), soil.quantile(1, share)));
    this.soil = soil; this.step = Math.max(0.9 * least, Math.sqrt(area / Tilth.Field.mostPlaces));
    this.low = new THREE.Vector2(x[0] - 2 * this.step, y[0] - 2 * this.step);
    this.wide = Math.ceil((x[1] - x[0]) / this.step) + 4; this.high = Math.ceil((y[1] - y[0]) / this.step) + 4;
    this.means = new Float32Array(this.wide * this.high).fill(Tilth.none);
    this.values = this.texture(this.means, this.wide, this.high, THREE.FloatType, THREE.NearestFilter);
    this.shape = this.rectangle();
    const finer = Tilth.Field.finer, gap = Math.min(12, Math.max(1, Math.round((1.2 * typical * finer) / this.step)));
    this.mask = this.texture(this.covered(finer * this.wide, finer * this.high, this.step / finer, gap), finer * this.wide, finer * this.high, undefined, THREE.LinearFilter);
  }

  // The rectangle of both grids, as triangles.
  rectangle() {
    const wide = this.wide * this.step, high = this.high * this.step;
    return new THREE.PlaneGeometry(wide, high).translate(this.low.x + 0.5 * wide, this.low.y + 0.5 * high, 0);
  }

  texture(numbers, wide, high, type, filter) {
    const texture = new THREE.DataTexture(numbers, wide, high, THREE.RedFormat, type);
    texture.magFilter = texture.minFilter = filter; texture.needsUpdate = true;
    return texture;
  }

  dispose() { this.values.dispose(); this.mask.dispose(); this.shape.dispose(); }

  // Calls `visit(point, place, s, t)` for the places of a grid within `reach` of a domain's halves; `s`
  // and `t` are the place in the domain, 1 at its sides.
  around(reach, step, wide, high, visit) {
    const { soil } = this, [a, b] = soil.edge, { centre, enlarged } = soil, least = 0.6 * step;
    for (let i = 0; i < soil.count; i++) {
      const at = 3 * i, width = soil.half(i, 0), height = soil.half(i, 1), small = width < least || height < least;
      const ax = small ? Math.max(width, least) : a[at] * enlarged, ay = small ? 0 : a[at + 1] * enlarged;
      const bx = small ? 0 : b[at] * enlarged, by = small ? Math.max(height, least) : b[at + 1] * enlarged;
      const over = 1 / (ax * by - ay * bx);
      if (!Number.isFinite(over)) continue;
      const x = (centre[at] - this.low.x) / step - 0.5, y = (centre[at + 1] - this.low.y) / step - 0.5;
      const across = (reach * (Math.abs(ax) + Math.abs(bx))) / step, along = (reach * (Math.abs(ay) + Math.abs(by))) / step;
      const first = Math.max(0, Math.ceil(x - across)), last = Math.min(wide - 1, Math.floor(x + across));
      for (let row = Math.max(0, Math.ceil(y - along)); row <= Math.min(high - 1, Math.floor(y + along)); row++) {
        const up = (row - y) * step;
        for (let column = first; column <= last; column++) {
          const right = (column - x) * step, s = (right * by - up * bx) * over, t = (ax * up - ay * right) * over;
          if (s <= reach && s >= -reach && t <= reach && t >= -reach) visit(i, row * wide + column, s, t);
        }
      }
    }
  }

  // Where there is soil, 0 to 255: on domains, and between those that have parted by less than about
  // one, up to `gap` places from both; then smoothed, so that its outline is at 128.
  covered(wide, high, step, gap) {
    const soil = new Uint8Array(wide * high), closed = new Uint8Array(wide * high);
    this.around(1.02, step, wide, high, (_, place) => { soil[place] = 255; });
    const near = (at, by) => { for (let k = 1; k <= gap; k++) if (soil[at + k * by]) return true; return false; };
    for (let row = 0; row < high; row++) for (let column = 0; column < wide; column++) {
      const at = row * wide + column, inside = row >= gap && column >= gap && row < high - gap && column < wide - gap;
      closed[at] = soil[at] || (inside && [1, wide, wide + 1, wide - 1].some((by) => near(at, by) && near(at, -by)) ? 255 : 0);
    }
    return this.smoothed(this.smoothed(closed, 1), wide);
  }

  // Means over five places along one direction.
  smoothed(numbers, by) {
    const found = new Uint8Array(numbers.length);
    for (let at = 2 * by; at < numbers.length - 2 * by; at++) found[at] = (numbers[at - 2 * by] + numbers[at - by] + numbers[at] + numbers[at + by] + numbers[at + 2 * by]) / 5;
    return found;
  }

  setValues(values) {
    const sum = new Float32Array(this.means.length), weight = new Float32Array(this.means.length), { table } = Tilth.Field;
    this.around(Tilth.Field.reach, this.step, this.wide, this.high, (i, place, s, t) => {
      if (values[i] > 1e37) return;
      const share = table[(64 * (s * s + t * t)) | 0];
      sum[place] += share * values[i]; weight[place] += share;
    });
    for (let at = 0; at < sum.length; at++) this.means[at] = weight[at] > 1e-4 ? sum[at] / weight[at] : Tilth.none;
    this.values.needsUpdate = true;
  }
};
Tilth.Field.mostPlaces = 4e5;  // of the grid of the means
Tilth.Field.finer = 3;  // places of the soil's grid in one of that, along each axis
Tilth.Field.reach = 2.8;  // of a value, over half of its domain
Tilth.Field.table = Float32Array.from({ length: 1024 }, (_, k) => Math.exp((-0.55 * (k + 0.5)) / 64));

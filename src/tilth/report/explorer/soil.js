// SPDX-License-Identifier: BSD-3-Clause
// The soil of one output: the domains of its points as triangles, and which of them can be seen.
"use strict";
Tilth.Soil = class {
  // Takes `position` and `edges` by component, and how much domains are `enlarged`; `middle` becomes
  // the origin.
  constructor(frame, dim, middle) {
    const n = frame.count, full = frame.edges.length > dim;
    this.count = n; this.plane = dim === 2; this.enlarged = frame.enlarged;
    this.centre = new Float32Array(3 * n); this.edge = [0, 1, 2].map(() => new Float32Array(3 * n));
    frame.position.forEach((column, k) => { for (let i = 0; i < n; i++) this.centre[3 * i + k] = column[i] - middle[k]; });
    frame.edges.forEach((column, k) => {
      const array = this.edge[full ? Math.floor(k / dim) : k], axis = full ? k % dim : k;
      for (let i = 0; i < n; i++) array[3 * i + axis] = column[i];
    });
    this.length = new Float32Array(3 * n);
    for (let at = 0; at < 3 * n; at += 3) this.edge.forEach((edge, k) => { this.length[at + k] = Math.hypot(edge[at], edge[at + 1], edge[at + 2]); });
  }

  // Half of the width of a domain along an axis [length].
  half(i, axis) {
    const [a, b, c] = this.edge, at = 3 * i + axis;
    return (Math.abs(a[at]) + Math.abs(b[at]) + (this.plane ? 0 : Math.abs(c[at]))) * this.enlarged;
  }

  // The given share of all half widths along an axis is smaller.
  quantile(axis, share) {
    const every = Math.max(1, Math.floor(this.count / 4000)), found = [];
    for (let i = 0; i < this.count; i += every) found.push(this.half(i, axis));
    return found.sort((one, other) => one - other)[Math.floor(share * (found.length - 1))] || 0;
  }

  // Lowest and highest place of the domains along an axis.
  limits(axis) {
    let low = Infinity, high = -Infinity;
    for (let i = 0; i < this.count; i++) {
      const half = this.half(i, axis), at = this.centre[3 * i + axis];
      low = Math.min(low, at - half); high = Math.max(high, at + half);
    }
    return [low, high];
  }

  // Returns the rows of points that sections leave and that no others hide from all sides: the points
  // are sorted into boxes; those in a box that has points in all 26 boxes around it are hidden.
  seen(planes) {
    const { count, centre } = this, key = planes.map((p) => p.toArray()).join();
    if (this.latest && this.latest.key === key) return this.latest.rows;
    const cut = planes.filter((p) => p.x || p.y || p.z), kept = [];
    for (let i = 0; i < count; i++) {
      const x = centre[3 * i], y = centre[3 * i + 1], z = centre[3 * i + 2];
      if (!cut.some((p) => p.x * x + p.y * y + p.z * z > p.w)) kept.push(i);
    }
    this.latest = { key, rows: Uint32Array.from(this.plane ? kept : this.outer(kept)) };
    return this.latest.rows;
  }

  outer(kept) {
    if (!kept.length) return kept;
    const { box, shape } = this.boxes(), row = shape[0], layer = shape[0] * shape[1], length = layer * shape[2];
    this.first = new Int32Array(length).fill(-1); this.next = new Int32Array(this.count);
    let filled = new Uint8Array(length);
    for (const i of kept) { filled[box[i]] = 1; this.next[i] = this.first[box[i]]; this.first[box[i]] = i; }
    for (const step of [1, row, layer]) {
      const within = new Uint8Array(length);
      for (let at = step; at < length - step; at++) within[at] = filled[at] & filled[at - step] & filled[at + step];
      filled = within;
    }
    return kept.filter((i) => !filled[box[i]]);
  }

  // The box of each point, and how many there are along each axis; those at the ends are empty.
  boxes() {
    if (this.sorted) return this.sorted;
    // Points chosen at random leave holes: more layers of them are needed to hide what is behind.
    const wide = this.enlarged > 1 ? 4 : 1.3, limits = [0, 1, 2].map((axis) => this.limits(axis));
    let size = [0, 1, 2].map((axis) => wide * 2 * this.quantile(axis, 0.5) || 1e-30), shape;
    for (;;) {
      shape = limits.map(([low, high], axis) => Math.floor((high - low) / size[axis]) + 3);
      if (shape[0] * shape[1] * shape[2] <= Tilth.Soil.mostBoxes) break;
      size = size.map((each) => 1.3 * each);
    }
    const box = new Int32Array(this.count), steps = [1, shape[0], shape[0] * shape[1]];
    for (let i = 0; i < this.count; i++) for (let k = 0; k < 3; k++) {
      box[i] += steps[k] * (1 + Math.floor((this.centre[3 * i + k] - limits[k][0]) / size[k]));
    }
    return (this.sorted = { box, shape, size, low: limits.map(([low]) => low) });
  }

  // Whether another point's domain lies on side `number` of that of point `i`, side on side: then it
  // cannot be seen. `seen` has sorted the points.
  shared(i, number) {
    const { shape, size, low } = this.sorted, { centre, length } = this, at = 3 * i, out = this.edge[number >> 1], sign = 2 * (number & 1) - 1;
    const near = Tilth.Soil.same * Math.min(length[at], length[at + 1], length[at + 2]);
    const x = centre[at] + sign * out[at], y = centre[at + 1] + sign * out[at + 1], z = centre[at + 2] + sign * out[at + 2];
    const box = (k, place) => Math.min(Math.max(Math.floor((place - low[k]) / size[k]) + 1, 0), shape[k] - 1);
    const beyondX = x + sign * out[at], beyondY = y + sign * out[at + 1], beyondZ = z + sign * out[at + 2];
    const lastX = box(0, beyondX + near), lastY = box(1, beyondY + near), lastZ = box(2, beyondZ + near);
    for (let w = box(2, beyondZ - near); w <= lastZ; w++) for (let v = box(1, beyondY - near); v <= lastY; v++) for (let u = box(0, beyondX - near); u <= lastX; u++) {
      for (let j = this.first[u + shape[0] * (v + shape[1] * w)]; j >= 0; j = this.next[j]) {
        const to = 3 * j, dx = centre[to] - sign * out[to] - x, dy = centre[to + 1] - sign * out[to + 1] - y, dz = centre[to + 2] - sign * out[to + 2] - z;
        if (j !== i && dx * dx + dy * dy + dz * dz < near * near && length[to] > 0.9 * length[at] && length[to + 1] > 0.9 * length[at + 1] && length[to + 2] > 0.9 * length[at + 2]) return true;
      }
    }
    return false;
  }

  // Returns "points" or "domains" of the points in `rows` as geometries, the same ones until either
  // changes.
  shapes(kind, rows) {
    if (this.made && this.made.kind === kind && this.made.rows === rows) return this.made.shapes;
    this.dispose();
    const shapes = kind === "points" ? [this.cloud(rows)] : this.sides(rows).map((sides) => this.shape(sides, this.enlarged));
    this.made = { kind, rows, shapes };
    return shapes;
  }

  dispose() { if (this.made) for (const shape of this.made.shapes) shape.dispose(); }

  // The sides of the domains of the points in `rows` that no others hide, each 6 i + number of the
  // side, in groups of about the same direction; in the plane the domains.
  sides(rows) {
    const groups = new Map(), normal = [0, 0, 0];
    if (this.plane) return [Array.from(rows, (i) => 6 * i)];
    for (const i of rows) for (let number = 0; number < 6; number++) {
      if (this.enlarged === 1 && this.shared(i, number)) continue;
      this.normal(i, number, normal);
      const key = normal.reduce((sum, each) => 7 * sum + Math.round(3 * each), 0);
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(6 * i + number);
    }
    return [...groups.values()];
  }

  // Writes the direction of a side, outwards, to `normal`.
  normal(i, number, normal) {
    const at = 3 * i, axis = number >> 1, one = this.edge[(axis + 1) % 3], two = this.edge[(axis + 2) % 3], out = this.edge[axis];
    let x = one[at + 1] * two[at + 2] - one[at + 2] * two[at + 1], y = one[at + 2] * two[at] - one[at] * two[at + 2], z = one[at] * two[at + 1] - one[at + 1] * two[at];
    const sign = (x * out[at] + y * out[at + 1] + z * out[at + 2] < 0 ? -1 : 1) * (2 * (number & 1) - 1), over = sign / (Math.hypot(x, y, z) || 1);
    normal[0] = x * over; normal[1] = y * over; normal[2] = z * over;
  }

  // Returns `sides`, of domains `reach` times as large, as triangles that look outwards.
  shape(sides, reach) {
    const { square, cube } = Tilth.Soil, n = sides.length, place = new Float32Array(12 * n), index = new Uint32Array(6 * n), [a, b, c] = this.edge;
    for (let face = 0; face < n; face++) {
      const i = Math.floor(sides[face] / 6), at = 3 * i, number = sides[face] % 6;
      const by = [0, 1, 2].map((k) => reach * (this.plane ? Tilth.Soil.over : number >> 1 === k ? Tilth.Soil.thinner : Tilth.Soil.wider));
      for (let corner = 0; corner < 4; corner++) {
        const [s, t, u] = this.plane ? square[corner] : cube[Tilth.Soil.corners[number][corner]];
        for (let k = 0; k < 3; k++) place[12 * face + 3 * corner + k] = this.centre[at + k] + by[0] * s * a[at + k] + by[1] * t * b[at + k] + by[2] * u * c[at + k];
      }
      const order = !this.plane && this.volume(at) < 0 ? Tilth.Soil.turned : Tilth.Soil.halves;
      for (let k = 0; k < 6; k++) index[6 * face + k] = 4 * face + order[k];
    }
    const shape = this.geometry(place, sides.map((each) => Math.floor(each / 6)), 4, index);
    if (!this.plane) this.directions(sides, shape);
    return shape;
  }

  // Their mean direction, and the sine of the largest angle to it: those whose directions all point
  // away from the viewer need not be drawn.
  directions(sides, shape) {
    const mean = new THREE.Vector3(), normal = [0, 0, 0], each = (visit) => sides.forEach((side) => { this.normal(Math.floor(side / 6), side % 6, normal); visit(); });
    each(() => { mean.x += normal[0]; mean.y += normal[1]; mean.z += normal[2]; });
    mean.normalize();
    let cosine = 1;
    each(() => { cosine = Math.min(cosine, mean.x * normal[0] + mean.y * normal[1] + mean.z * normal[2]); });
    Object.assign(shape.userData, { mean, spread: cosine > 0 ? Math.sqrt(1 - cosine * cosine) : 2 });
  }

  geometry(place, owner, each, index) {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(place, 3));
    shape.setAttribute("value", new THREE.BufferAttribute(new Float32Array(each * owner.length), 1));
    if (index) shape.setIndex(new THREE.BufferAttribute(index, 1));
    shape.userData = { owner, each };
    return shape;
  }

  volume(at) {
    const [a, b, c] = this.edge, x = at, y = at + 1, z = at + 2;
    return a[x] * (b[y] * c[z] - b[z] * c[y]) + a[y] * (b[z] * c[x] - b[x] * c[z]) + a[z] * (b[x] * c[y] - b[y] * c[x]);
  }

  // Returns the points in `rows` as such.
  cloud(rows) {
    const place = new Float32Array(3 * rows.length);
    rows.forEach((i, number) => place.set(this.centre.subarray(3 * i, 3 * i + 3), 3 * number));
    return this.geometry(place, rows, 1);
  }
};
Tilth.Soil.mostBoxes = 4e6;
Tilth.Soil.same = 0.2;  // distance of two sides that count as one, over half of the domain's width
Tilth.Soil.thinner = 0.97;  // of sides, towards the point: below plates that lie on the soil
Tilth.Soil.wider = 1.02;  // of sides, along themselves: no gaps between them
Tilth.Soil.over = 1.01;  // of domains in the plane: no gaps between them
Tilth.Soil.square = [[-1, -1, 1], [1, -1, -1], [1, 1, 1], [-1, 1, -1]];
Tilth.Soil.cube = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [2 * (k & 1) - 1, (k & 2) - 1, ((k >> 1) & 2) - 1]);
Tilth.Soil.halves = [0, 1, 2, 0, 2, 3];
Tilth.Soil.turned = [0, 2, 1, 0, 3, 2];
Tilth.Soil.corners = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

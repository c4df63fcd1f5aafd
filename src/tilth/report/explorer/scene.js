// SPDX-License-Identifier: BSD-3-Clause
// The picture of the body: the same in the plane and in space, seen in parallel projection.
"use strict";
Tilth.Scene = class {
  // `canvas` is filled by pictures of `body`, a description with `dim`, `low`, `high`, `spacing` and
  // `axes`; one renderer draws those of all scenes.
  constructor(canvas, body, maps, key = false) {
    this.body = body; this.canvas = canvas; this.key = key; this.plane = body.dim === 2;
    this.low = [0, 1, 2].map((k) => body.low[k] ?? 0); this.high = [0, 1, 2].map((k) => body.high[k] ?? 0);
    this.middle = this.low.map((low, k) => 0.5 * (low + this.high[k]));
    this.half = this.low.map((low, k) => 0.5 * (this.high[k] - low));
    this.radius = Math.hypot(...this.half) || 1;
    this.renderer = Tilth.Scene.shared = Tilth.Scene.shared || new THREE.WebGLRenderer({ canvas: document.createElement("canvas"), antialias: false });
    this.renderer.autoClear = false; this.ratio = Tilth.Scene.sharp;
    this.scene = new THREE.Scene(); this.ground = new THREE.Group(); this.lines = new THREE.Group();
    this.scene.add(this.ground, this.lines, new THREE.HemisphereLight(0xffffff, 0x777777, 2.5));
    this.camera = new THREE.OrthographicCamera(); this.view = "space"; this.parts = []; this.marks = []; this.grid = [];
    if (!this.plane) this.camera.up.set(0, 0, 1);  // controls turn about what it is now
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableRotate = !this.plane; this.controls.zoomToCursor = true;
    this.controls.screenSpacePanning = true;
    if (this.plane) {
      this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN; this.controls.touches.ONE = THREE.TOUCH.PAN;
    }
    this.controls.addEventListener("change", () => this.move());
    this.planes = [0, 1, 2].map(() => new THREE.Vector4(0, 0, 0, 1));
    this.uniforms = { range: { value: new THREE.Vector2(0, 1) }, map: { value: null }, plane: { value: this.plane ? 1 : 0 }, size: { value: 4 } };
    for (const name of ["means", "mask"]) this.uniforms[name] = { value: null };
    this.maps = Object.fromEntries(Object.entries(maps).map(([name, colours]) => [name, this.texture(colours)]));
    this.materials = { domains: this.material("domains"), points: this.material("points"), field: this.material("field") };
    this.materials.field.transparent = true;
    this.drawn = "domains"; this.shown = { tracked: true, rigid: true, boundary: true, bars: true };
    this.pixels = new THREE.Vector2(1, 1); this.pending = this.moving = this.weak = false; this.slow = this.frames = 0;
    new ResizeObserver(() => Tilth.paper || this.resize()).observe(canvas.parentElement);
    this.look(); this.resize();
  }

  material(name, more = {}) {
    return new THREE.ShaderMaterial({
      ...Tilth.shaders[name], uniforms: { ...this.uniforms, ...more }, depthTest: !this.plane, depthWrite: !this.plane,
      side: name === "domains" && !this.plane ? THREE.FrontSide : THREE.DoubleSide,
    });
  }

  texture(colours) {
    const bytes = new Uint8Array(1024);
    for (let i = 0; i < 256; i++) bytes.set([colours[3 * i], colours[3 * i + 1], colours[3 * i + 2], 255], 4 * i);
    const texture = new THREE.DataTexture(bytes, 256, 1, THREE.RGBAFormat);
    texture.magFilter = texture.minFilter = THREE.LinearFilter; texture.needsUpdate = true;
    return texture;
  }

  // Takes the numbers of one output: `position` and `edges` by component.
  setFrame(frame) {
    this.soil = frame.soil = frame.soil || new Tilth.Soil(frame, this.body.dim, this.middle);
    this.values = new Float32Array(frame.count);
    this.setLines(frame.lines); this.rebuild();
  }

  setValues(values) {
    for (let i = 0; i < values.length; i++) this.values[i] = Number.isNaN(values[i]) ? Tilth.none : values[i];
    this.coloured = false;
  }

  setDrawn(drawn) { this.drawn = drawn; this.rebuild(); this.draw(); }

  rebuild() { this.built = this.coloured = false; }

  // Makes what is drawn of the soil, unless it is there.
  build() {
    if (this.built) return;
    this.ground.clear();
    this.rows = this.soil.seen(this.planes);
    if (this.drawn === "points") this.ground.add(...this.soil.shapes("points", this.rows).map((shape) => new THREE.Points(shape, this.materials.points)));
    else if (this.drawn === "domains") this.ground.add(...this.soil.shapes("domains", this.rows).map((shape) => new THREE.Mesh(shape, this.materials.domains)));
    else this.buildField();
    for (const each of this.ground.children) each.frustumCulled = false;
    this.built = true; this.coloured = false;
  }

  // A continuous field in the plane.
  buildField() {
    const field = this.soil.field = this.soil.field || new Tilth.Field(this.soil);
    this.uniforms.means.value = field.values; this.uniforms.mask.value = field.mask;
    this.ground.add(new THREE.Mesh(field.shape, this.materials.field));
  }

  colour() {
    if (this.coloured && this.soil.shownBy === this) return;
    this.coloured = true; this.soil.shownBy = this;  // scenes may share the soil
    if (this.drawn === "field") { this.soil.field.setValues(this.values); return; }
    for (const { geometry: { attributes: { value }, userData: { owner, each } } } of this.ground.children) {
      for (let k = 0; k < value.array.length; k++) value.array[k] = this.values[owner[Math.floor(k / each)]];
      value.needsUpdate = true;
    }
  }

  // Leaves out the sides that look away from the viewer, who is far away.
  face() {
    const towards = this.camera.getWorldDirection(new THREE.Vector3()).negate();
    for (const each of this.ground.children) {
      const { mean, spread } = each.geometry.userData;
      if (mean) each.visible = mean.dot(towards) > -spread;
    }
  }

  setScale(low, high, map) {
    this.uniforms.range.value.set(low, high > low ? high : low + 1e-30 + Math.abs(low) * 1e-6); this.uniforms.map.value = this.maps[map];
  }

  setSection(axis, sign, place) {
    const normal = [0, 0, 0]; normal[axis] = sign;
    this.planes[axis].set(...normal, sign === 0 ? 1 : sign * (place - this.middle[axis]));
    this.rebuild(); this.move();
  }

  setLines(parts) {
    this.parts = parts;
    this.lines.traverse((each) => each.geometry && each.geometry.dispose()); this.lines.clear();
    const dark = Tilth.dark();
    const colours = { tracked: [0.9, 0, 0.49], rigid: dark ? [0.85, 0.85, 0.85] : [0.15, 0.15, 0.15], boundary: dark ? [0.95, 0.6, 0.25] : [0.7, 0.33, 0.05] };
    for (const part of parts) {
      const group = new THREE.Group(), n = part.position[0].length, at = new Float32Array(3 * n);
      part.position.forEach((column, k) => { for (let i = 0; i < n; i++) at[3 * i + k] = column[i] - this.middle[k]; });
      group.userData.kind = part.kind;
      const tint = part.colour ? new THREE.Color(Tilth.tint(part.colour)).convertLinearToSRGB().toArray() : colours[part.kind];
      if (!this.plane && part.kind !== "tracked") group.add(this.solid(at, part.kind, part.colour));
      if (this.plane || part.kind === "tracked") group.add(this.strokes(this.plane ? at : this.sides(at), tint, part.kind === "boundary" ? 1.2 : this.plane ? 1.6 : 0.6));
      this.lines.add(group);
    }
  }

  solid(at, kind, colour) {
    const shape = new THREE.BufferGeometry(), rigid = kind === "rigid";
    shape.setAttribute("position", new THREE.BufferAttribute(at, 3)); shape.computeVertexNormals();
    const material = new THREE.MeshLambertMaterial({ color: colour || (rigid ? 0x9aa3ad : 0xc98a4b), side: THREE.DoubleSide, transparent: true, opacity: rigid ? 0.6 : colour ? 0.25 : 0.14, depthWrite: false });
    const mesh = new THREE.Mesh(shape, material); mesh.renderOrder = rigid ? 2 : 1;
    return mesh;
  }

  // The three sides of triangles as segments.
  sides(at) {
    const found = new Float32Array(2 * at.length);
    for (let i = 0; i < at.length / 9; i++) for (let k = 0; k < 3; k++) {
      found.set(at.subarray(9 * i + 3 * k, 9 * i + 3 * k + 3), 18 * i + 6 * k);
      const next = (k + 1) % 3; found.set(at.subarray(9 * i + 3 * next, 9 * i + 3 * next + 3), 18 * i + 6 * k + 3);
    }
    return found;
  }

  strokes(at, tint, width) {
    const n = at.length / 6, start = new Float32Array(12 * n), end = new Float32Array(12 * n), corner = new Float32Array(8 * n), index = new Uint32Array(6 * n);
    for (let i = 0; i < n; i++) {
      for (let k = 0; k < 4; k++) { start.set(at.subarray(6 * i, 6 * i + 3), 12 * i + 3 * k); end.set(at.subarray(6 * i + 3, 6 * i + 6), 12 * i + 3 * k); }
      corner.set([-1, -1, 1, -1, 1, 1, -1, 1], 8 * i); index.set([0, 1, 2, 0, 2, 3].map((each) => 4 * i + each), 6 * i);
    }
    const shape = new THREE.BufferGeometry(); shape.setIndex(new THREE.BufferAttribute(index, 1));
    shape.setAttribute("position", new THREE.BufferAttribute(start, 3)); shape.setAttribute("end", new THREE.BufferAttribute(end, 3));
    shape.setAttribute("corner", new THREE.BufferAttribute(corner, 2));
    const material = this.material("lines", { tint: { value: new THREE.Color(...tint) }, pixels: { value: this.pixels }, width: { value: width } });
    const mesh = new THREE.Mesh(shape, material); mesh.frustumCulled = false; mesh.renderOrder = 3;
    return mesh;
  }

  look() {
    const far = 10 * this.radius, [x, y, z] = this.plane ? [0, 0, 1] : Tilth.Scene.looks[this.view];
    this.controls.target.set(0, 0, 0);
    this.camera.position.set(x, y, z).multiplyScalar(far);
    Object.assign(this.camera, { near: 0, far: 4 * far, zoom: 1 }); this.controls.update();
  }

  // Fits the canvas to its place, and the whole body into the canvas at zoom 1.
  resize() {
    const width = this.canvas.parentElement.clientWidth;
    if (!width) return;
    const [wide, high] = this.extent(), most = Tilth.paper ? 380 : Math.min(0.72 * window.innerHeight, 640), { left, bottom } = this.flat() ? Tilth.Scene.rulers : { left: 0, bottom: 0 };
    const top = this.key && (this.plane || width < 640) ? 70 : 0;  // room for the key
    const fitting = ((width - left) * high) / Math.max(wide, 1e-30) + bottom + top + 20;
    const height = Math.round(this.plane || this.flat() ? Math.min(most, Math.max(this.key ? 220 : 120, fitting)) : Math.min(most, Math.max(240, 0.66 * width)));
    this.canvas.style.height = `${height}px`; this.canvas.width = width * Tilth.Scene.sharp; this.canvas.height = height * Tilth.Scene.sharp;
    const unit = Math.max(wide / (width - left), high / Math.max(height - top - bottom - 14, 50)) || 1, up = bottom - (top ? top - 14 : 0);
    Object.assign(this.camera, { left: -(width + left) * unit, right: (width - left) * unit, top: (height - up) * unit, bottom: -(height + up) * unit });
    this.camera.updateProjectionMatrix(); this.unit = 2 * unit; this.pixels.set(width, height);
    this.draw();
  }

  // Whether axes of the body are those of the picture.
  flat() { return this.plane || this.right() !== null; }

  // Numbers of the axes to the right and upwards; null if they are none of the body.
  right() {
    if (this.plane) return [0, 1];
    this.camera.updateMatrixWorld();
    const found = [0, 1].map((column) => new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, column).toArray().findIndex((part) => part > 0.9999));
    return found.includes(-1) ? null : found;
  }

  // Draws now, for paper or again for the screen.
  redraw() { this.setLines(this.parts); this.resize(); this.render(); }

  // Half width and height of the whole body as seen from where the camera is [length].
  extent() {
    if (this.plane) return [1.05 * this.half[0], 1.05 * this.half[1]];
    this.camera.updateMatrixWorld();
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    return [right, up].map((axis) => 1.08 * (Math.abs(axis.x) * this.half[0] + Math.abs(axis.y) * this.half[1] + Math.abs(axis.z) * this.half[2]));
  }

  // Distance of the points that are shown, about [length].
  spacing() { return this.body.spacing * this.soil.enlarged; }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => { this.pending = false; this.render(); });
  }

  // Draws a movement: where pictures come slowly with fewer pixels, until it has ended.
  move() {
    clearTimeout(this.rest);
    if (!this.moving && this.weak) this.ratio = 1;
    this.moving = true; this.draw();
    this.rest = setTimeout(() => {
      this.moving = false; this.slow = 0; this.latest = null;
      if (this.ratio === Tilth.Scene.sharp) return;
      this.ratio = Tilth.Scene.sharp; this.render();
    }, Tilth.Scene.still);
  }

  pace() {
    const now = performance.now(), late = this.latest && now - this.latest > Tilth.Scene.slow;
    this.slow = Math.max(0, this.slow + (late ? 1 : -0.25)); this.latest = now;
    if (this.slow >= 3 && this.ratio !== 1) { this.weak = true; this.ratio = 1; }
  }

  render() {
    if (!this.soil || !this.canvas.parentElement.clientWidth) return;
    if (this.moving) this.pace();
    this.build(); this.colour(); this.face();
    const { ratio, renderer, canvas } = this, { x: width, y: height } = this.pixels, context = canvas.getContext("2d");
    this.uniforms.size.value = Math.max(2, ratio * ((this.plane ? 0.95 : 1.05) * this.spacing() * this.camera.zoom) / this.unit);
    for (const each of this.lines.children) each.visible = this.shown[each.userData.kind];
    if (Tilth.Scene.size !== `${width} ${height} ${ratio}`) { renderer.setPixelRatio(ratio); renderer.setSize(width, height, false); Tilth.Scene.size = `${width} ${height} ${ratio}`; }
    renderer.setClearColor(Tilth.colour("--view"), 1); renderer.clear();
    renderer.render(this.scene, this.camera);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(renderer.domElement, 0, 0, canvas.width, canvas.height);
    context.setTransform(Tilth.Scene.sharp, 0, 0, Tilth.Scene.sharp, 0, 0);
    new Tilth.Marks(context, this).draw();
    if (this.triad) this.triad.turn(this.camera);
    this.frames += 1;
  }

  // Returns the row of the point nearest to a place in the canvas [pixels], the front one in space.
  pick(x, y) {
    const { width, height } = this.canvas.getBoundingClientRect(), place = new THREE.Vector3();
    const reach = Math.max(10, (0.6 * this.spacing() * this.camera.zoom) / this.unit);
    let best = -1, least = Infinity;
    this.build();
    for (const i of this.rows) {
      place.fromArray(this.soil.centre, 3 * i);
      place.project(this.camera);
      const away = Math.hypot((place.x * 0.5 + 0.5) * width - x, (0.5 - place.y * 0.5) * height - y);
      if (away > reach) continue;
      const rank = this.plane ? away : place.z * 40 * this.radius + (away / reach) * this.spacing();
      if (rank < least) { least = rank; best = i; }
    }
    return best;
  }
};
Tilth.Scene.sharp = 2;  // pixels of the picture over those of the layout: smooth edges
Tilth.Scene.slow = 50;  // time between pictures beyond which movements have fewer pixels [ms]
Tilth.Scene.still = 150;  // time without movement after which they have all [ms]
Tilth.Scene.rulers = { left: 48, bottom: 34 };  // room for the labels of axes [pixels of the layout]
Tilth.Scene.looks = { space: [0.5, -0.75, 0.42], below: [0.5, -0.75, -0.42], front: [0, -1, 0], side: [1, 0, 0], plan: [0, 0, 1] };

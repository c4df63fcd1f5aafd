// SPDX-License-Identifier: BSD-3-Clause
// The picture of the body: the same in the plane and in space, seen in parallel projection.
"use strict";
Tilth.Scene = class {
  constructor(canvas, body, maps) {
    this.body = body; this.canvas = canvas; this.plane = body.dim === 2;
    this.low = [0, 1, 2].map((k) => body.low[k] ?? 0); this.high = [0, 1, 2].map((k) => body.high[k] ?? 0);
    this.middle = this.low.map((low, k) => 0.5 * (low + this.high[k]));
    this.half = this.low.map((low, k) => 0.5 * (this.high[k] - low));
    this.radius = Math.hypot(...this.half) || 1;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.autoClear = false;
    this.scene = new THREE.Scene(); this.soil = new THREE.Group(); this.lines = new THREE.Group();
    this.scene.add(this.soil, this.lines, new THREE.HemisphereLight(0xffffff, 0x777777, 2.5));
    this.camera = new THREE.OrthographicCamera();
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableRotate = !this.plane; this.controls.zoomToCursor = true;
    this.controls.screenSpacePanning = true;
    if (this.plane) {
      this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN; this.controls.touches.ONE = THREE.TOUCH.PAN;
    }
    this.controls.addEventListener("change", () => this.draw());
    this.uniforms = {
      planes: { value: [0, 1, 2].map(() => new THREE.Vector4(0, 0, 0, 1)) },
      range: { value: new THREE.Vector2(0, 1) }, map: { value: null }, plane: { value: this.plane ? 1 : 0 },
      reach: { value: body.enlarged * (this.plane ? 1.0 : 0.97) }, size: { value: 4 },
    };
    this.maps = Object.fromEntries(Object.entries(maps).map(([name, colours]) => [name, this.texture(colours)]));
    this.material = (name, more = {}) => new THREE.ShaderMaterial({
      ...Tilth.shaders[name], uniforms: { ...this.uniforms, ...more }, side: THREE.DoubleSide, depthTest: !this.plane, depthWrite: !this.plane,
    });
    this.materials = { domains: this.material("domains"), points: this.material("points") };
    this.sums = null; this.drawn = "domains"; this.shown = { tracked: true, rigid: true, boundary: true };
    this.pixels = new THREE.Vector2(1, 1); this.pending = false; this.frames = 0;
    if (this.plane) this.prepareField();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.look(); this.resize();
  }

  texture(colours) {
    const bytes = new Uint8Array(1024);
    for (let i = 0; i < 256; i++) bytes.set([colours[3 * i], colours[3 * i + 1], colours[3 * i + 2], 255], 4 * i);
    const texture = new THREE.DataTexture(bytes, 256, 1, THREE.RGBAFormat);
    texture.magFilter = texture.minFilter = THREE.LinearFilter; texture.needsUpdate = true;
    return texture;
  }

  // A continuous field in the plane: weighted sums over the domains around each pixel, then their mean.
  prepareField() {
    this.sums = new THREE.WebGLRenderTarget(4, 4, { type: THREE.HalfFloatType, depthBuffer: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    this.sumMaterial = this.material("sums", { reach: { value: 2.8 * this.body.enlarged } });
    Object.assign(this.sumMaterial, { transparent: true, blending: THREE.CustomBlending, blendEquation: THREE.AddEquation, blendSrc: THREE.OneFactor, blendDst: THREE.OneFactor });
    this.fieldScene = new THREE.Scene();
    const material = this.material("mean", { sums: { value: this.sums.texture }, gap: { value: this.gap = new THREE.Vector2() } });
    const whole = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    whole.frustumCulled = false; this.fieldScene.add(whole);
  }

  // Takes the numbers of one output: `position` and `edges` by component, `values` of the points.
  setFrame(frame) {
    const n = frame.count, dim = this.body.dim, centre = new Float32Array(3 * n);
    for (let k = 0; k < dim; k++) for (let i = 0; i < n; i++) centre[3 * i + k] = frame.position[k][i] - this.middle[k];
    const edge = [0, 1, 2].map(() => new Float32Array(3 * n)), full = frame.edges.length > dim;
    frame.edges.forEach((column, k) => {
      const which = full ? Math.floor(k / dim) : k, axis = full ? k % dim : k;
      for (let i = 0; i < n; i++) edge[which][3 * i + axis] = column[i];
    });
    this.centre = centre;
    this.soil.children.forEach((each) => each.geometry.dispose()); this.soil.clear();
    this.value = new THREE.InstancedBufferAttribute(new Float32Array(n), 1);
    this.pointValue = new THREE.BufferAttribute(this.value.array, 1);
    const box = new THREE.InstancedBufferGeometry();
    box.setAttribute("corner", new THREE.BufferAttribute(this.corners(), 3));
    box.setAttribute("position", box.getAttribute("corner"));
    [["centre", centre], ["a", edge[0]], ["b", edge[1]], ["c", edge[2]]].forEach(([name, array]) => box.setAttribute(name, new THREE.InstancedBufferAttribute(array, 3)));
    box.setAttribute("value", this.value); box.instanceCount = n;
    const cloud = new THREE.BufferGeometry();
    cloud.setAttribute("position", new THREE.BufferAttribute(centre, 3)); cloud.setAttribute("value", this.pointValue);
    this.box = new THREE.Mesh(box, this.materials.domains); this.cloud = new THREE.Points(cloud, this.materials.points);
    this.box.frustumCulled = this.cloud.frustumCulled = false;
    this.soil.add(this.box, this.cloud);
    this.setLines(frame.lines);
  }

  corners() {
    if (this.plane) return new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0]);
    const found = [];
    for (let axis = 0; axis < 3; axis++) for (const end of [-1, 1]) for (const [s, t] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
      const corner = [0, 0, 0]; corner[axis] = end; corner[(axis + 1) % 3] = s; corner[(axis + 2) % 3] = t; found.push(...corner);
    }
    return new Float32Array(found);
  }

  setValues(values) {
    const kept = this.value.array;
    for (let i = 0; i < kept.length; i++) kept[i] = Number.isNaN(values[i]) ? 2e38 : values[i];
    this.value.needsUpdate = this.pointValue.needsUpdate = true;
  }

  setScale(low, high, map) {
    this.uniforms.range.value.set(low, high > low ? high : low + 1e-30 + Math.abs(low) * 1e-6); this.uniforms.map.value = this.maps[map];
  }

  setSection(axis, sign, place) {
    const normal = [0, 0, 0]; normal[axis] = sign;
    this.uniforms.planes.value[axis].set(...normal, sign === 0 ? 1 : sign * (place - this.middle[axis]));
    this.draw();
  }

  setLines(parts) {
    this.lines.traverse((each) => each.geometry && each.geometry.dispose()); this.lines.clear();
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    const colours = { tracked: [0.9, 0, 0.49], rigid: dark ? [0.85, 0.85, 0.85] : [0.15, 0.15, 0.15], boundary: dark ? [0.95, 0.6, 0.25] : [0.7, 0.33, 0.05] };
    for (const part of parts) {
      const group = new THREE.Group(), n = part.position[0].length, at = new Float32Array(3 * n);
      part.position.forEach((column, k) => { for (let i = 0; i < n; i++) at[3 * i + k] = column[i] - this.middle[k]; });
      group.userData.kind = part.kind;
      if (!this.plane && part.kind !== "tracked") group.add(this.solid(at, part.kind));
      if (this.plane || part.kind === "tracked") group.add(this.strokes(this.plane ? at : this.sides(at), colours[part.kind], part.kind === "boundary" ? 1.2 : this.plane ? 1.6 : 0.6));
      this.lines.add(group);
    }
  }

  solid(at, kind) {
    const shape = new THREE.BufferGeometry(), rigid = kind === "rigid";
    shape.setAttribute("position", new THREE.BufferAttribute(at, 3)); shape.computeVertexNormals();
    const material = new THREE.MeshLambertMaterial({ color: rigid ? 0x9aa3ad : 0xc98a4b, side: THREE.DoubleSide, transparent: true, opacity: rigid ? 0.6 : 0.14, depthWrite: false });
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
    const n = at.length / 6, start = new Float32Array(3 * n), end = new Float32Array(3 * n);
    for (let i = 0; i < n; i++) { start.set(at.subarray(6 * i, 6 * i + 3), 3 * i); end.set(at.subarray(6 * i + 3, 6 * i + 6), 3 * i); }
    const shape = new THREE.InstancedBufferGeometry();
    shape.setAttribute("corner", new THREE.BufferAttribute(new Float32Array([-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1]), 2));
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(18), 3));
    shape.setAttribute("start", new THREE.InstancedBufferAttribute(start, 3)); shape.setAttribute("end", new THREE.InstancedBufferAttribute(end, 3));
    shape.instanceCount = n;
    const material = this.material("lines", { tint: { value: new THREE.Color(...tint) }, pixels: { value: this.pixels }, width: { value: width } });
    const mesh = new THREE.Mesh(shape, material); mesh.frustumCulled = false; mesh.renderOrder = 3;
    return mesh;
  }

  look() {
    const far = 20 * this.radius;
    this.controls.target.set(0, 0, 0);
    if (this.plane) { this.camera.position.set(0, 0, far / 2); this.camera.up.set(0, 1, 0); }
    else { this.camera.up.set(0, 0, 1); this.camera.position.set(0.5, -0.75, 0.42).multiplyScalar(far / 2); }
    Object.assign(this.camera, { near: 0, far: 2 * far, zoom: 1 }); this.controls.update();
  }

  // Fits the canvas to its place, and the whole body into the canvas at zoom 1.
  resize() {
    const width = this.canvas.parentElement.clientWidth;
    if (!width) return;
    const room = Math.min(0.72 * window.innerHeight, 640), flat = this.half[1] / Math.max(this.half[0], 1e-30);
    const height = Math.round(this.plane ? Math.min(room, Math.max(220, width * flat * 1.1 + 90)) : Math.min(room, Math.max(300, 0.66 * width)));
    this.renderer.setSize(width, height, false); this.canvas.style.height = `${height}px`;
    const [wide, high] = this.extent();
    const top = this.plane ? 70 : 0;  // room for the key
    const unit = Math.max(wide / width, high / Math.max(height - top - 14, 50)) || 1;
    Object.assign(this.camera, { left: -width * unit, right: width * unit, top: (height + (top ? top - 14 : 0)) * unit, bottom: -(height - (top ? top - 14 : 0)) * unit });
    this.camera.updateProjectionMatrix(); this.unit = 2 * unit; this.pixels.set(width, height);
    if (this.sums) { const ratio = this.renderer.getPixelRatio(); this.sums.setSize(Math.round(width * ratio), Math.round(height * ratio)); }
    this.draw();
  }

  // Half width and height of the whole body as seen from where the camera is [length].
  extent() {
    if (this.plane) return [1.05 * this.half[0], 1.05 * this.half[1]];
    this.camera.updateMatrixWorld();
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    return [right, up].map((axis) => 1.08 * (Math.abs(axis.x) * this.half[0] + Math.abs(axis.y) * this.half[1] + Math.abs(axis.z) * this.half[2]));
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => { this.pending = false; this.render(); });
  }

  render() {
    if (!this.box) return;
    const ratio = this.renderer.getPixelRatio(), field = this.drawn === "field" && this.sums;
    this.uniforms.size.value = Math.max(2, ratio * (0.95 * this.body.spacing * this.camera.zoom) / this.unit);
    for (const each of this.lines.children) each.visible = this.shown[each.userData.kind];
    this.renderer.setClearColor(getComputedStyle(this.canvas.parentElement).backgroundColor, 1); this.renderer.clear();
    this.cloud.visible = this.drawn === "points"; this.box.visible = this.drawn === "domains" || field;
    if (field) {
      this.lines.visible = false; this.box.material = this.sumMaterial;
      const gap = (0.6 * this.body.spacing * this.camera.zoom) / this.unit;
      this.gap.set(gap / this.pixels.x, gap / this.pixels.y);
      this.renderer.setRenderTarget(this.sums); this.renderer.setClearColor(0, 0); this.renderer.clear();
      this.renderer.render(this.scene, this.camera); this.renderer.setRenderTarget(null);
      this.renderer.render(this.fieldScene, this.camera);
      this.box.material = this.materials.domains; this.box.visible = false; this.lines.visible = true;
    }
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
  }

  // Returns the row of the point nearest to a place in the canvas [pixels], the front one in space.
  pick(x, y) {
    const { width, height } = this.canvas.getBoundingClientRect(), place = new THREE.Vector3(), planes = this.uniforms.planes.value;
    const reach = Math.max(10, (0.6 * this.body.spacing * this.camera.zoom) / this.unit), n = this.centre.length / 3;
    let best = -1, least = Infinity;
    for (let i = 0; i < n; i++) {
      place.fromArray(this.centre, 3 * i);
      if (planes.some((p) => p.x * place.x + p.y * place.y + p.z * place.z > p.w)) continue;
      place.project(this.camera);
      const away = Math.hypot((place.x * 0.5 + 0.5) * width - x, (0.5 - place.y * 0.5) * height - y);
      if (away > reach) continue;
      const rank = this.plane ? away : place.z * 40 * this.radius + (away / reach) * this.body.spacing;
      if (rank < least) { least = rank; best = i; }
    }
    return best;
  }
};

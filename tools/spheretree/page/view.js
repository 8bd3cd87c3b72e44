// SPDX-License-Identifier: GPL-3.0-or-later
// The 3D view: meshes with the spheres of a level around them, coloured by overhang and gap. Draws only when something
// changes. Objects of the same model share its geometry: a scene may have thousands of them.
'use strict';

class SphereView {
  static RAMP = ['#f3efdc', '#f5c766', '#e8743b', '#b3263c', '#5a1846'];  // none to most
  static GAP = '#1e6bff';
  static BONE = '#e6dcc6';
  static TONES = ['#4e79a7', '#f28e2b', '#59a14f', '#e15759', '#76b7b2', '#edc948', '#b07aa1', '#9c755f'];  // branches, objects

  // `place`: an element of class view. Throws if the browser has no WebGL.
  constructor(place) {
    place.innerHTML = `<div class="stage"><canvas tabindex="0" role="img" aria-label="3D view. Arrow keys turn, plus and minus zoom, Home shows all."></canvas>
      <div class="says" role="status" aria-live="polite"></div></div><div class="panel"></div>`;
    this.place = place;
    this.canvas = place.querySelector('canvas');
    this.says = place.querySelector('.says');
    this.panel = place.querySelector('.panel');
    this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.sortObjects = false;  // drawn in the order: meshes, depth of the spheres, spheres, marks
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.layers = [0, 1, 2].map(() => { const group = new THREE.Group(); this.scene.add(group); return group; });
    this.objects = [];
    this.level = 0;
    this.look = 'mesh';
    this.ownScale = false;  // colours from 0 to the worst of the object, not of the scene
    this.target = new THREE.Vector3();
    this.direction = new THREE.Vector3(0.5, -1, 0.45).normalize();
    this.distance = this.extent = 10;
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
  }

  listen() {
    let last = null;
    this.canvas.addEventListener('pointerdown', e => { last = e; this.canvas.setPointerCapture(e.pointerId); });
    this.canvas.addEventListener('pointerup', () => { last = null; });
    this.canvas.addEventListener('pointermove', e => {
      if (!last) return;
      const dx = e.clientX - last.clientX, dy = e.clientY - last.clientY;
      if (e.shiftKey || e.buttons & 6) this.pan(dx, dy); else this.turn(-dx * 0.008, dy * 0.008);
      last = e;
    });
    this.canvas.addEventListener('dblclick', e => {
      const index = this.objectAt(e.offsetX, e.offsetY);
      if (index >= 0) this.setShown(index, false);
    });
    this.canvas.addEventListener('contextmenu', e => e.preventDefault());
    this.canvas.addEventListener('wheel', e => { e.preventDefault(); this.zoom(Math.exp(e.deltaY * 0.001)); }, {passive: false});
    this.canvas.addEventListener('keydown', e => {
      const act = {ArrowLeft: () => this.turn(0.12, 0), ArrowRight: () => this.turn(-0.12, 0), ArrowUp: () => this.turn(0, -0.12),
        ArrowDown: () => this.turn(0, 0.12), '+': () => this.zoom(0.85), '=': () => this.zoom(0.85), '-': () => this.zoom(1.18),
        Home: () => this.showAll()}[e.key];
      if (act) { e.preventDefault(); act(); }
    });
  }

  turn(around, over) {
    const d = this.direction, height = Math.min(1.55, Math.max(-1.55, Math.asin(d.z) + over)), turn = Math.atan2(d.y, d.x) + around;
    d.set(Math.cos(turn) * Math.cos(height), Math.sin(turn) * Math.cos(height), Math.sin(height));
    this.draw();
  }
  zoom(factor) { this.distance *= factor; this.draw(); }
  pan(dx, dy) {
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const scale = 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360) / this.canvas.clientHeight;
    this.target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
    this.draw();
  }
  resize() {
    const stage = this.canvas.parentElement;
    this.renderer.setSize(stage.clientWidth, stage.clientHeight, false);
    this.camera.aspect = stage.clientWidth / stage.clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
  draw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => { this.pending = 0; this.render(); });
  }
  render() {
    this.camera.position.copy(this.target).addScaledVector(this.direction, this.distance);
    this.camera.near = this.distance / 100;
    this.camera.far = this.distance * 4 + 2 * this.extent;
    this.camera.lookAt(this.target);
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.frames = (this.frames || 0) + 1;
  }

  // objects: [{name, mesh, tree, position_mm, quaternion_wxyz, levels, colour}], as model.cpp packs them. Mesh
  // or tree may be absent; colour: of the mesh.
  setObjects(objects) {
    for (const layer of this.layers) while (layer.children.length) this.drop(layer, layer.children[0]);
    const models = new Map();
    this.objects = objects.map((object, i) => {
      const key = object.tree || object.mesh;
      if (!models.has(key)) models.set(key, new ViewModel(object));
      return new ViewObject(object, models.get(key), objects.length > 1 ? SphereView.TONES[i % SphereView.TONES.length] : null);
    });
    for (const object of this.objects) {
      if (object.surface) this.layers[0].add(object.surface);
      if (object.balls) { this.layers[1].add(object.depth); this.layers[2].add(object.balls); }
    }
    this.marks = new THREE.Group();
    this.layers[2].add(this.marks);
    this.setLevel(Math.min(this.level, this.levelCount() - 1));
    this.showAll();
  }
  drop(layer, child) { layer.remove(child); if (child.geometry) child.geometry.dispose(); if (child.material) child.material.dispose(); }
  levelCount() { return Math.max(1, ...this.objects.map(object => object.levelCount())); }

  setLevel(level) {
    this.level = level;
    for (const object of this.objects) object.setLevel(level);
    this.setLook(this.look);
  }
  // mesh: the mesh alone, coloured by how far the spheres stand off; solid: spheres, by branch or object; heat:
  // spheres, by overhang; glass: spheres over the mesh
  setLook(look) {
    this.look = look;
    const most = this.ownScale ? 0 : this.most();
    for (const object of this.objects) object.setLook(look, most);
    this.draw();
  }

  // The worst of the objects that are shown, at this level: the end of the colours, unless each has its own.
  most() { return this.objects.reduce((most, object) => object.shown ? Math.max(most, object.most || 0) : most, 0); }

  // `onShown`, if a page sets it, is called after each change.
  setShown(index, shown) {
    this.objects[index].shown = shown;
    this.setLook(this.look);
    if (this.onShown) this.onShown();
    this.draw();
  }
  // The object whose spheres are foremost at this point of the canvas; -1: none.
  objectAt(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight), this.camera);
    let nearest = Infinity, found = -1;
    this.objects.forEach((object, index) => {
      const at = object.shown ? object.firstHit(ray.ray) : Infinity;
      if (at < nearest) { nearest = at; found = index; }
    });
    return found;
  }

  showAll() {
    const box = new THREE.Box3();
    for (const object of this.objects) if (object.shown) box.union(object.box());
    if (this.alsoShown) box.union(this.alsoShown());
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
    box.getCenter(this.target);
    this.extent = box.getSize(new THREE.Vector3()).length();
    // As near as every corner of the box allows.
    const stage = this.canvas.parentElement, tangent = Math.tan(this.camera.fov * Math.PI / 360), d = this.direction;
    const right = new THREE.Vector3(0, 0, 1).cross(d).normalize(), up = d.clone().cross(right);
    const wide = tangent * stage.clientWidth / Math.max(1, stage.clientHeight);
    this.distance = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const p = new THREE.Vector3(...['x', 'y', 'z'].map((axis, k) => box[corner >> k & 1 ? 'max' : 'min'][axis])).sub(this.target);
      this.distance = Math.max(this.distance, 1.06 * (p.dot(d) + Math.max(Math.abs(p.dot(up)) / tangent, Math.abs(p.dot(right)) / wide)));
    }
    this.says.textContent = '';
    if (this.marks) this.marks.children.slice().forEach(child => this.drop(this.marks, child));
    this.draw();
  }

  // Moves to a point of an object (frame of the object, mm), seen from the side, and marks how high it stands.
  jump(index, point, height, words) {
    const object = this.objects[index], p = object.toWorld(point), foot = object.nearestVertex(p);
    const centre = object.box().getCenter(new THREE.Vector3());
    const out = p.clone().sub(foot && foot.distanceTo(p) > 1e-9 ? foot : centre).normalize();
    const side = new THREE.Vector3().crossVectors(out, Math.abs(out.z) < 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0)).normalize();
    this.target.copy(p);
    this.direction.copy(side).addScaledVector(out, 0.8).normalize();
    const size = object.box().getSize(new THREE.Vector3()).length();
    this.distance = Math.max(height * 12, size * 1.2);  // the whole object is seen, so that one knows which it is
    this.marks.children.slice().forEach(child => this.drop(this.marks, child));
    const material = () => new THREE.MeshBasicMaterial({color: SphereView.GAP, depthTest: false, transparent: true});
    const dot = new THREE.Mesh(new THREE.SphereBufferGeometry(this.distance * 0.006, 16, 12), material());
    const ring = new THREE.Mesh(new THREE.TorusBufferGeometry(this.distance * 0.03, this.distance * 0.002, 8, 48), material());
    dot.position.copy(p);
    ring.position.copy(p);
    ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.direction);
    this.marks.add(dot, ring);
    this.says.textContent = words;
    this.draw();
  }
}

// A tree and a mesh as a page brings them; shared by the objects that look alike.
class ViewModel {
  constructor(object) {
    this.given = object;
    this.level = -1;
    if (object.mesh) this.makeSurface(object.mesh);
    if (object.tree) this.makeBalls(object.tree);
  }
  levelCount() { return this.given.tree ? this.given.tree.levels.length - 1 : 1; }
  static summed(deltas) {  // the differences of model.cpp, undone
    const out = new Uint32Array(deltas.length);
    let last = 0;
    for (let i = 0; i < deltas.length; ++i) out[i] = last = (last + (deltas[i] >>> 1 ^ -(deltas[i] & 1))) >>> 0;
    return out;
  }

  makeSurface(mesh) {
    const count = mesh.positions.length / 3, positions = new Float32Array(3 * count);
    for (let axis = 0; axis < 3; ++axis) {
      const q = ViewModel.summed(mesh.positions.subarray(axis * count, (axis + 1) * count));
      for (let i = 0; i < count; ++i) positions[3 * i + axis] = mesh.low[axis] + q[i] * mesh.step;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(new THREE.BufferAttribute(ViewModel.summed(mesh.indices), 1));
    geometry.computeVertexNormals();
    this.heat = new THREE.BufferAttribute(new Float32Array(count), 1);
    geometry.setAttribute('heat', this.heat);
    geometry.computeBoundingBox();
    this.surface = geometry;
  }

  makeBalls(tree) {
    const levels = this.levelCount();
    this.sets = [];
    for (let level = 0; level < levels; ++level) {
      const nodes = [];
      for (let node = 0; node < tree.levels[level + 1]; ++node) if (node >= tree.levels[level] || tree.ends[node]) nodes.push(node);
      this.sets.push(nodes);
    }
    this.at = new Float32Array(tree.spheres.length);
    for (let i = 0; i < this.at.length; ++i) this.at[i] = tree.spheres[i] * tree.step + (i % 4 < 3 ? tree.low[i % 4] : 0);
    const tones = SphereView.TONES.map(tone => new THREE.Color(tone));
    this.tone = node => tones[(tree.branch ? tree.branch[node] : node) % tones.length];
  }
  leafBox() {
    const box = new THREE.Box3();
    for (const node of this.sets[this.sets.length - 1]) {
      const c = new THREE.Vector3(this.at[4 * node], this.at[4 * node + 1], this.at[4 * node + 2]), r = this.at[4 * node + 3];
      box.expandByPoint(c.clone().addScalar(r)).expandByPoint(c.addScalar(-r));
    }
    return box;
  }

  overhangOf(node) {
    const tree = this.given.tree;
    if (!tree.overhang) return 0;
    let level = 0;
    while (node >= tree.levels[level + 1]) ++level;
    return tree.overhang[node] / 255 * tree.overhang_max[level];
  }

  setLevel(level) {
    const wanted = Math.min(level, this.levelCount() - 1);
    if (wanted === this.level) return;
    this.level = wanted;
    const nodes = this.sets[this.level], sphere = new Float32Array(4 * nodes.length), heat = new Float32Array(nodes.length), tone = new Float32Array(3 * nodes.length);
    const figures = this.given.levels && this.given.levels[this.level];
    let most = 0;
    nodes.forEach((node, i) => {
      sphere.set(this.at.subarray(4 * node, 4 * node + 4), 4 * i);
      heat[i] = this.overhangOf(node);
      this.tone(node).toArray(tone, 3 * i);
      most = Math.max(most, heat[i]);
    });
    this.most = figures ? figures.overhang_mm.max : most;
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute('sphere', new THREE.InstancedBufferAttribute(sphere, 4));
    geometry.setAttribute('heat', new THREE.InstancedBufferAttribute(heat.map(value => this.most > 0 ? value / this.most : 0), 1));
    geometry.setAttribute('tone', new THREE.InstancedBufferAttribute(tone, 3));
    geometry.maxInstancedCount = nodes.length;
    if (this.balls) this.balls.dispose();
    this.balls = geometry;
    this.sphere = sphere;
    this.stale = true;  // the surface is coloured when that is looked at: it takes most of the time of a large scene
  }
  // Share of the surface's vertices that are in no sphere.
  get gaps() {
    if (this.surface) this.heatSurface();
    return this.gapShare || 0;
  }
  // For each vertex, how far the union of the spheres reaches above it along its normal; below 0: the vertex is in no
  // sphere.
  heatSurface() {
    if (!this.stale) return;
    const sphere = this.sphere, p = this.surface.getAttribute('position').array, n = this.surface.getAttribute('normal').array;
    const size = this.surface.boundingBox.getSize(new THREE.Vector3()).length(), tolerance = 1e-4 * size;
    const balls = sphere.length / 4, enter = new Float64Array(balls), leave = new Float64Array(balls);
    let gaps = 0;
    for (let v = 0; v < this.heat.array.length; ++v) {
      let least = Infinity, hits = 0;
      for (let i = 0; i < balls; ++i) {
        const dx = p[3 * v] - sphere[4 * i], dy = p[3 * v + 1] - sphere[4 * i + 1], dz = p[3 * v + 2] - sphere[4 * i + 2], r = sphere[4 * i + 3];
        const along = dx * n[3 * v] + dy * n[3 * v + 1] + dz * n[3 * v + 2], off2 = dx * dx + dy * dy + dz * dz;
        least = Math.min(least, Math.sqrt(off2) - r);
        const root = along * along - off2 + r * r;
        if (root <= 0) continue;
        const half = Math.sqrt(root);
        if (half - along > 0) { enter[hits] = -along - half; leave[hits++] = half - along; }
      }
      let reach = 0;
      if (least <= tolerance)
        for (let grew = true; grew;) {
          grew = false;
          for (let i = 0; i < hits; ++i) if (enter[i] <= reach + tolerance && leave[i] > reach) { reach = leave[i]; grew = true; }
        }
      else ++gaps;
      this.heat.array[v] = least > tolerance ? -1 : this.most > 0 ? Math.min(1, reach / this.most) : 0;
    }
    this.heat.needsUpdate = true;
    this.gapShare = gaps / this.heat.array.length;
    this.stale = false;
  }
}

// A model at its place in the scene.
class ViewObject {
  // `tone`: the colour of its spheres; null: they are coloured by branch.
  constructor(object, model = new ViewModel(object), tone = null) {
    this.given = object;
    this.model = model;
    this.shown = true;
    this.pose = new THREE.Matrix4();
    const [x, y, z] = object.position_mm || [0, 0, 0], [qw, qx, qy, qz] = object.quaternion_wxyz || [1, 0, 0, 0];
    this.pose.compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(qx, qy, qz, qw), new THREE.Vector3(1, 1, 1));
    if (object.mesh) this.surface = new THREE.Mesh(model.surface, surfaceMaterial());
    if (object.mesh && object.colour) this.surface.material.uniforms.plain.value = new THREE.Color(object.colour);
    if (object.tree) {
      this.balls = new THREE.Mesh(new THREE.InstancedBufferGeometry(), ballMaterial());
      this.depth = new THREE.Mesh(this.balls.geometry, ballMaterial());
      this.depth.material.colorWrite = false;
      this.balls.material.uniforms.plain.value = new THREE.Color(tone || SphereView.BONE);
      this.balls.material.uniforms.branched.value = tone ? 0 : 1;
    }
    for (const part of [this.surface, this.depth, this.balls]) if (part) this.place(part);
  }
  place(part) {
    part.matrixAutoUpdate = false;
    part.matrix.copy(this.pose);
    part.frustumCulled = false;
  }
  setPose(position, quaternion) {  // THREE.Vector3, THREE.Quaternion
    this.pose.compose(position, quaternion, new THREE.Vector3(1, 1, 1));
    for (const part of [this.surface, this.depth, this.balls]) if (part) { part.matrix.copy(this.pose); part.matrixWorldNeedsUpdate = true; }
  }
  toWorld(point) { return new THREE.Vector3(...point).applyMatrix4(this.pose); }
  levelCount() { return this.model.levelCount(); }
  get sets() { return this.model.sets; }
  get level() { return this.model.level; }
  get most() { return this.model.most; }
  get gaps() { return this.model.gaps; }

  setLevel(level) {
    if (!this.balls) return;
    this.model.setLevel(level);
    this.balls.geometry = this.depth.geometry = this.model.balls;
  }
  // How far along the ray (world) it meets a sphere of the level; Infinity: it does not.
  firstHit(ray) {
    const local = ray.clone().applyMatrix4(new THREE.Matrix4().getInverse(this.pose)), {origin: o, direction: d} = local, s = this.model.sphere || [];
    let least = Infinity;
    for (let i = 0; i < s.length; i += 4) {
      const x = s[i] - o.x, y = s[i + 1] - o.y, z = s[i + 2] - o.z, along = x * d.x + y * d.y + z * d.z;
      const under = along * along - x * x - y * y - z * z + s[i + 3] * s[i + 3];
      if (under > 0 && along > 0) least = Math.min(least, along - Math.sqrt(under));
    }
    return least;
  }

  // `most`: at the end of the colours; 0: the worst of the object.
  setLook(look, most = 0) {
    for (const part of [this.surface, this.balls]) if (part) part.material.uniforms.gain.value = most > 0 && this.most ? this.most / most : 1;
    if (this.balls) {
      this.balls.visible = this.shown && (look !== 'mesh' || !this.surface);
      this.balls.material.uniforms.tinted.value = look === 'heat' || (look === 'mesh' && !this.surface) ? 1 : 0;
      this.depth.visible = this.balls.visible && look === 'glass';
      const glass = look === 'glass' && this.surface !== undefined;
      this.balls.material.uniforms.opacity.value = glass ? 0.42 : 1;
      this.balls.material.transparent = glass;
      this.balls.material.depthWrite = !glass;
    }
    if (this.surface) {
      if (look === 'mesh' && this.balls) this.model.heatSurface();
      this.surface.visible = this.shown && (look === 'mesh' || look === 'glass' || !this.balls);
      this.surface.material.uniforms.tinted.value = look === 'mesh' && this.balls ? 1 : 0;
    }
  }

  box() {
    const box = new THREE.Box3();
    if (this.surface) box.copy(this.model.surface.boundingBox);
    else if (this.model.at) box.copy(this.model.leafBox());
    return box.isEmpty() ? box : box.applyMatrix4(this.pose);
  }

  nearestVertex(world) {
    if (!this.surface) return null;
    const local = world.clone().applyMatrix4(new THREE.Matrix4().getInverse(this.pose)), p = this.surface.geometry.getAttribute('position').array;
    let best = Infinity, at = 0;
    for (let v = 0; v < p.length; v += 3) {
      const d = (p[v] - local.x) ** 2 + (p[v + 1] - local.y) ** 2 + (p[v + 2] - local.z) ** 2;
      if (d < best) { best = d; at = v; }
    }
    return new THREE.Vector3(p[at], p[at + 1], p[at + 2]).applyMatrix4(this.pose);
  }
}

// Colour by `heat`: 0..1 along the ramp, below 0 a gap. One light from the eye and one from above.
function heatUniforms() {
  return {ramp: {value: SphereView.RAMP.map(colour => new THREE.Color(colour))}, gap: {value: new THREE.Color(SphereView.GAP)},
    plain: {value: new THREE.Color(SphereView.BONE)}, branched: {value: 0}, gain: {value: 1}, tinted: {value: 1}, opacity: {value: 1}};
}
const HEAT = `uniform vec3 ramp[5]; uniform vec3 gap; uniform float tinted; uniform float gain; uniform float opacity; varying float vHeat; varying vec3 vPlain;
  vec4 lit(vec3 n) { float t = clamp(vHeat * gain, 0.0, 1.0) * 4.0;
  vec3 c = mix(ramp[0], ramp[1], clamp(t, 0.0, 1.0)); c = mix(c, ramp[2], clamp(t - 1.0, 0.0, 1.0));
  c = mix(c, ramp[3], clamp(t - 2.0, 0.0, 1.0)); c = mix(c, ramp[4], clamp(t - 3.0, 0.0, 1.0));
  c = mix(vPlain, vHeat < -0.5 ? gap : c, tinted);
  float light = 0.35 + 0.5 * max(n.z, 0.0) + 0.22 * max(dot(n, normalize(vec3(-0.4, 0.8, 0.5))), 0.0);
  return vec4(c * light, opacity); }`;

function surfaceMaterial() {
  return new THREE.ShaderMaterial({
    uniforms: heatUniforms(), side: THREE.DoubleSide, extensions: {derivatives: true},
    vertexShader: `uniform vec3 plain; attribute float heat; varying float vHeat; varying vec3 vPlain; varying vec3 vNormal; varying vec3 vPlace;
      void main() { vHeat = heat; vPlain = plain; vNormal = normalMatrix * normal; vec4 place = modelViewMatrix * vec4(position, 1.0);
      vPlace = place.xyz; gl_Position = projectionMatrix * place; }`,
    // At a sharp edge the mean normal of a vertex belongs to neither side: there a triangle has its own.
    fragmentShader: `${HEAT} varying vec3 vNormal; varying vec3 vPlace;
      void main() { vec3 n = normalize(gl_FrontFacing ? vNormal : -vNormal), own = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
      gl_FragColor = lit(dot(n, own) < 0.85 ? own : n); }`,
  });
}

// A square that faces the eye and just covers the sphere; each pixel meets the sphere itself, so that no facet hides
// the mesh or lets it through.
function ballMaterial() {
  return new THREE.ShaderMaterial({
    uniforms: heatUniforms(), side: THREE.DoubleSide, extensions: {fragDepth: true},
    vertexShader: `uniform vec3 plain; uniform float branched; attribute float heat; attribute vec4 sphere; attribute vec3 tone;
      varying float vHeat; varying vec3 vPlain; varying vec3 vPlace; varying vec3 vCentre; varying float vRadius;
      void main() { vHeat = heat; vRadius = sphere.w; vPlain = mix(plain * (0.8 + 0.4 * tone.g), tone, branched); vCentre = (modelViewMatrix * vec4(sphere.xyz, 1.0)).xyz;
      float d2 = dot(vCentre, vCentre), size = vRadius * sqrt(d2 / max(d2 - vRadius * vRadius, 1e-3 * d2));
      vec3 to = normalize(vCentre), right = normalize(cross(vec3(0.0, 1.0, 0.0001), to)), up = cross(to, right);
      vPlace = vCentre + size * (position.x * right + position.y * up);
      gl_Position = projectionMatrix * vec4(vPlace, 1.0); }`,
    fragmentShader: `uniform mat4 projectionMatrix; ${HEAT} varying vec3 vPlace; varying vec3 vCentre; varying float vRadius;
      void main() { vec3 ray = normalize(vPlace); float along = dot(ray, vCentre);
      float under = along * along - dot(vCentre, vCentre) + vRadius * vRadius;
      if (under < 0.0) discard;
      vec3 hit = ray * (along - sqrt(under)); vec4 clip = projectionMatrix * vec4(hit, 1.0);
      gl_FragDepthEXT = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
      gl_FragColor = lit((hit - vCentre) / vRadius); }`,
  });
}

// The controls that every page has: level, look, legend. Returns what a page calls after it changed the objects.
function addViewControls(view, onLevel) {
  const box = document.createElement('div');
  box.className = 'panel';
  box.innerHTML = `<label>Level <output></output><input type="range" class="level" min="0" step="1"></label>
    <label>Show <select class="look"><option value="mesh">Mesh by stand-off</option>
    <option value="solid">Spheres</option><option value="heat">Spheres by overhang</option>
    <option value="glass">Glass spheres, mesh within</option></select></label>
    <div class="legend"><div class="scale"><div class="ramp"></div><div class="ends"><span>0</span><span class="most"></span></div>
    <label class="check"><input type="checkbox" class="own"> each object by its own worst</label></div>
    <div class="note says-what"></div><div class="note says-gap"></div></div><button type="button" class="all">Show all</button>`;
  view.panel.append(box);
  const slider = box.querySelector('.level'), output = box.querySelector('output'), most = box.querySelector('.most'), what = box.querySelector('.says-what'), gap = box.querySelector('.says-gap'), own = box.querySelector('.own'), look = box.querySelector('.look');
  box.querySelector('.ramp').style.background = `linear-gradient(90deg,${SphereView.RAMP.join(',')})`;
  box.querySelector('.all').addEventListener('click', () => view.showAll());
  own.addEventListener('change', () => { view.ownScale = own.checked; view.setLook(view.look); describe(); });
  look.addEventListener('change', e => { view.setLook(e.target.value); describe(); });
  function describe() {
    output.textContent = `${view.level} of ${view.levelCount() - 1}` +
      (view.objects.length === 1 && view.objects[0].sets ? ` · ${view.objects[0].sets[view.objects[0].level].length} spheres` : '');
    slider.setAttribute('aria-valuetext', output.textContent);
    const one = view.objects.length === 1 ? view.objects[0] : null, heats = view.look === 'mesh' || view.look === 'heat';
    const all = view.objects.filter(object => object.shown).map(object => object.most || 0), digits = value => value.toPrecision(3) + ' mm';
    const low = all.length ? Math.min(...all) : 0, high = all.reduce((a, b) => Math.max(a, b), 0);
    own.parentElement.hidden = Boolean(one);
    most.textContent = one || low === high || !view.ownScale ? digits(high) : `${digits(low)} to ${digits(high)}`;
    box.querySelector('.legend').hidden = !view.objects.some(object => object.balls);
    box.querySelector('.scale').hidden = !heats || !view.objects.some(object => object.given.tree && object.given.tree.overhang);
    what.textContent = view.look === 'mesh' ? 'How far the spheres stand above the surface, along its normal.' :
      view.look === 'heat' ? 'How far a sphere reaches out of the object.' : one ? 'A colour for each branch below the root.' : 'A colour for each object.';
    gap.innerHTML = view.look === 'mesh' ? `<span style="color:${SphereView.GAP}">&#9632;</span> in no sphere` +
      (one && one.surface && one.balls ? `: ${one.gaps ? (100 * one.gaps).toPrecision(2) : 0} % of the vertices` : '') : '';
  }
  function refresh() {
    // Without meshes, as on the page of a recording, there are spheres alone, and without their overhang.
    const has = {mesh: view.objects.some(object => object.surface), heat: view.objects.some(object => object.given.tree && object.given.tree.overhang)};
    has.glass = has.mesh;
    for (const option of look.options) option.hidden = has[option.value] === false;
    if (has[view.look] === false) view.setLook('solid');
    look.value = view.look;
    slider.max = view.levelCount() - 1;
    slider.value = view.level;
    slider.disabled = view.levelCount() < 2;
    const has_spheres = view.objects.some(object => object.balls);  // without, there is one way to look
    for (const part of [slider.parentElement, look.parentElement]) part.hidden = !has_spheres;
    describe();
  }
  slider.addEventListener('input', () => { view.setLevel(Number(slider.value)); describe(); if (onLevel) onLevel(view.level); });
  return {refresh, describe};
}

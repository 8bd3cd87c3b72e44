// SPDX-License-Identifier: GPL-3.0-or-later
// The 3D section of a report: a scene of objects, their worst spots, and recordings to replay.
// data: {models: {NAME: {tree, mesh}}, scenes: [{name, tool, objects: [{name, model, position_mm, quaternion_wxyz,
// levels}],
//   look: {from, at_mm, distance_mm}, replays: [{name, time, poses, wrench}]}]}; look: the first view, if not all
'use strict';

// Plays one recording in a view: the tool where it is shown (solid), where the hand is (glass), and the force as an
// arrow.
class Replay {
  constructor(view, data, tool, replay) {
    this.view = view;
    this.replay = replay;
    const model = data.models[tool.model];
    this.reference = new THREE.Vector3(...tool.reference_point_mm);
    this.shown = new ViewObject(model);
    this.hand = new ViewObject(model);
    for (const object of [this.shown, this.hand]) object.setLevel(99);
    this.shown.setLook(model.mesh ? 'mesh' : 'solid');
    this.hand.setLook('glass');
    if (this.shown.surface) this.shown.surface.material.uniforms.tinted.value = 0;
    for (const part of [this.shown.surface, this.shown.balls]) if (part) part.material.uniforms.plain.value = new THREE.Color('#b9c0c8');
    this.hand.balls.material.uniforms.tinted.value = this.shown.balls.material.uniforms.tinted.value = 0;
    this.hand.balls.material.uniforms.branched.value = this.shown.balls.material.uniforms.branched.value = 0;
    this.hand.balls.material.uniforms.plain.value = new THREE.Color('#4f8fd6');
    Object.assign(this.hand.balls.material, {transparent: true, depthWrite: false});
    this.hand.balls.material.uniforms.opacity.value = 0.35;
    this.hand.depth.visible = true;
    if (this.hand.surface) this.hand.surface.visible = false;
    this.parts = [[0, this.shown.surface], [1, this.shown.balls], [1, this.hand.depth], [2, this.hand.balls]].filter(part => part[1]);
    for (const [layer, part] of this.parts) view.layers[layer].add(part);
    this.size = this.shown.box().getSize(new THREE.Vector3()).length();
    const force = replay.wrench.reduce((most, value, i) => i % 6 < 3 ? Math.max(most, Math.abs(value)) : most, 0);
    this.scale = force > 0 ? 0.5 * this.size / force : 0;
    this.arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, '#e8743b');
    this.arrow.line.material.depthTest = this.arrow.cone.material.depthTest = false;
    view.layers[2].add(this.arrow);
    view.alsoShown = () => this.shown.box();
  }
  remove() {
    for (const [layer, part] of this.parts) this.view.drop(this.view.layers[layer], part);
    this.view.layers[2].remove(this.arrow);
    this.view.alsoShown = null;
  }
  show(index) {
    const p = this.replay.poses, at = 14 * index, w = this.replay.wrench;
    const place = (object, k) => {
      const q = new THREE.Quaternion(p[k + 4], p[k + 5], p[k + 6], p[k + 3]);
      object.setPose(new THREE.Vector3(p[k], p[k + 1], p[k + 2]).sub(this.reference.clone().applyQuaternion(q)), q);
    };
    place(this.hand, at);
    place(this.shown, at + 7);
    const force = new THREE.Vector3(w[6 * index], w[6 * index + 1], w[6 * index + 2]), newtons = force.length();
    this.arrow.visible = newtons > 1e-6;
    if (this.arrow.visible) {
      const length = Math.max(newtons * this.scale, 0.02 * this.size);
      this.arrow.position.set(p[at + 7], p[at + 8], p[at + 9]);
      this.arrow.setDirection(force.normalize());
      this.arrow.setLength(length, Math.min(0.3 * length, 0.06 * this.size), Math.min(0.2 * length, 0.035 * this.size));
    }
    this.view.draw();
    return newtons;
  }
  // Looks at where the tool goes.
  frame() {
    const box = new THREE.Box3(), p = this.replay.poses;
    for (let i = 0; i < p.length; i += 14) box.expandByPoint(new THREE.Vector3(p[i + 7], p[i + 8], p[i + 9]));
    box.getCenter(this.view.target);
    for (const object of this.view.objects) if (object.shown) box.union(object.box());
    box.getCenter(this.view.target);
    this.view.extent = box.getSize(new THREE.Vector3()).length() + this.size;  // a long tool is not cut off, and does not make all small
    this.view.distance = 1.6 * box.getSize(new THREE.Vector3()).length();
    this.view.draw();
  }
}

spheretreePage.whenReady(data => {
  const place = document.querySelector('.view');
  if (!place || !data.scenes.length) return;
  const view = new SphereView(place);
  view.level = 99;
  const choose = document.createElement('div');
  choose.className = 'panel';
  choose.innerHTML = '<label class="scenes">Scene <select></select></label>';
  view.panel.append(choose);
  const scenes = choose.querySelector('select');
  data.scenes.forEach((scene, i) => scenes.add(new Option(scene.name, i)));
  choose.hidden = data.scenes.length < 2;
  const controls = addViewControls(view, () => spots());
  const places = document.createElement('div');
  places.className = 'spots';
  places.setAttribute('role', 'group');
  places.setAttribute('aria-label', 'Worst spots');
  view.panel.append(places);
  const hidden = document.createElement('div');
  hidden.className = 'spots';
  hidden.setAttribute('role', 'group');
  hidden.setAttribute('aria-label', 'Hidden objects');
  view.panel.append(hidden);
  const current = () => data.scenes[scenes.value];

  function spots() {
    places.textContent = '';
    const worst = [];
    current().objects.forEach((object, i) => {
      const figures = object.levels && object.levels[Math.min(view.level, object.levels.length - 1)];
      if (!figures) return;
      if (figures.worst_overhang_at_mm) worst.push([figures.overhang_mm.max, i, figures.worst_overhang_at_mm, `${object.name}: out by ${figures.overhang_mm.max.toPrecision(3)} mm`]);
      if (figures.worst_gap_at_mm) worst.push([figures.max_gap_mm, i, figures.worst_gap_at_mm, `${object.name}: gap of ${figures.max_gap_mm.toPrecision(3)} mm`]);
    });
    worst.sort((a, b) => b[0] - a[0]);
    if (worst.length) {
      const head = document.createElement('div');
      head.className = 'note';
      head.textContent = `Worst spots of this level${worst.length > 6 ? `, 6 of ${worst.length}` : ''}`;
      places.append(head);
    }
    for (const [height, index, at, words] of worst.slice(0, 6)) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = words;
      button.addEventListener('click', () => view.jump(index, at, height, words));
      places.append(button);
    }
  }

  // What is hidden: a button each brings it back. The table says the same.
  view.onShown = () => {
    controls.describe();
    hidden.textContent = '';
    view.objects.forEach((object, i) => {
      document.querySelectorAll(`[data-eye="${i}"]`).forEach(button => {
        button.textContent = object.shown ? 'hide' : 'show';
        button.setAttribute('aria-pressed', String(!object.shown));
      });
      if (object.shown) return;
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = `show ${object.given.name}`;
      button.addEventListener('click', () => view.setShown(i, true));
      hidden.append(button);
    });
  };

  let replay = null, playing = 0;
  const time = document.querySelector('.time');
  if (time) time.innerHTML = `<label><span class="note">Recording</span> <select></select></label><button type="button">Play</button>
    <input type="range" min="0" step="1" aria-label="Time"><output></output><label><span class="note">Speed</span> <select class="speed"><option>0.1</option><option selected>1</option><option>4</option></select></label>`;
  const recordings = time && time.querySelector('select'), play = time && time.querySelector('button'), slider = time && time.querySelector('input');
  function showStep() {
    const index = Number(slider.value), newtons = replay.show(index), t = replay.replay.time[index];
    time.querySelector('output').textContent = `${t.toFixed(2)} s · ${newtons.toPrecision(3)} N`;
    slider.setAttribute('aria-valuetext', time.querySelector('output').textContent);
  }
  function stop() { cancelAnimationFrame(playing); playing = 0; if (play) play.textContent = 'Play'; }
  function chooseRecording() {
    stop();
    if (replay) replay.remove();
    replay = null;
    const chosen = current().replays[recordings.value];
    time.hidden = !chosen;
    if (!chosen) return;
    replay = new Replay(view, data, current().tool, chosen);
    slider.max = chosen.time.length - 1;
    slider.value = 0;
    showStep();
    replay.frame();
  }
  if (time) {
    recordings.addEventListener('change', chooseRecording);
    slider.addEventListener('input', showStep);
    play.addEventListener('click', () => {
      if (playing) return stop();
      play.textContent = 'Pause';
      const speed = () => Number(time.querySelector('.speed').value), times = replay.replay.time;
      if (Number(slider.value) >= times.length - 1) slider.value = 0;
      let before = performance.now(), at = times[slider.value];
      const tick = now => {
        at += (now - before) / 1000 * speed();
        before = now;
        let index = Number(slider.value);
        while (index < times.length - 1 && times[index] < at) ++index;
        slider.value = index;
        showStep();
        if (index < times.length - 1) playing = requestAnimationFrame(tick); else stop();
      };
      playing = requestAnimationFrame(tick);
    });
  }

  function showScene() {
    const scene = current();
    if (replay) replay.remove();
    replay = null;
    view.setObjects(scene.objects.map(object => ({...object, ...data.models[object.model]})));
    if (scene.look) {
      view.direction.set(...scene.look.from).normalize();
      view.target.set(...scene.look.at_mm);
      view.distance = scene.look.distance_mm;
    }
    view.onShown();
    controls.refresh();
    spots();
    if (!time) return;
    recordings.textContent = '';
    scene.replays.forEach((entry, i) => recordings.add(new Option(entry.name, i)));
    chooseRecording();
  }
  scenes.addEventListener('change', showScene);
  document.querySelectorAll('[data-scene]').forEach(button => button.addEventListener('click', () => {
    scenes.value = button.dataset.scene;
    showScene();
    place.scrollIntoView();
  }));
  document.querySelectorAll('[data-eye]').forEach(button => button.addEventListener('click', () => {
    view.setShown(Number(button.dataset.eye), !view.objects[button.dataset.eye].shown);
  }));
  document.querySelectorAll('[data-object]').forEach(button => button.addEventListener('click', () => {
    const index = Number(button.dataset.object);
    view.setShown(index, true);
    view.setLevel(view.levelCount() - 1);  // the figures in the table are those of the leaves
    controls.refresh();
    spots();
    const object = current().objects[index], last = object.levels && object.levels[object.levels.length - 1];
    if (last && last.worst_overhang_at_mm) view.jump(index, last.worst_overhang_at_mm, last.overhang_mm.max, `${object.name}: out by ${last.overhang_mm.max.toPrecision(3)} mm`);
    else {
      const box = view.objects[index].box();
      box.getCenter(view.target);
      view.says.textContent = object.name;
      view.distance = 2.2 * box.getSize(new THREE.Vector3()).length();
      view.draw();
    }
    place.scrollIntoView();
  }));
  showScene();
  window.sphereView = view;
});

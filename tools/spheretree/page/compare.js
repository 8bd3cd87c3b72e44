// SPDX-License-Identifier: GPL-3.0-or-later
// The 3D section of a comparison: one mesh, one of its trees.
// data: {meshes: [{name, mesh, trees: [{label, tree, levels}]}]}
'use strict';

spheretreePage.whenReady(data => {
  const place = document.querySelector('.view');
  if (!place) return;
  const view = new SphereView(place);
  view.level = 99;  // leaves first
  const choose = document.createElement('div');
  choose.className = 'panel';
  choose.innerHTML = `<label>Mesh <select class="mesh"></select></label><label>Tree <select class="tree"></select></label>`;
  view.panel.append(choose);
  const controls = addViewControls(view, () => spots());
  const places = document.createElement('div');
  places.className = 'spots';
  view.panel.append(places);
  const meshes = choose.querySelector('.mesh'), trees = choose.querySelector('.tree');
  data.meshes.forEach((mesh, i) => meshes.add(new Option(mesh.name, i)));

  const current = () => data.meshes[meshes.value].trees[trees.value];
  function spots() {
    places.textContent = '';
    const figures = current() && current().levels[view.level];
    if (!figures) return;
    const add = (name, value, at) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = `${name}: ${value.toPrecision(3)} mm`;
      button.disabled = !at;
      button.addEventListener('click', () => view.jump(0, at, value, button.textContent));
      places.append(button);
    };
    add('Worst overhang', figures.overhang_mm.max, figures.worst_overhang_at_mm);
    if (figures.worst_gap_at_mm) add('Largest gap', figures.max_gap_mm, figures.worst_gap_at_mm);
  }
  function show(keepView) {
    const mesh = data.meshes[meshes.value], tree = current();
    const seen = [view.target.clone(), view.distance];
    view.setObjects([{name: mesh.name, mesh: mesh.mesh, tree: tree && tree.tree, levels: tree && tree.levels}]);
    if (keepView) [view.target, view.distance] = seen;
    controls.refresh();
    spots();
  }
  function fillTrees() {
    const before = trees.selectedOptions.length ? trees.selectedOptions[0].text : '';
    trees.textContent = '';
    data.meshes[meshes.value].trees.forEach((tree, i) => trees.add(new Option(tree.label, i)));
    for (const option of trees.options) if (option.text === before) option.selected = true;
  }
  meshes.addEventListener('change', () => { fillTrees(); show(false); });
  trees.addEventListener('change', () => show(true));
  document.querySelectorAll('[data-mesh]').forEach(button => button.addEventListener('click', () => {
    meshes.value = button.dataset.mesh;
    fillTrees();
    show(false);
    place.scrollIntoView();
  }));
  fillTrees();
  show(false);
  window.sphereView = view;
});

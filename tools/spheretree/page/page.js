// SPDX-License-Identifier: GPL-3.0-or-later
// Unpacks the page's data, and makes tables sortable. The other scripts start through `whenReady`.
'use strict';

const spheretreePage = (() => {
  const TYPES = {u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array};

  async function inflated(id) {
    const text = atob(document.getElementById(id).textContent);
    const bytes = Uint8Array.from(text, c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Response(stream).arrayBuffer();
  }

  // References of the form {type, at, count} become typed arrays, wherever they stand.
  function resolved(value, buffer, base) {
    if (value === null || typeof value !== 'object') return value;
    if (TYPES[value.type] && Number.isInteger(value.at)) return new TYPES[value.type](buffer, base + value.at, value.count);
    for (const key of Object.keys(value)) value[key] = resolved(value[key], buffer, base);
    return value;
  }

  async function load() {
    const script = document.createElement('script');
    script.textContent = new TextDecoder().decode(await inflated('three'));
    document.head.append(script);
    const buffer = await inflated('data');
    const length = new DataView(buffer).getUint32(0, true);
    return resolved(JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length))), buffer, 4 + length);
  }

  function sortable(table) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement('button');
      button.type = 'button';
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener('click', () => {
        const down = head.getAttribute('aria-sort') === 'ascending';
        heads.forEach(other => other.removeAttribute('aria-sort'));
        head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
        const key = row => {
          const text = row.cells[column].textContent.trim(), number = parseFloat(text);
          return Number.isNaN(number) ? text : number;
        };
        const order = (a, b) => typeof a === 'number' && typeof b === 'number' ? a - b : String(a).localeCompare(String(b));
        const rows = [...table.tBodies[0].rows].sort((a, b) => order(key(a), key(b)));
        table.tBodies[0].append(...(down ? rows.reverse() : rows));
      });
    });
  }

  document.querySelectorAll('table').forEach(sortable);

  /// Calls `start(data)` once the data are unpacked; where that fails, says so in the page and not only on the console.
  async function whenReady(start) {
    const places = document.querySelectorAll('.view');
    const say = words => places.forEach(place => { place.textContent = words; });
    if (typeof DecompressionStream === 'undefined') return say('The 3D view needs a browser of 2023 or later.');
    try {
      await start(await load());
    } catch (error) {
      say('The 3D view cannot be shown: ' + error.message);
      throw error;
    }
    document.documentElement.dataset.ready = 'yes';
  }

  return {whenReady};
})();

// The page: what is open, what is going on, and what the buttons do.
import { Cancelled, Engine } from './engine.js';
import { chosen, dropped, save } from './files.js';
import { Settings } from './settings.js';

const $ = (id) => document.getElementById(id);
const engine = new Engine(progress);
let settings;
let view;
/// Files of the user by their paths.
let inputs = new Map();
/// Path of the mesh among them.
let mesh;
/// Result of the last bake, and the settings that it was made with.
let baked;
/// Number of the work that is going on; older work finds that it is not its turn any more.
let turn = 0;

/// Names of files that a mesh names.
const BESIDE = /\.(mtl|bin|png|jpe?g|tga|bmp|tiff?|exr|hdr|webp|gif)$/i;

start().catch(fail);

async function start() {
  connect();
  const [methods, first] = [JSON.parse(await engine.call('methods')), await engine.call('default_method')];
  // The method that needs no settings comes first.
  methods.sort((a, b) => (b.name === first) - (a.name === first));
  settings = new Settings(methods, first, () => ($('bake').disabled = !mesh));
  $('version').textContent = await engine.call('version');
  document.documentElement.dataset.ready = 'yes';
}

function connect() {
  for (const id of ['choose', 'choose-welcome']) $(id).onclick = () => $('files').click();
  $('choose-folder').onclick = () => $('folder').click();
  for (const input of [$('files'), $('folder')]) {
    input.onchange = () => open(chosen(input.files)).finally(() => (input.value = ''));
  }
  for (const button of document.querySelectorAll('.sample')) button.onclick = () => sample(button.dataset.sample);
  addEventListener('dragover', (event) => {
    event.preventDefault();
    $('drop-hint').hidden = false;
  });
  addEventListener('dragleave', (event) => event.relatedTarget || ($('drop-hint').hidden = true));
  addEventListener('drop', async (event) => {
    event.preventDefault();
    $('drop-hint').hidden = true;
    open(await dropped(event.dataTransfer));
  });
  $('cancel').onclick = () => {
    turn++;
    engine.cancel();
    idle('Cancelled.');
  };
  $('method').onsubmit = (event) => {
    event.preventDefault();
    bake();
  };
  $('lambda').oninput = look;
  for (const id of ['split', 'split-at', 'heights', 'texture']) $(id).oninput = look;
  $('z-up').oninput = () => view.up($('z-up').checked ? 'z' : 'y');
  $('divider').onpointerdown = (event) => $('divider').setPointerCapture(event.pointerId);
  $('divider').onpointermove = (event) => {
    if (!$('divider').hasPointerCapture(event.pointerId)) return;
    const box = $('stage').getBoundingClientRect();
    $('split-at').value = (event.clientX - box.left) / box.width;
    look();
  };
  $('save-zip').onclick = saveBundle;
  $('save-mesh').onclick = saveMesh;
  $('save-glb').onclick = () => save(glb(), baked.bytes.get(glb()));
}

async function sample(name) {
  const files = [`${name}_noisy.obj`, `${name}.mtl`].map(async (path) => {
    const response = await fetch(new URL(`./samples/${path}`, import.meta.url));
    if (!response.ok) throw new Error(`${path}: this sample is not there (${response.status})`);
    return { path, file: await response.blob() };
  });
  Promise.all(files).then(open, fail);
}

/// Opens files: a mesh with all that it names, or what an open mesh still lacks.
async function open(files) {
  if (files.length === 0) return;
  const mine = ++turn;
  // Whatever goes on is for the mesh that was; a new worker has all its memory.
  engine.cancel();
  const isMesh = await Promise.all(files.map(({ path }) => engine.call('is_mesh', path).catch(() => false)));
  const meshes = files.map(({ path }) => path).filter((_, k) => isMesh[k]);
  if (mine !== turn) return;
  if (meshes.length === 0 && !(mesh && files.every(({ path }) => BESIDE.test(path)))) {
    // Its content may be a mesh all the same; if not, the library says so.
    meshes.push(files[0].path);
  }
  if (meshes.length > 0) {
    inputs = new Map();
    mesh = meshes.sort((a, b) => a.split('/').length - b.split('/').length)[0];
    close();
  }
  for (const { path, file } of files) inputs.set(path, file);
  const others = meshes.length > 1 ? ` (of ${meshes.length} meshes; drop another one alone)` : '';
  await work(mine, async (isMine) => {
    await feed();
    const { vertices, faces } = JSON.parse(await engine.call('open', mesh));
    if (!isMine()) return;
    $('status').textContent = `${mesh}: ${vertices.toLocaleString('en')} vertices, ${faces.toLocaleString('en')} faces${others}`;
    document.title = `${mesh} · planish`;
    await show();
    if (meshes.length > 0) await view.preview(await engine.call('preview', mesh));
    await bakeNow(isMine);
  });
}

/// Shows that there is no result.
function close() {
  baked = undefined;
  if (view) {
    Object.assign(view, { entry: undefined, isKept: false });
    view.clear();
    view.draw();
  }
  for (const id of ['view', 'downloads']) $(id).disabled = true;
  for (const id of ['result', 'divider', 'left-label', 'right-label', 'legend']) $(id).hidden = true;
}

/// Puts the files of the user into the memory of the worker.
async function feed() {
  const { worker } = engine;
  await engine.call('clear');
  for (const [path, file] of inputs) {
    const bytes = new Uint8Array(await file.arrayBuffer());
    if (worker !== engine.worker) throw new Cancelled();
    await engine.call('put', path, bytes);
  }
  engine.isFed = worker;
}

async function show() {
  $('welcome').hidden = true;
  $('canvas').hidden = false;
  for (const button of document.querySelectorAll('header .sample')) button.hidden = false;
  if (view) return;
  const { View } = await import('./view.js');
  view = new View($('canvas'));
  // For tests and for curious people.
  window.planish = { view };
}

function bake() {
  const mine = ++turn;
  engine.waiting.size > 0 && engine.cancel();
  return work(mine, async (isMine) => {
    if (engine.isFed !== engine.worker) await feed();
    await bakeNow(isMine);
  });
}

async function bakeNow(isMine) {
  const [request, options] = [settings.request(), settings.options()];
  // The library takes the files of the last bake out of its memory first.
  if (baked) baked.home = undefined;
  const result = JSON.parse(await engine.call('bake', mesh, request));
  const manifest = `${result.folder}/${result.files.at(-1)}`;
  const entry = result.manifest.displacement;
  const texels = entry.bits === 16 && (await engine.call('texels', manifest));
  const bytes = new Map();
  for (const name of result.files) bytes.set(name, await engine.call('read', `${result.folder}/${name}`));
  if (!isMine()) return;
  const done = { ...result, path: manifest, bytes, home: engine.worker };
  await view.baked(bytes.get(result.files.find((name) => name.endsWith('.glb'))), entry, texels);
  baked = done;
  $('view').disabled = false;
  $('texture').disabled = !view.hasColours;
  tell(options);
  look();
}

/// Report, warnings and command of the bake.
function tell(options) {
  $('result').hidden = false;
  // A line has its head in the first nine columns.
  const cell = (tag, text) => Object.assign(document.createElement(tag), { textContent: text.trim() });
  const lines = baked.report.trimEnd().split('\n');
  $('report').replaceChildren(...lines.flatMap((line) => [cell('dt', line.slice(0, 9)), cell('dd', line.slice(9))]));
  $('warnings').replaceChildren(
    ...baked.warnings.map((warning) => Object.assign(document.createElement('li'), { textContent: warning })),
  );
  $('command').textContent = `planish bake ${quoted(mesh)}${options}`;
}

function quoted(name) {
  return /^[\w./-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`;
}

/// Takes what the widgets of the view say.
function look() {
  $('lambda-value').value = Number($('lambda').value).toFixed(2);
  if (baked) $('save-mesh').textContent = `Mesh with λ = ${$('lambda-value').value} (${format()})`;
  if (!view) return;
  const [isSplit, hasHeights, hasTexture] = ['split', 'heights', 'texture'].map((id) => $(id).checked);
  const isDressed = view.hasHeights === hasHeights && view.hasTexture === hasTexture && view.isDressed === baked;
  Object.assign(view, { lambda: Number($('lambda').value), split: Number($('split-at').value), isSplit, hasHeights, hasTexture });
  const range = isDressed ? view.shownRange : view.dress();
  Object.assign(view, { shownRange: range, isDressed: baked });
  for (const id of ['divider', 'left-label', 'right-label']) $(id).hidden = !isSplit || !baked;
  $('divider').style.left = `${100 * view.split}%`;
  $('legend').hidden = !range;
  const [low, , high] = $('legend').querySelectorAll('span');
  [low.textContent, high.textContent] = [`−${range.toPrecision(3)}`, range.toPrecision(3)];
  view.draw();
}

/// Does work with a bar and a button that cancels it. `isMine` turns false when other work has begun.
async function work(mine, steps) {
  const isMine = () => mine === turn;
  $('error').hidden = true;
  $('work').hidden = false;
  $('bake').disabled = true;
  $('downloads').disabled = true;
  progress('reading', 0);
  try {
    await steps(isMine);
    if (isMine()) idle();
  } catch (error) {
    if (isMine()) fail(error);
  }
}

function idle(text) {
  $('work').hidden = true;
  $('downloads').disabled = !baked;
  // Settings can be changed and tried again.
  $('bake').disabled = !mesh || (baked && text === undefined);
  if (text) $('status').textContent = text;
}

function fail(error) {
  idle('');
  if (error instanceof Cancelled) return;
  $('error').textContent = error.message;
  $('error').hidden = false;
  $('status').textContent = '';
}

function progress(stage, fraction) {
  $('work-stage').textContent = stage;
  $('progress').value = fraction;
}

const glb = () => baked.files.find((name) => name.endsWith('.glb'));

/// Extension of the mesh, without that of compression.
const format = () => `.${mesh.replace(/\.(gz|xz)$/i, '').split('.').pop().toLowerCase()}`;

async function saveMesh() {
  const name = mesh.replace(/\.xz$/i, '').replace(/^(.*?)((\.\w+)?(\.gz)?)$/i, '$1-denoised$2');
  try {
    if (engine.isFed !== engine.worker) await feed();
    // After another bake that was cancelled or has failed.
    if (baked.home !== engine.worker) {
      for (const [file, content] of baked.bytes) await engine.call('put', `${baked.folder}/${file}`, content.slice());
      baked.home = engine.worker;
    }
    save(name.split('/').pop(), await engine.call('apply', baked.path, name, Number($('lambda').value)));
  } catch (error) {
    fail(error);
  }
}

async function saveBundle() {
  const { zipSync } = await import('three/addons/libs/fflate.module.js');
  const folder = baked.folder.split('/').pop();
  // Equal files make an equal archive: it names no time.
  const files = {};
  for (const [name, bytes] of baked.bytes) files[`${folder}/${name}`] = bytes;
  save(`${folder}.zip`, zipSync(files, { level: 6, mtime: new Date(1980, 0, 1) }));
}

if ('serviceWorker' in navigator) navigator.serviceWorker.register(new URL('./sw.js', import.meta.url)).catch(() => {});

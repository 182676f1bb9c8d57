// Puts the page together in a folder, where `web/build` has put the library: sources, three.js, the snippets of the documentation
// and the samples. Says how large the page is.
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, readFileSync, readdirSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { gzipSync } from 'node:zlib';
import { transformSync } from 'esbuild';

const DIST = process.argv[2];
const SAMPLES = ['duck_noisy.obj', 'duck.mtl', 'flange_noisy.obj', 'flange.mtl'];
const SNIPPETS = ['threejs-gltf'];
const THREE = {
  'three.module.js': 'build/three.module.js',
  'three.core.js': 'build/three.core.js',
  'addons/controls/OrbitControls.js': 'examples/jsm/controls/OrbitControls.js',
  'addons/libs/fflate.module.js': 'examples/jsm/libs/fflate.module.js',
  'addons/loaders/EXRLoader.js': 'examples/jsm/loaders/EXRLoader.js',
  'addons/loaders/GLTFLoader.js': 'examples/jsm/loaders/GLTFLoader.js',
  'addons/utils/BufferGeometryUtils.js': 'examples/jsm/utils/BufferGeometryUtils.js',
  'addons/utils/SkeletonUtils.js': 'examples/jsm/utils/SkeletonUtils.js',
  LICENSE: 'LICENSE',
};
const IMPORTS = JSON.stringify({ imports: { three: './three/three.module.js', 'three/addons/': './three/addons/' } });

const sha256 = (data, encoding) => createHash('sha256').update(data).digest(encoding);
const put = (name, content) => {
  mkdirSync(path.dirname(path.join(DIST, name)), { recursive: true });
  writeFileSync(path.join(DIST, name), content);
};

const page = readFileSync('src/index.html', 'utf8');
const hash = `sha256-${sha256(IMPORTS, 'base64')}`;
for (const name of readdirSync('src')) cpSync(path.join('src', name), path.join(DIST, name));
put('index.html', page.replace('IMPORT_MAP_HASH', hash).replace('IMPORT_MAP', IMPORTS));
for (const [to, from] of Object.entries(THREE)) {
  const source = readFileSync(path.join('node_modules/three', from), 'utf8');
  put(`three/${to}`, to.endsWith('.js') ? transformSync(source, { minify: true, format: 'esm' }).code : source);
}
const clients = readFileSync('../docs/clients.md', 'utf8');
for (const name of SNIPPETS) {
  const [, code] = clients.match(new RegExp(`<!-- snippet: ${name} -->\n\`\`\`\\w+\n(.*?)^\`\`\`$`, 'ms'));
  put(`snippets/${name}.js`, code);
}
for (const name of SAMPLES) put(`samples/${name}`, readFileSync(`../data/${name}`));

const files = readdirSync(DIST, { recursive: true }).filter((name) => statSync(path.join(DIST, name)).isFile() && name !== 'sw.js');
files.sort();
const version = sha256(files.map((name) => `${name} ${sha256(readFileSync(path.join(DIST, name)), 'hex')}`).join('\n'), 'hex');
const worker = readFileSync('src/sw.js', 'utf8');
put('sw.js', worker.replace('PAGE_VERSION', version.slice(0, 16)).replace('PAGE_FILES', JSON.stringify(['./', ...files])));

const packed = (names) => names.reduce((sum, name) => sum + gzipSync(readFileSync(path.join(DIST, name)), { level: 9 }).length, 0);
const kilo = (bytes) => `${Math.round(bytes / 1000)} kB`;
const samples = files.filter((name) => name.startsWith('samples/'));
const first = ['index.html', 'style.css', 'main.js', 'engine.js', 'files.js', 'settings.js', 'icon.svg'];
console.log(`${files.length + 1} files; with gzip ${kilo(packed(first))} until something is seen, ` +
  `${kilo(packed(['planish_web_bg.wasm']))} the library, ${kilo(packed(files) - packed(samples))} in all without the samples, ${kilo(packed(samples))} the samples`);

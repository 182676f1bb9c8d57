// Runs a snippet of docs/clients.md in three.js and reads back where three's own vertex shader puts the vertices.
import * as THREE from 'three';
import { base64 } from './numbers.js';

const ROW = 1024;

/// What `snippet` exports under the name `call`, called with `parameters`, is an object to draw.
///
/// Gives for each mesh in it, as base64: the positions of its vertices in the file and as displaced on the GPU; and the numbers of
/// those that its faces use.
export async function run({ snippet, call, parameters, settings }) {
  const object = await (await import(snippet))[call](...parameters);
  const meshes = [];
  object.traverse((child) => child.isMesh && meshes.push(child));
  await Promise.all(meshes.flatMap(materials).map(loaded));
  const renderer = new THREE.WebGLRenderer({ canvas: document.querySelector('canvas'), antialias: true });
  const results = meshes.map((mesh) => ({
    rest: base64(mesh.geometry.attributes.position.array),
    displaced: base64(displaced(renderer, mesh)),
    materials: materials(mesh).map(settingsOf),
    used: [...new Set(mesh.geometry.index?.array)],
  }));
  draw(renderer, object, meshes, settings);
  return results;
}

function materials(mesh) {
  return [mesh.material].flat();
}

function settingsOf({ displacementScale, displacementBias }) {
  return { displacementScale, displacementBias };
}

/// MTLLoader gives materials back before their textures are there.
async function loaded(material) {
  for (const map of [material.displacementMap, material.normalMap]) {
    while (map && !arrived(map.image)) await new Promise((resolve) => setTimeout(resolve, 10));
  }
}

function arrived(image) {
  // A picture, a bitmap, or an array of numbers.
  return image && (image instanceof HTMLImageElement ? image.complete : !('data' in image) || image.data);
}

/// Draws each vertex as a point whose colour is its displaced position, with three's shader of the mesh's material.
export function displaced(renderer, mesh) {
  const count = mesh.geometry.attributes.position.count;
  const rows = Math.ceil(count / ROW);
  const observed = materials(mesh).map((material) => observer(material, rows));
  const geometry = mesh.geometry.clone().setIndex(null);
  if (mesh.geometry.index) geometry.clearGroups();
  const points = new THREE.Points(geometry, observed.length > 1 ? observed : observed[0]);
  points.morphTargetInfluences = mesh.morphTargetInfluences;
  points.frustumCulled = false;

  const target = new THREE.WebGLRenderTarget(ROW, rows, { type: THREE.FloatType, depthBuffer: false });
  renderer.setRenderTarget(target);
  renderer.setClearColor(0, 0);
  renderer.clear();
  renderer.render(points, new THREE.PerspectiveCamera());
  const pixels = new Float32Array(ROW * rows * 4);
  renderer.readRenderTargetPixels(target, 0, 0, ROW, rows, pixels);
  renderer.setRenderTarget(null);
  const places = new Float32Array(count * 3);
  for (let i = 0; i < count; i++) {
    if (pixels[4 * i + 3] !== 1) throw new Error(`vertex ${i} was not drawn`);
    places.set(pixels.subarray(4 * i, 4 * i + 3), 3 * i);
  }
  return places;
}

function observer(material, rows) {
  const clone = material.clone();
  clone.blending = THREE.NoBlending;
  clone.depthTest = false;
  clone.onBeforeCompile = (shader) => {
    const end = shader.vertexShader.lastIndexOf('}');
    shader.vertexShader = `varying vec3 vPlace;
      ${shader.vertexShader.slice(0, end)}
      vPlace = transformed;
      vec2 cell = vec2(gl_VertexID % ${ROW}, gl_VertexID / ${ROW}) + 0.5;
      gl_Position = vec4(cell / vec2(${ROW}, ${rows}) * 2.0 - 1.0, 0.0, 1.0);
      gl_PointSize = 1.0;
    }`;
    shader.fragmentShader = 'varying vec3 vPlace; void main() { gl_FragColor = vec4(vPlace, 1.0); }';
  };
  clone.customProgramCacheKey = () => `observer ${rows}`;
  return clone;
}

/// Three views for people: as scanned, displaced, displaced with the normal map. The first two show every face flat.
function draw(renderer, object, meshes, { scale, bias }) {
  const scene = new THREE.Scene().add(object, new THREE.AmbientLight(0xffffff, 0.8));
  scene.background = new THREE.Color(0xd8dde4);
  const sphere = new THREE.Box3().setFromObject(object).getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(35, 1, sphere.radius / 10, sphere.radius * 10);
  const towards = new THREE.Vector3(-0.6, 0.4, -1).normalize();
  camera.position.copy(sphere.center).addScaledVector(towards, sphere.radius * 3.4);
  camera.lookAt(sphere.center);
  const sun = new THREE.DirectionalLight(0xffffff, 2.5);
  sun.position.copy(camera.position).add(new THREE.Vector3(sphere.radius, sphere.radius, 0));
  scene.add(sun);

  renderer.setScissorTest(true);
  const normalMaps = new Map(meshes.flatMap(materials).map((material) => [material, material.normalMap]));
  for (const [view, share, flat] of [[0, 0, true], [1, 1, true], [2, 1, false]]) {
    for (const [material, normalMap] of normalMaps) {
      material.displacementScale = scale * share;
      material.displacementBias = bias * share;
      material.flatShading = flat;
      material.normalMap = flat ? null : normalMap;
      material.needsUpdate = true;
    }
    const influences = meshes.map((mesh) => mesh.morphTargetInfluences?.slice());
    for (const mesh of meshes) mesh.morphTargetInfluences?.forEach((w, i, all) => (all[i] = w * share));
    renderer.setViewport(400 * view, 0, 400, 400);
    renderer.setScissor(400 * view, 0, 400, 400);
    renderer.render(scene, camera);
    meshes.forEach((mesh, k) => influences[k] && (mesh.morphTargetInfluences = influences[k]));
  }
}

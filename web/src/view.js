// The view: the baked .glb and its map, drawn by three.js through the snippets of docs/clients.md.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { loadDisplaced } from './snippets/threejs-gltf.js';

// Blue inside, grey, red outside: as in the window of planish.
const COLOURS = [[59, 76, 192], [141, 176, 254], [221, 221, 221], [244, 154, 123], [180, 4, 38]].map((rgb) =>
  new THREE.Color().setRGB(...rgb.map((byte) => byte / 255), THREE.SRGBColorSpace));
const DARK = matchMedia('(prefers-color-scheme: dark)');

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setScissorTest(true);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x777788, 1.1), this.camera);
    // A light that goes with the camera grazes what is seen, so noise shows.
    const light = new THREE.DirectionalLight(0xffffff, 2.4);
    light.position.set(1, 1, 0.6);
    this.camera.add(light, light.target);
    light.target.position.set(0, 0, -1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.draw());
    canvas.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(canvas);
    DARK.addEventListener('change', () => this.draw());
    this.meshes = [];
    Object.assign(this, { lambda: 1, split: 0.5, isSplit: true, hasHeights: false, hasTexture: true });
  }

  /// Shows a mesh as it was read, grey, until there is a map.
  async preview(bytes) {
    const { scene } = await new GLTFLoader().parseAsync(bytes.buffer, '');
    this.show(scene, true);
    // Whoever turns it meanwhile sees the result from there.
    this.isKept = true;
  }

  /// Shows the .glb of a bake. `texels` gives the texels of the map where the browser would cut the image to 8 bits.
  async baked(bytes, entry, texels) {
    const url = URL.createObjectURL(new Blob([bytes], { type: 'model/gltf-binary' }));
    try {
      const object = await loadDisplaced(url, this.lambda);
      this.show(object, !this.isKept);
      this.isKept = true;
    } finally {
      URL.revokeObjectURL(url);
    }
    this.entry = entry;
    if (texels) this.useTexels(texels);
    this.draw();
  }

  /// Replaces the image of the map by numbers.
  useTexels(texels) {
    const { width, height } = this.entry;
    const exact = new THREE.DataTexture(texels, width, height, THREE.RedFormat, THREE.FloatType);
    // Few devices have no filter for floats; they keep the image.
    if (!this.renderer.extensions.has('OES_texture_float_linear')) return;
    for (const { material } of this.meshes) {
      const { channel, minFilter, magFilter, wrapS, wrapT } = material.displacementMap;
      const filter = (given) => (given === THREE.NearestFilter ? given : THREE.LinearFilter);
      Object.assign(exact, { channel, wrapS, wrapT, minFilter: filter(minFilter), magFilter: filter(magFilter), needsUpdate: true });
      material.displacementMap = exact;
    }
  }

  show(object, moves) {
    this.clear();
    this.object = object;
    object.traverse((child) => child.isMesh && this.meshes.push(child));
    for (const mesh of this.meshes) {
      // Displaced vertices leave the box of the mesh, and keep normals of the noisy surface; the shader makes those of the faces.
      mesh.frustumCulled = false;
      mesh.material = mesh.material.clone();
      Object.assign(mesh.material, { flatShading: true, normalMap: null, side: THREE.DoubleSide });
      mesh.userData.own = { map: mesh.material.map, color: mesh.material.color.clone(), colours: mesh.geometry.attributes.color };
    }
    this.scene.add(object);
    this.dress();
    if (moves) this.frame();
    this.draw();
  }

  clear() {
    if (this.object) {
      this.scene.remove(this.object);
      for (const { geometry, material } of this.meshes) {
        geometry.dispose();
        material.displacementMap?.dispose();
        material.dispose();
      }
    }
    this.meshes = [];
    this.object = undefined;
  }

  /// True if a material has a texture, or the vertices have colours.
  get hasColours() {
    return this.meshes.some(({ userData: { own } }) => own.map || own.colours);
  }

  /// Colours of the mesh: heights, its own texture, or grey.
  dress() {
    const isBaked = this.meshes.some((mesh) => mesh.morphTargetInfluences);
    const range = this.hasHeights && isBaked ? this.range() : 0;
    for (const { geometry, material, userData: { own } } of this.meshes) {
      const colours = range ? coloured(geometry, range) : this.hasTexture ? own.colours : undefined;
      if (colours) geometry.setAttribute('color', colours);
      material.vertexColors = Boolean(colours);
      material.map = this.hasTexture && !range ? own.map : null;
      material.color.copy(range || !this.hasTexture ? new THREE.Color(range ? 0xffffff : 0xb9bdc4) : own.color);
      material.needsUpdate = true;
    }
    return range;
  }

  /// Largest height of either sign, model units.
  range() {
    const { bias, scale } = this.entry;
    return Math.max(Math.abs(bias), Math.abs(bias + scale));
  }

  /// Puts the camera where it sees the whole mesh.
  frame() {
    const sphere = new THREE.Box3().setFromObject(this.object).getBoundingSphere(new THREE.Sphere());
    const radius = sphere.radius || 1;
    const towards = this.camera.up.z ? new THREE.Vector3(0.7, -1, 0.5) : new THREE.Vector3(0.6, 0.35, 1);
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(towards.normalize(), radius * 3.6);
    Object.assign(this.camera, { near: radius / 50, far: radius * 100 });
    this.controls.update();
  }

  /// Says which axis points up.
  up(axis) {
    this.camera.up.set(0, axis === 'y' ? 1 : 0, axis === 'z' ? 1 : 0);
    // The controls take the axis when they are made.
    this.controls.dispose();
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.draw());
    if (this.object) this.frame();
    this.draw();
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const nearer = { '+': 0.9, '=': 0.9, '-': 1 / 0.9 };
    const [around, over] = turns[event.key] ?? [0, 0];
    const factor = nearer[event.key] ?? 1;
    if ((!around && !over && factor === 1) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const y = new THREE.Vector3(0, 1, 0);
    const turn = new THREE.Quaternion().setFromUnitVectors(this.camera.up, y);
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(turn);
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta += 0.12 * around;
    place.phi += 0.12 * over;
    place.radius *= factor;
    place.makeSafe();
    this.camera.position.setFromSpherical(place).applyQuaternion(turn.invert()).add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  /// Asks for a picture; any number of changes make one.
  draw() {
    this.frameAsked ??= requestAnimationFrame(() => {
      this.frameAsked = undefined;
      this.drawNow();
    });
  }

  drawNow() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.scene.background = new THREE.Color(DARK.matches ? 0x262d37 : 0xdfe3e9);
    const at = this.isSplit && this.entry ? Math.round(width * this.split) : 0;
    this.renderer.setViewport(0, 0, width, height);
    if (at > 0) this.half(0, at, height, 0);
    if (at < width) this.half(at, width - at, height, this.lambda);
  }

  half(left, width, height, lambda) {
    for (const { material } of this.meshes) {
      if (!material.displacementMap) continue;
      material.displacementScale = -lambda * this.entry.scale;
      material.displacementBias = -lambda * this.entry.bias;
    }
    this.renderer.setScissor(left, 0, width, height);
    this.renderer.render(this.scene, this.camera);
  }
}

/// Colours of the vertices by their heights: the morph target is −h along the normal.
function coloured({ attributes: { position, normal }, morphAttributes }, range) {
  const offsets = morphAttributes.position[0];
  const colours = new Float32Array(3 * position.count);
  const colour = new THREE.Color();
  for (let i = 0; i < position.count; i++) {
    const height = -(offsets.getX(i) * normal.getX(i) + offsets.getY(i) * normal.getY(i) + offsets.getZ(i) * normal.getZ(i));
    const at = (Math.min(Math.max(height / range, -1), 1) + 1) * 0.5 * (COLOURS.length - 1);
    const k = Math.min(Math.floor(at), COLOURS.length - 2);
    colour.lerpColors(COLOURS[k], COLOURS[k + 1], at - k).toArray(colours, 3 * i);
  }
  return new THREE.BufferAttribute(colours, 3);
}

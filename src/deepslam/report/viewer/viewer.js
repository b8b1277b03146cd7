// The 3D view of a report page: one labelled scene, objects to pick, layers to switch.
//
// Bundled into the program at build time. The page gives two inert script elements: `scene-glb` (the exported GLB as
// base64) and `scene-data` (JSON of report/viewer_data.h). Nothing is fetched. `window.deepslamViewer` is for tests and
// for people at the console.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {OfflineDracoLoader, toBytes} from './offline_draco.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';
import {coarseGeometry} from './coarse_geometry.js';
import {describeObject, describePart} from './panel.js';

const BACKGROUND = 0xf3f4f6;
const CLICK_TOLERANCE_PX = 6;
const TAP_TOLERANCE_PX = 14;  // fingers are not as steady
const SEE_THROUGH = 0.35;
const IN_THE_WAY = 0.1;  // opacity of walls between the viewer and their room
// Halls of more faces than this show objects smaller than so many pixels by coarse meshes.
const MANY_FACES = 500000;
const COARSE_PX = 90;

// World axes of the report (z up) to those of the GLB (y up): (x, y, z) -> (y, z, x).
const toGltf = ([x, y, z]) => new THREE.Vector3(y, z, x);

const root = document.getElementById('viewer');
const data = JSON.parse(document.getElementById('scene-data').textContent);
const byName = new Map(data.objects.map((object, index) => [object.name, {...object, index}]));

function say(text) {
  const note = root.querySelector('.viewer-note');
  note.textContent = text;
  note.hidden = !text;
}

// Points of an object: 16-bit millimetres above `origin_m`, little endian.
function decodePoints(points) {
  const bytes = toBytes(points.data);
  const view = new DataView(bytes.buffer);
  const positions = new Float32Array(bytes.length / 2);
  for (let i = 0; i < bytes.length / 6; ++i) {
    const world = [0, 1, 2].map((c) => points.origin_m[c] + view.getUint16(6 * i + 2 * c, true) / 1000);
    toGltf(world).toArray(positions, 3 * i);
  }
  return positions;
}

function line(points_m, colour, dashed) {
  const geometry = new THREE.BufferGeometry().setFromPoints(points_m.map(toGltf));
  const material = dashed ? new THREE.LineDashedMaterial({color: colour, dashSize: 0.04, gapSize: 0.03})
                          : new THREE.LineBasicMaterial({color: colour});
  const made = new THREE.Line(geometry, material);
  if (dashed) made.computeLineDistances();
  return made;
}

class Viewer {
  constructor(gltf) {
    this.canvasBox = root.querySelector('.viewer-canvas');
    this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.canvasBox.prepend(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKGROUND);
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.02, 200);
    this.objects = new Map();
    this.parts = new Map();  // of the room itself
    this.layers = {};
    this.selected = null;
    this.addLights();
    this.adopt(gltf.scene);
    this.prepareDetail();
    this.addMeasured();
    this.addPaths();
    this.addLabels();
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.maxPolarAngle = Math.PI * 0.53;  // not far below the floor
    this.controls.addEventListener('change', () => this.draw());
    this.home();
    this.listen();
    this.resize();
  }

  addLights() {
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(2, 5, 3);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xa49c90, 1.7), sun);
  }

  // Sorts the nodes of the GLB into objects and layers.
  adopt(scene) {
    scene.updateMatrixWorld(true);
    this.scene.add(scene);
    for (const node of [...scene.children]) {
      const name = node.userData.name || node.name;
      if (node.userData.layout) this.adoptPart(name, node);
      else if (byName.has(name)) this.adoptObject(node, byName.get(name));
      if (name === 'room' || name === 'ground') {
        this.layers[name] = node;
        node.traverse((part) => {
          // Measured colours hold the room's light already.
          if (!part.isMesh || !part.material.vertexColors) return;
          part.material = new THREE.MeshBasicMaterial({vertexColors: true, side: part.material.side});
        });
      }
      if (name === 'trajectory') node.visible = false;  // drawn from the page's data, with the tracked one
      if (name === 'keyframes') node.visible = false;
    }
  }

  adoptPart(name, node) {
    const meshes = [];
    node.traverse((part) => {
      if (!part.isMesh) return;
      part.userData.part = name;
      // Measured colours hold the room's light already.
      const material = part.material.vertexColors ? new THREE.MeshBasicMaterial({vertexColors: true})
                                                  : part.material.clone();
      part.material = material;
      meshes.push({part, opacity: part.material.opacity < 1 ? part.material.opacity : 1});
    });
    const wall = data.layout.walls[node.userData.layout === 'wall' ? node.userData.id : node.userData.wall];
    this.parts.set(name, {node, meshes, extras: node.userData, wall, box: new THREE.Box3().setFromObject(node)});
  }

  // Whether the viewer looks at it from behind: at a wall from outside its room, down at a ceiling.
  isInTheWay({extras, wall, box}) {
    const eye = this.camera.position;  // glTF's axes: world x is z, world y is x, world z is y
    if (extras.layout === 'ceiling') return eye.y > box.min.y;
    if (!wall) return false;
    const along = [wall.to_m[0] - wall.from_m[0], wall.to_m[1] - wall.from_m[1]];
    return along[0] * (eye.x - wall.from_m[1]) - along[1] * (eye.z - wall.from_m[0]) < 0;
  }

  fadeParts() {
    for (const [name, entry] of this.parts) {
      entry.faded = this.isInTheWay(entry);
      for (const {part, opacity} of entry.meshes) {
        part.material.opacity = entry.faded ? Math.min(IN_THE_WAY, opacity) : opacity;
        part.material.transparent = part.material.opacity < 1;
        part.material.depthWrite = part.material.opacity === 1;
        part.material.needsUpdate = true;
        if (part.material.emissive) part.material.emissive.setHex(name === this.selected ? 0x553300 : 0);
        else part.material.color.setHex(name === this.selected ? 0xffc890 : 0xffffff);
      }
    }
  }

  adoptObject(node, object) {
    const colour = new THREE.Color(`rgb(${object.colour.join(',')})`);
    const meshes = [];
    node.traverse((part) => {
      if (!part.isMesh) return;
      part.userData.object = object.name;
      const appearance = part.material.clone();
      const plain = new THREE.MeshStandardMaterial({color: colour, roughness: 0.85});
      meshes.push({part, appearance, plain});
    });
    const box = new THREE.Box3().setFromObject(node);
    this.objects.set(object.name, {node, object, meshes, box});
  }

  // Coarse copies of the meshes, where there are more faces than a screen has use for. Shared meshes share them.
  prepareDetail() {
    const parts = [...this.objects.values()].flatMap((entry) => entry.meshes.map((mesh) => mesh.part));
    const faces = parts.reduce((sum, part) => sum + (part.geometry.index ? part.geometry.index.count / 3 : 0), 0);
    this.hasDetail = faces > MANY_FACES;
    if (!this.hasDetail) return;
    const coarse = new Map();
    for (const part of parts) {
      if (!coarse.has(part.geometry)) coarse.set(part.geometry, coarseGeometry(part.geometry));
      part.userData.detail = {fine: part.geometry, coarse: coarse.get(part.geometry)};
    }
  }

  chooseDetail() {
    const pixelsPerTangent = this.canvasBox.clientHeight / 2 / Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    for (const {box, meshes} of this.objects.values()) {
      const distance = box.distanceToPoint(this.camera.position);
      const size = box.min.distanceTo(box.max) * pixelsPerTangent;
      for (const {part} of meshes) {
        const {fine, coarse} = part.userData.detail;
        part.geometry = size > COARSE_PX * distance ? fine : coarse;
      }
    }
  }

  addMeasured() {
    this.layers.measured = new THREE.Group();
    for (const object of byName.values()) {
      if (!object.points) continue;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(decodePoints(object.points), 3));
      const material = new THREE.PointsMaterial({color: 0xd0006f, size: 3, sizeAttenuation: false});
      this.layers.measured.add(new THREE.Points(geometry, material));
    }
    this.scene.add(this.layers.measured);
  }

  addPaths() {
    this.layers.trajectory = new THREE.Group();
    if (data.trajectory_m.length > 1) this.layers.trajectory.add(line(data.trajectory_m, 0x1d3557, false));
    if (data.tracked_m.length > 1) this.layers.trajectory.add(line(data.tracked_m, 0x888888, true));
    this.scene.add(this.layers.trajectory);
  }

  addLabels() {
    this.labels = root.querySelector('.viewer-labels');
    for (const entry of this.objects.values()) {
      const label = document.createElement('div');
      label.className = 'viewer-label';
      label.textContent = entry.object.name;
      this.labels.append(label);
      entry.label = label;
    }
    this.rooms = data.layout.rooms.map((room) => {
      const label = document.createElement('div');
      label.className = 'viewer-label room';
      label.textContent = room.name;
      this.labels.append(label);
      return {label, place: toGltf(room.middle_m), labelSize: [label.offsetWidth, label.offsetHeight]};
    });
    for (const entry of this.objects.values()) {
      entry.labelSize = [entry.label.offsetWidth, entry.label.offsetHeight];
    }
  }

  // Whole map in view, seen from the side the camera was on.
  home() {
    const box = new THREE.Box3();
    for (const entry of this.objects.values()) if (!entry.box.isEmpty()) box.union(entry.box);
    for (const entry of this.parts.values()) if (!entry.box.isEmpty()) box.union(entry.box);
    if (box.isEmpty()) box.setFromObject(this.scene);
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, 0, -1), new THREE.Vector3(1, 1, 1));
    const centre = box.getCenter(new THREE.Vector3());
    const radius = Math.max(0.3, box.getSize(new THREE.Vector3()).length() / 2);
    const path = data.trajectory_m.map(toGltf);
    const mean = path.reduce((sum, p) => sum.add(p), new THREE.Vector3()).divideScalar(Math.max(1, path.length));
    const side = mean.sub(centre).setY(0);
    if (side.length() < 0.05) side.set(0, 0, 1);
    const direction = side.normalize().setY(0.75).normalize();
    const aspect = this.canvasBox.clientWidth / Math.max(1, this.canvasBox.clientHeight);
    const distance = radius * 2.6 * Math.max(1, 1 / Math.max(0.3, aspect));  // narrow screens stand back
    this.camera.position.copy(centre).addScaledVector(direction, distance);
    this.controls.target.copy(centre);
    this.controls.update();
  }

  listen() {
    const canvas = this.renderer.domElement;
    let pressed = null;
    canvas.addEventListener('pointerdown', (event) => {
      // A second finger zooms: no tap any more.
      pressed = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : null;
    });
    canvas.addEventListener('pointerup', (event) => {
      if (!pressed) return;
      const moved = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]);
      const tolerance = event.pointerType === 'touch' ? TAP_TOLERANCE_PX : CLICK_TOLERANCE_PX;
      if (moved <= tolerance) this.select(this.hit(event));
      pressed = null;
    });
    this.canvasBox.addEventListener('keydown', (event) => this.key(event));
    for (const box of root.querySelectorAll('input[data-layer]')) {
      box.addEventListener('change', () => this.applyLayers());
    }
    root.querySelector('[data-action=home]').addEventListener('click', () => { this.home(); this.draw(); });
    root.querySelector('.viewer-list').addEventListener('click', (event) => {
      const button = event.target.closest('button');
      if (button) this.select(button.dataset.object);
    });
    new ResizeObserver(() => this.resize()).observe(this.canvasBox);
    this.applyLayers();
  }

  key(event) {
    const turn = {ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.09], ArrowDown: [0, 0.09]}[event.key];
    const zoom = {'+': 0.88, '=': 0.88, '-': 1.14}[event.key];
    const step = {n: 1, p: -1}[event.key];
    if (turn) this.orbit(turn[0], turn[1], 1);
    else if (zoom) this.orbit(0, 0, zoom);
    else if (step) this.selectNext(step);
    else if (event.key === 'Home') { this.home(); this.draw(); }
    else if (event.key === 'Escape') this.select(null);
    else return;
    event.preventDefault();
  }

  orbit(azimuth, polar, distance) {
    const offset = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
    offset.theta += azimuth;
    offset.phi = Math.min(this.controls.maxPolarAngle, Math.max(0.02, offset.phi + polar));
    offset.radius *= distance;
    this.camera.position.setFromSpherical(offset).add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  hit(event) {
    const area = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(2 * (event.clientX - area.left) / area.width - 1,
                                 1 - 2 * (event.clientY - area.top) / area.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const shown = [];
    if (this.on('objects')) shown.push(...this.objects.values());
    if (this.on('layout')) shown.push(...[...this.parts.values()].filter((entry) => !entry.faded));
    const hits = ray.intersectObjects(shown.flatMap((entry) => entry.meshes.map((mesh) => mesh.part)), false);
    if (!hits.length) return null;
    return hits[0].object.userData.object || hits[0].object.userData.part;
  }

  selectNext(step) {
    const names = [...this.objects.keys()];
    if (!names.length) return;
    const at = names.indexOf(this.selected);
    this.select(names[at < 0 ? (step > 0 ? 0 : names.length - 1) : (at + step + names.length) % names.length]);
  }

  select(name) {
    this.selected = this.objects.has(name) || this.parts.has(name) ? name : null;
    for (const button of root.querySelectorAll('.viewer-list button')) {
      button.setAttribute('aria-pressed', String(button.dataset.object === this.selected));
    }
    const panel = root.querySelector('.viewer-panel');
    const object = this.objects.get(this.selected), part = this.parts.get(this.selected);
    panel.replaceChildren(...(object ? describeObject(object.object) : part ? describePart(name, part.extras) : []));
    panel.hidden = !this.selected;
    this.applyLayers();
  }

  on(layer) { return root.querySelector(`input[data-layer=${layer}]`).checked; }

  applyLayers() {
    for (const layer of ['room', 'ground', 'measured', 'trajectory']) {
      if (this.layers[layer]) this.layers[layer].visible = this.on(layer);
    }
    for (const [name, entry] of this.objects) {
      entry.node.visible = this.on('objects');
      for (const {part, appearance, plain} of entry.meshes) {
        part.material = this.on('colours') ? plain : appearance;
        part.material.transparent = this.on('seethrough');
        part.material.opacity = this.on('seethrough') ? SEE_THROUGH : 1;
        part.material.depthWrite = !this.on('seethrough');
        part.material.needsUpdate = true;
        if (part.material.emissive) part.material.emissive.setHex(name === this.selected ? 0x553300 : 0);
      }
    }
    for (const entry of this.parts.values()) entry.node.visible = this.on('layout');
    this.labels.hidden = !this.on('labels');
    this.draw();
  }

  resize() {
    const width = this.canvasBox.clientWidth, height = this.canvasBox.clientHeight;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // Pixels of a point of the canvas box, or null when it is behind the camera.
  project(point) {
    const p = point.clone().project(this.camera);
    if (p.z > 1) return null;
    return [(p.x + 1) / 2 * this.canvasBox.clientWidth, (1 - p.y) / 2 * this.canvasBox.clientHeight];
  }

  draw() {
    if (this.hasDetail) this.chooseDetail();
    this.fadeParts();
    this.renderer.render(this.scene, this.camera);
    this.placeLabels();
  }

  // The selected object's label, then the nearest ones: a label that would cover one of these is left out.
  placeLabels() {
    if (this.labels.hidden) return;
    for (const entry of this.objects.values()) entry.label.hidden = true;
    const waiting = [];
    for (const entry of this.rooms) {
      const at = this.on('layout') && this.project(entry.place);
      entry.label.hidden = true;
      if (at) waiting.push({entry, at, far: entry.place.distanceTo(this.camera.position)});
    }
    for (const [name, entry] of this.on('objects') ? this.objects : []) {
      const top = entry.box.isEmpty() ? null : entry.box.getCenter(new THREE.Vector3()).setY(entry.box.max.y);
      const at = top && this.project(top);
      entry.label.hidden = true;
      entry.label.classList.toggle('selected', name === this.selected);
      if (at) waiting.push({entry, at, far: name === this.selected ? -1 : top.distanceTo(this.camera.position)});
    }
    waiting.sort((a, b) => a.far - b.far);
    const placed = [];
    for (const {entry, at} of waiting) {
      const [width, height] = entry.labelSize;
      const box = [at[0] - width / 2, at[1] - 1.1 * height, at[0] + width / 2, at[1] - 0.1 * height];
      if (placed.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) continue;
      placed.push(box);
      entry.label.hidden = false;
      entry.label.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, -110%)`;
    }
  }

  // A pixel of the page where a click picks this object: the first found on it that nothing hides.
  pixelOf(name) {
    const entry = this.objects.get(name) || this.parts.get(name);
    const area = this.renderer.domElement.getBoundingClientRect();
    for (const {part} of entry.meshes) {
      const positions = part.geometry.attributes.position;
      const indices = part.geometry.index;
      for (let i = 0; i + 2 < indices.count; i += 3) {
        const middle = new THREE.Vector3();
        for (let c = 0; c < 3; ++c) {
          middle.add(new THREE.Vector3().fromBufferAttribute(positions, indices.getX(i + c)).divideScalar(3));
        }
        const at = this.project(part.localToWorld(middle));
        if (!at) continue;
        const pixel = {clientX: area.left + at[0], clientY: area.top + at[1]};
        const inside = at[0] > 0 && at[1] > 0 && at[0] < area.width && at[1] < area.height;
        if (inside && this.hit(pixel) === name) return [pixel.clientX, pixel.clientY];
      }
    }
    return null;
  }
}

async function start() {
  if (!document.createElement('canvas').getContext('webgl2')) {
    say('This browser has no WebGL 2, so there is no 3D view here; export/scene.glb opens in Blender and other programs.');
    window.deepslamViewer = {ready: false, error: 'no WebGL 2'};
    return;
  }
  try {
    const bytes = toBytes(document.getElementById('scene-glb').textContent);
    const draco = new OfflineDracoLoader();
    const gltf = await new GLTFLoader().setDRACOLoader(draco).parseAsync(bytes.buffer, '');
    draco.dispose();
    const viewer = new Viewer(gltf);
    say('');
    window.deepslamViewer = {
      ready: true,
      firstPictureMs: performance.now(),  // since the page was asked for
      names: () => [...viewer.objects.keys()],
      parts: () => [...viewer.parts.keys()],
      faded: () => [...viewer.parts].filter(([, entry]) => entry.faded).map(([name]) => name),
      roomLabels: () => viewer.rooms.map((room) => room.label.textContent),
      select: (name) => viewer.select(name),
      selected: () => viewer.selected,
      pixelOf: (name) => viewer.pixelOf(name),
      visible: (layer) => Boolean(viewer.layers[layer] && viewer.layers[layer].visible),
      facesDrawn: () => viewer.renderer.info.render.triangles,
      cameraPosition: () => viewer.camera.position.toArray(),
    };
  } catch (error) {
    say(`The scene could not be shown: ${error.message || error}`);
    window.deepslamViewer = {ready: false, error: String(error)};
  }
}

start();

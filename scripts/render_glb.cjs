// The body of render_glb.sh: a server on 127.0.0.1 for three.js and the file, a page, a picture.
const fs = require("fs");
const http = require("http");
const path = require("path");
const modules = process.env.DEEPSLAM_NODE_MODULES;
const {chromium} = require(path.join(modules, "playwright-core"));

const [input, output, yaw = "35", pitch = "30"] = process.argv.slice(2);
const hidden = (process.env.DEEPSLAM_HIDE || "").split(",").filter(Boolean);
const TIMEOUT_MS = 120000;

const page = `<!doctype html><html><head><meta charset="utf-8"><style>html,body{margin:0;background:#fff}</style>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script></head>
<body><script type="module">
import * as THREE from "three";
import {GLTFLoader} from "three/addons/loaders/GLTFLoader.js";
import {DRACOLoader} from "three/addons/loaders/DRACOLoader.js";
const [yaw, pitch, hidden] = [${Number(yaw)}, ${Number(pitch)}, ${JSON.stringify(hidden)}];
try {
  const draco = new DRACOLoader().setDecoderPath("/three/examples/jsm/libs/draco/gltf/");
  const gltf = await new GLTFLoader().setDRACOLoader(draco).loadAsync("/scene.glb");
  const nodes = [];
  gltf.scene.traverse((node) => {
    const geometry = node.geometry;
    nodes.push({name: node.userData.name || node.name, type: node.type, extras: node.userData,
                vertices: geometry ? geometry.attributes.position.count : 0,
                faces: geometry && geometry.index ? geometry.index.count / 3 : 0});
  });
  for (const name of hidden) { const node = gltf.scene.getObjectByName(name); if (node) node.visible = false; }
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xf4f4f4);
  scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, 0x99938a, 1.6));
  const sun = new THREE.DirectionalLight(0xffffff, 1.8);
  const box = new THREE.Box3();
  gltf.scene.traverseVisible((node) => { if (node.geometry) box.expandByObject(node); });
  if (box.isEmpty()) box.set(new THREE.Vector3(-1, 0, -1), new THREE.Vector3(1, 1, 1));
  const centre = box.getCenter(new THREE.Vector3());
  const radius = Math.max(1e-3, box.getSize(new THREE.Vector3()).length() / 2);
  const camera = new THREE.PerspectiveCamera(35, 4 / 3, radius / 100, radius * 20);
  const rad = Math.PI / 180;
  const direction = new THREE.Vector3(Math.sin(yaw * rad) * Math.cos(pitch * rad), Math.sin(pitch * rad),
                                      Math.cos(yaw * rad) * Math.cos(pitch * rad));
  camera.position.copy(centre).addScaledVector(direction, radius * 2.9);
  camera.lookAt(centre);
  sun.position.copy(centre).addScaledVector(new THREE.Vector3(1, 2, 0.6).add(direction).normalize(), radius * 3);
  sun.target.position.copy(centre);
  scene.add(sun, sun.target);
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setSize(1200, 900);
  document.body.appendChild(renderer.domElement);
  renderer.render(scene, camera);
  const size = box.getSize(new THREE.Vector3());
  window.result = {ok: true, size_m: [size.x, size.y, size.z], nodes};
} catch (error) {
  window.result = {ok: false, error: String(error && error.message || error)};
}
</script></body></html>`;

const types = {".js": "text/javascript", ".wasm": "application/wasm", ".glb": "model/gltf-binary"};
const server = http.createServer((request, response) => {
  const url = decodeURIComponent(request.url.split("?")[0]);
  if (url === "/") return response.writeHead(200, {"content-type": "text/html"}).end(page);
  const root = path.join(modules, "three");
  const file = url === "/scene.glb" ? input : path.join(modules, path.normalize(url));
  if (url !== "/scene.glb" && !file.startsWith(root)) return response.writeHead(404).end();
  fs.readFile(file, (error, data) => {
    if (error) return response.writeHead(404).end();
    response.writeHead(200, {"content-type": types[path.extname(file)] || "application/octet-stream"}).end(data);
  });
});

async function main() {
  fs.accessSync(input, fs.constants.R_OK);
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const browser = await chromium.launch({
    executablePath: process.env.DEEPSLAM_BROWSER, headless: true,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update",
           "--disable-default-apps", "--disable-sync", "--no-first-run", "--disable-dev-shm-usage"]});
  try {
    const tab = await browser.newPage({viewport: {width: 1200, height: 900}});
    const messages = [];
    tab.on("console", (message) => { if (message.type() === "error") messages.push(message.text()); });
    tab.on("pageerror", (error) => messages.push(String(error)));
    await tab.goto(`http://127.0.0.1:${server.address().port}/`);
    await tab.waitForFunction("window.result", null, {timeout: TIMEOUT_MS});
    const result = await tab.evaluate("window.result");
    if (result.ok) await tab.screenshot({path: output, timeout: TIMEOUT_MS});
    // The browser asks for an icon that nobody has.
    result.console_errors = messages.filter((text) => !text.includes("404"));
    console.log(JSON.stringify(result));
    return result.ok ? 0 : 1;
  } finally {
    await browser.close();
  }
}

main().then((code) => process.exit(code), (error) => { console.error(String(error)); process.exit(1); });

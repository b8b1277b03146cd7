// The body of report_test.py: opens PAGE from disk, tries what a person would, keeps pictures in FOLDER.
const assert = require("assert");
const path = require("path");
const {chromium} = require(path.join(process.env.DEEPSLAM_NODE_MODULES, "playwright-core"));
const [page, folder] = process.argv.slice(2);
const TIMEOUT_MS = 120000;

const view = (tab, expression) => tab.evaluate(`window.deepslamViewer.${expression}`);
const shot = (tab, name) => tab.screenshot({path: path.join(folder, name), timeout: TIMEOUT_MS});

async function picksByClick(tab, name) {
  const pixel = await view(tab, `pixelOf(${JSON.stringify(name)})`);
  if (!pixel) return false;  // hidden behind others from here
  await tab.mouse.click(pixel[0], pixel[1]);
  assert.strictEqual(await view(tab, "selected()"), name, "a click on an object picks it");
  const panel = tab.locator(".viewer-panel");
  assert.ok(await panel.isVisible(), "the panel is shown");
  assert.strictEqual(await panel.locator("h3").textContent(), name);
  const rows = await panel.locator("tr th").allTextContents();
  for (const wanted of ["class", "confidence", "size", "views"]) assert.ok(rows.includes(wanted), `panel says ${wanted}`);
  assert.ok(await panel.locator(".viewer-candidates li").count() >= 1, "the panel lists the candidates");
  assert.strictEqual(await panel.locator(".viewer-candidates li.chosen").count(), 1, "one candidate is the winner");
  return true;
}

// What is drawn changes when a switch is turned, and comes back when it is turned again.
async function switchesLayer(tab, layer) {
  const canvas = tab.locator(".viewer-canvas");
  const before = await canvas.screenshot({timeout: TIMEOUT_MS});
  await tab.locator(`input[data-layer=${layer}]`).click();
  const during = await canvas.screenshot({timeout: TIMEOUT_MS});
  assert.ok(!before.equals(during), `switch ${layer} changes the picture`);
  await tab.locator(`input[data-layer=${layer}]`).click();
  assert.ok((await canvas.screenshot({timeout: TIMEOUT_MS})).equals(before), `switch ${layer} back brings the picture back`);
}

async function turnsByKeyAndMouse(tab) {
  const before = await view(tab, "cameraPosition()");
  await tab.locator(".viewer-canvas").focus();
  await tab.keyboard.press("ArrowLeft");
  const turned = await view(tab, "cameraPosition()");
  assert.notDeepStrictEqual(turned, before, "an arrow key turns the view");
  const area = await tab.locator(".viewer-canvas").boundingBox();
  await tab.mouse.move(area.x + 40, area.y + 40);
  await tab.mouse.down();
  await tab.mouse.move(area.x + 140, area.y + 60, {steps: 4});
  await tab.mouse.up();
  assert.notDeepStrictEqual(await view(tab, "cameraPosition()"), turned, "dragging turns the view");
  await tab.locator("[data-action=home]").click();
}

async function selectsByKeyAndList(tab, names) {
  await view(tab, "select(null)");
  assert.ok(await tab.locator(".viewer-panel").isHidden(), "without an object there is no panel");
  await tab.locator(".viewer-canvas").focus();
  await tab.keyboard.press("n");
  assert.strictEqual(await view(tab, "selected()"), names[0], "N goes to the first object");
  await tab.keyboard.press("Escape");
  assert.strictEqual(await view(tab, "selected()"), null, "Escape lets go");
  const last = names.length - 1;
  await tab.locator(".viewer-list button").nth(last).click();
  assert.strictEqual(await view(tab, "selected()"), names[last], "the list picks an object");
  await view(tab, "select(null)");
}

async function check(tab) {
  const started = Date.now();
  await tab.goto("file://" + page);
  await tab.waitForFunction("window.deepslamViewer", null, {timeout: TIMEOUT_MS});
  console.log(`first picture after ${Date.now() - started} ms`);
  assert.ok(await tab.evaluate("window.deepslamViewer.ready"), await tab.evaluate("window.deepslamViewer.error || ''"));
  const names = await view(tab, "names()");
  assert.ok(names.length > 0, "the scene has objects");
  const labels = (await tab.locator(".viewer-label").allTextContents()).sort();
  assert.deepStrictEqual(labels, [...names].sort(), "every object has its label");
  assert.ok(await tab.locator(".viewer-label").first().isVisible(), "labels are shown");
  await tab.locator("#viewer").scrollIntoViewIfNeeded();
  let picked = 0;
  for (const name of names) picked += await picksByClick(tab, name) ? 1 : 0;
  assert.ok(picked > 0, "an object can be picked");
  console.log(`${picked} of ${names.length} objects picked by a click`);
  await shot(tab, "picked.png");
  await view(tab, "select(null)");
  for (const layer of ["objects", "colours", "seethrough", "measured", "room", "trajectory", "labels"]) {
    await switchesLayer(tab, layer);
  }
  await turnsByKeyAndMouse(tab);
  await selectsByKeyAndList(tab, names);
  assert.ok(await tab.locator("#timing").isVisible(), "times of the last run are shown");
  await tab.screenshot({path: path.join(folder, "page.png"), fullPage: true, timeout: TIMEOUT_MS});
}

async function main() {
  const browser = await chromium.launch({
    executablePath: process.env.DEEPSLAM_BROWSER, headless: true,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update",
           "--disable-default-apps", "--disable-sync", "--no-first-run", "--disable-dev-shm-usage"]});
  try {
    const context = await browser.newContext({viewport: {width: 1150, height: 900}, offline: true});
    const tab = await context.newPage();
    const errors = [];
    tab.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
    tab.on("pageerror", (error) => errors.push(String(error)));
    tab.on("request", (request) => {
      if (!/^(file|data|blob):/.test(request.url())) errors.push(`asked for ${request.url()}`);
    });
    await check(tab);
    assert.deepStrictEqual(errors, [], "no error on the console, nothing asked of a network");
  } finally {
    await browser.close();
  }
}

main().then(() => process.exit(0), (error) => { console.error(String(error.stack || error)); process.exit(1); });

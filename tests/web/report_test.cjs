// The body of report_test.py: opens pages from disk, tries what a person would, keeps pictures in FOLDER.
//   report_test.cjs FOLDER KIND=PAGE...       KIND: room, copied (without the times beside it), hall, empty
const assert = require("assert");
const path = require("path");
const {chromium} = require(path.join(process.env.DEEPSLAM_NODE_MODULES, "playwright-core"));
const [folder, ...pages] = process.argv.slice(2);
const TIMEOUT_MS = 600000;  // software rendering on a machine that is busy with other tests

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

// What the view draws: the pixels of its canvas and the labels over it. Not a screenshot: where the page moves the view by a
// part of a pixel, as times, pictures and fonts do that come late, the browser draws labels and canvas otherwise. The canvas
// takes its new size a frame after the panel beside it opens or closes, so two frames pass first.
const picture = (tab) => tab.evaluate(async () => {
  for (let frame = 0; frame < 2; ++frame) await new Promise((done) => requestAnimationFrame(done));
  const view = document.querySelector(".viewer-canvas");
  const labels = [...view.querySelectorAll(".viewer-label")].filter((label) => label.offsetParent !== null);
  return view.querySelector("canvas").toDataURL() + labels.map((label) => `${label.textContent} ${label.style.transform}`).join();
});

// As something does that comes late.
const growPage = (tab) => tab.evaluate(() => {
  const late = document.createElement("div");
  late.style.height = "10.4px";
  document.body.prepend(late);
});

// What is drawn changes when a switch is turned, and comes back when it is turned again, wherever the page has it by then.
async function switchesLayer(tab, layer) {
  const before = await picture(tab);
  await tab.locator(`input[data-layer=${layer}]`).click();
  assert.ok(await picture(tab) !== before, `switch ${layer} changes the picture`);
  await growPage(tab);
  await tab.locator(`input[data-layer=${layer}]`).click();
  assert.ok(await picture(tab) === before, `switch ${layer} back brings the picture back`);
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

// Opens a page and waits for its first picture.
async function open(tab, page) {
  await tab.goto("file://" + page);
  await tab.waitForFunction("window.deepslamViewer", null, {timeout: TIMEOUT_MS});
  assert.ok(await tab.evaluate("window.deepslamViewer.ready"), await tab.evaluate("window.deepslamViewer.error || ''"));
  console.log(`first picture after ${await tab.evaluate("window.deepslamViewer.firstPictureMs.toFixed()")} ms`);
  return view(tab, "names()");
}

async function checkRoom(tab, page) {
  const names = await open(tab, page);
  assert.ok(names.length > 0, "the scene has objects");
  const labels = (await tab.locator(".viewer-label").allTextContents()).sort();
  const rooms = await view(tab, "roomLabels()");
  assert.deepStrictEqual(labels, [...names, ...rooms].sort(), "every object and every room has its label");
  const boxes = await tab.locator(".viewer-label:visible").evaluateAll((all) => all.map((one) => {
    const box = one.getBoundingClientRect();
    return [box.left, box.top, box.right, box.bottom];
  }));
  assert.ok(boxes.length > 0, "labels are shown");
  const cover = (a, b) => a[0] + 1 < b[2] && b[0] + 1 < a[2] && a[1] + 1 < b[3] && b[1] + 1 < a[3];
  assert.ok(!boxes.some((a, i) => boxes.some((b, j) => i < j && cover(a, b))), "labels do not cover each other");
  await tab.locator("#viewer").scrollIntoViewIfNeeded();
  let picked = 0;
  for (const name of names) picked += await picksByClick(tab, name) ? 1 : 0;
  assert.ok(picked > 0, "an object can be picked");
  console.log(`${picked} of ${names.length} objects picked by a click`);
  await shot(tab, "picked.png");
  await view(tab, "select(null)");
  for (const layer of ["objects", "colours", "seethrough", "measured", "layout", "room", "trajectory", "labels"]) {
    await switchesLayer(tab, layer);
  }
  await checkWalls(tab);
  await turnsByKeyAndMouse(tab);
  await selectsByKeyAndList(tab, names);
  assert.ok(await tab.locator("#timing").isVisible(), "times of the last run are shown");
  await tab.screenshot({path: path.join(folder, "page.png"), fullPage: true, timeout: TIMEOUT_MS});
}

// Walls between the viewer and their room are seen through, and one that is not tells its length.
async function checkWalls(tab) {
  const walls = (await view(tab, "parts()")).filter((name) => name.startsWith("wall_"));
  assert.ok(walls.length > 0, "the scene has walls");
  const faded = await view(tab, "faded()");
  const solid = walls.filter((name) => !faded.includes(name));
  assert.ok(solid.length > 0, "from above, some walls stand behind their room");
  assert.ok(faded.some((name) => name.startsWith("wall_")), "and some before it");
  let told = false;
  for (const name of solid) {
    const pixel = await view(tab, `pixelOf(${JSON.stringify(name)})`);
    if (!pixel) continue;
    await tab.mouse.click(...pixel);
    assert.strictEqual(await view(tab, "selected()"), name, "a click picks the wall");
    told = (await tab.locator(".viewer-panel").textContent()).includes("length");
    break;
  }
  assert.ok(told, "a wall tells its length");
  await shot(tab, "walls.png");
  await view(tab, "select(null)");
}

// A page away from its workspace is whole but for the times, and says so.
async function checkCopied(tab, page) {
  await open(tab, page);
  await tab.waitForTimeout(500);
  assert.ok(await tab.locator("#timing").isHidden(), "there are no times to show");
  assert.ok(await tab.locator("#no-timing").isVisible(), "the page says where times are");
}

async function checkHall(tab, page) {
  const names = await open(tab, page);
  assert.ok(names.length >= 1000, "the scene has a thousand objects");
  await tab.locator(".viewer-list button").nth(999).click();
  assert.strictEqual(await view(tab, "selected()"), names[999], "the last one can be picked");
  await view(tab, "select(null)");
  await tab.locator("#viewer").scrollIntoViewIfNeeded();
  const started = Date.now();
  await tab.locator(".viewer-canvas").focus();
  for (let n = 0; n < 5; ++n) await tab.keyboard.press("ArrowLeft");
  console.log(`${names.length} objects: a turn takes ${(Date.now() - started) / 5} ms`);
  await shot(tab, "hall.png");
}

async function checkEmpty(tab, page) {
  assert.deepStrictEqual(await open(tab, page), [], "the scene has no objects");
  assert.ok((await tab.locator("body").textContent()).includes("No object entered the map"), "the page says so");
  assert.ok(await view(tab, "visible('trajectory')"), "the path is there all the same");
  await tab.locator("[data-action=home]").click();
  await tab.locator(".viewer-canvas").focus();
  await tab.keyboard.press("n");
  assert.strictEqual(await view(tab, "selected()"), null, "there is nothing to pick");
  await tab.locator("#viewer").scrollIntoViewIfNeeded();
  await shot(tab, "empty.png");
}

const distance = (position) => Math.hypot(...position);

async function touch(session, ...steps) {
  const points = (list) => list.map(([x, y], id) => ({x, y, id}));
  await session.send("Input.dispatchTouchEvent", {type: "touchStart", touchPoints: points(steps[0])});
  for (const step of steps.slice(1)) {
    await session.send("Input.dispatchTouchEvent", {type: "touchMove", touchPoints: points(step)});
  }
  await session.send("Input.dispatchTouchEvent", {type: "touchEnd", touchPoints: []});
}

// On a telephone: fingers turn, spread and tap; nothing is wider than the screen.
async function checkPhone(tab, page, context) {
  const names = await open(tab, page);
  const [wide, screen] = await tab.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]");
  assert.ok(wide <= screen, `the page is ${wide} px wide on a screen of ${screen}`);
  await tab.locator(".viewer-main").scrollIntoViewIfNeeded();
  const session = await context.newCDPSession(tab);
  const area = await tab.locator(".viewer-canvas").boundingBox();
  const at = (u, v) => [area.x + u * area.width, area.y + v * area.height];
  const before = await view(tab, "cameraPosition()");
  await touch(session, [at(0.3, 0.5)], [at(0.5, 0.5)], [at(0.7, 0.5)]);
  const turned = await view(tab, "cameraPosition()");
  assert.notDeepStrictEqual(turned, before, "a finger turns the view");
  await touch(session, [at(0.45, 0.5), at(0.55, 0.5)], [at(0.35, 0.5), at(0.65, 0.5)], [at(0.2, 0.5), at(0.8, 0.5)]);
  assert.ok(distance(await view(tab, "cameraPosition()")) < distance(turned), "two fingers that part come nearer");
  await tab.locator("[data-action=home]").click();
  await tab.locator(".viewer-main").scrollIntoViewIfNeeded();
  for (const name of names) {
    const pixel = await view(tab, `pixelOf(${JSON.stringify(name)})`);
    if (!pixel) continue;
    await tab.touchscreen.tap(pixel[0], pixel[1]);
    assert.strictEqual(await view(tab, "selected()"), name, "a tap picks an object");
    break;
  }
  assert.ok(await tab.locator(".viewer-panel").isVisible(), "the panel is shown");
  await shot(tab, "phone.png");
}

const DESKTOP = {viewport: {width: 1150, height: 900}, offline: true};
const PHONE = {viewport: {width: 390, height: 844}, hasTouch: true, isMobile: true, deviceScaleFactor: 2, offline: true};

async function inTab(browser, settings, check, page) {
  const context = await browser.newContext(settings);
  context.setDefaultTimeout(TIMEOUT_MS);
  const tab = await context.newPage();
  const errors = [];
  tab.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
  tab.on("pageerror", (error) => errors.push(String(error)));
  tab.on("request", (request) => {
    if (!/^(file|data|blob):/.test(request.url())) errors.push(`asked for ${request.url()}`);
  });
  await check(tab, page, context);
  assert.deepStrictEqual(errors, [], "no error on the console, nothing asked of a network");
  await context.close();
}

async function main() {
  const browser = await chromium.launch({
    executablePath: process.env.DEEPSLAM_BROWSER, headless: true,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update",
           "--disable-default-apps", "--disable-sync", "--no-first-run", "--disable-dev-shm-usage"]});
  const checks = {room: checkRoom, copied: checkCopied, hall: checkHall, empty: checkEmpty};
  try {
    for (const argument of pages) {
      const [kind, page] = [argument.slice(0, argument.indexOf("=")), argument.slice(argument.indexOf("=") + 1)];
      console.log(`${kind}: ${page}`);
      await inTab(browser, DESKTOP, checks[kind], page);
      if (kind === "room") await inTab(browser, PHONE, checkPhone, page);
    }
  } finally {
    await browser.close();
  }
}

main().then(() => process.exit(0), (error) => { console.error(String(error.stack || error)); process.exit(1); });

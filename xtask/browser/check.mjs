// `cargo xtask browser`: the viewer's page in headless Chromium. check.mjs PROGRAM SCENES_DIR OUT_DIR CHROMIUM [SECONDS]
// Prints a line for each thing that is looked at, and exits with 1 where one is not as it must be.

import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";
import puppeteer from "puppeteer-core";

const [, , program, scenes, out, chromium, seconds = "10"] = process.argv;
const axe = fs.readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
let failures = 0;
const report = (is, what) => {
  console.log(`${is ? "ok  " : "FAIL"} ${what}`);
  if (!is) failures += 1;
};

/** A viewer of a scene: its process and the address of its page. */
async function view(words, port = 0) {
  const viewer = spawn(program, ["view", ...words, "--no-open", "--backend", "cpu", "--port", String(port)]);
  let said = "";
  viewer.stderr.on("data", (data) => (said += data));
  const url = await new Promise((done, failed) => {
    viewer.stdout.once("data", (data) => done(String(data).trim()));
    viewer.on("exit", () => failed(new Error(said)));
  });
  return { viewer, url };
}

const browser = await puppeteer.launch({ executablePath: chromium, headless: true, args: ["--no-sandbox", "--disable-gpu"] });
const foreign = [];
async function open(url, viewport = { width: 1100, height: 800 }) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  await page.setViewport(viewport);
  page.on("pageerror", (error) => report(false, `error on the page: ${error.message}`));
  page.on("request", (request) => {
    if (!/^(http:\/\/127\.0\.0\.1:|blob:)/.test(request.url())) foreign.push(request.url());
  });
  await page.goto(url);
  await page.waitForFunction("window.eosphor?.measured.frames > 0", { timeout: 20000 });
  return page;
}
const rest = async (page) => {
  await pause(250);
  await page.waitForFunction("window.eosphor.file && window.eosphor.measured.last.format === 'image/png'", { timeout: 120000 });
};
const set = (page, id, value) =>
  page.$eval(`#${id}`, (element, value) => {
    element.value = value;
    for (const kind of ["input", "change"]) element.dispatchEvent(new Event(kind, { bubbles: true }));
  }, value);
const middle = async (page) => {
  const box = await (await page.$("#picture")).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
};

// What rests is the file: the PNG of the page and that of the copied command line.
const changes = [
  async () => {},
  async (page) => {
    const [x, y] = await middle(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 10, y + 3, { steps: 4 });
    await page.mouse.up();
    await set(page, "exposure", "0.5");
  },
  async (page) => {
    await set(page, "lighting", "lambert");
    await set(page, "samples", "2");
    await set(page, "fov", "42");
  },
  async (page) => {
    await set(page, "shadows", "none");
    await set(page, "depth", "1");
    await set(page, "width", "120");
    await page.focus("#picture");
    await page.keyboard.down("w");
    await pause(150);
    await page.keyboard.up("w");
  },
];
const file = (name) => path.join(scenes, name);
const all = [
  ["builtin:cornell"], ["builtin:cornell-pg1"], ["builtin:solids"], ["builtin:cornell", "--preset", "eos"],
  ...["glass-and-mirrors.json", "leaves.json", "vase.obj", "knot.glb", "depth-of-field.json", "coloured-shadows.json"].map((name) => [file(name)]),
];
let same = 0;
for (const scene of all) {
  const { viewer, url } = await view([...scene, "--size", "160x100", "--samples", "3"]);
  const page = await open(url);
  for (const change of changes) {
    await rest(page);
    await change(page);
    await rest(page);
    const picture = Buffer.from(await page.evaluate(async () => Array.from(new Uint8Array(await window.eosphor.file.arrayBuffer()))));
    await page.click("#copy");
    await page.waitForFunction("document.getElementById('command').textContent !== ''");
    const command = await page.$eval("#command", (element) => {
      const text = element.textContent;
      element.textContent = "";
      return text;
    });
    const target = path.join(out, "command.png");
    execFileSync("sh", ["-c", `${command.replace(/^eosphor/, program).replace("picture.png", target)} -q`]);
    const is = fs.readFileSync(target).equals(picture);
    if (is) same += 1;
    else console.log(`different: ${command}`);
  }
  await page.browserContext().close();
  viewer.kill();
}
report(same === all.length * changes.length, `${same} of ${all.length * changes.length} pictures at rest are those of their command lines`);

// Latency of a scripted orbit, and how soon the picture is whole again.
{
  const start = Date.now();
  const { viewer, url } = await view(["builtin:cornell", "--size", "640x360"]);
  const page = await open(url);
  report(Date.now() - start < 5000, `first frame ${Date.now() - start} ms after the start`);
  await pause(1000);
  const [x, y] = await middle(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.evaluate("window.eosphor.measured.latencies.length = 0; window.eosphor.measured.frames = 0");
  const began = Date.now();
  while (Date.now() - began < Number(seconds) * 1000) {
    const t = (Date.now() - began) / 1000;
    await page.mouse.move(x + 40 * Math.sin(t * 1.5), y + 15 * Math.cos(t));
    await pause(12);
  }
  const { latencies, frames } = await page.evaluate("({ latencies: window.eosphor.measured.latencies, frames: window.eosphor.measured.frames })");
  latencies.sort((a, b) => a - b);
  const at = (share) => latencies[Math.floor(latencies.length * share)]?.toFixed(1);
  await page.screenshot({ path: path.join(out, "moving.png") });
  await page.mouse.up();
  // Figures, not verdicts: a test does not depend on the time it took.
  console.log(`     ${(frames / Number(seconds)).toFixed(1)} frames/s; input to picture: median ${at(0.5)} ms, p95 ${at(0.95)} ms`);
  await page.browserContext().close();
  viewer.kill();
}

// A server that comes back, with the same camera; a file with a mistake, and its repair; two pages with cameras of their own.
{
  const scene = path.join(out, "followed.json");
  const text = (color) => `{ "eosphor": 2, "camera": { "position": [0, 0, 5], "look-at": [0, 0, 0] },
    "materials": { "m": { "matte": { "color": ${color} } } }, "spheres": [{ "center": [0, 0, 0], "radius": 1, "material": "m" }] }`;
  fs.writeFileSync(scene, text("[1, 0, 0]"));
  // A port of one's own keeps its token.
  let { viewer, url } = await view([scene, "--size", "160x100", "--samples", "1"], 20000 + (process.pid % 20000));
  const [first, second] = [await open(url), await open(url)];
  await rest(first);
  await first.focus("#picture");
  await first.keyboard.down("ArrowLeft");
  await pause(300);
  await first.keyboard.up("ArrowLeft");
  await rest(first);
  const eye = (page) => page.evaluate("JSON.stringify(window.eosphor.view.camera.eye)");
  report((await eye(first)) !== (await eye(second)), "two pages have cameras of their own; keys turn the camera");
  fs.writeFileSync(scene, text('[1, 0, "blue"]'));
  await first.waitForFunction("!document.getElementById('problem').hidden", { timeout: 10000 });
  const problem = await first.$eval("#problem", (element) => element.textContent);
  report(/followed\.json:\d+:\d+/.test(problem), `a mistake is shown with its place: ${problem.split("\n")[0]}`);
  fs.writeFileSync(scene, text("[0, 0, 1]"));
  await first.waitForFunction("document.getElementById('problem').hidden", { timeout: 10000 });
  report(true, "the repair is followed");
  const before = await eye(first);
  const port = new URL(url).port;
  viewer.kill();
  await first.waitForFunction("!window.eosphor.connected");
  ({ viewer, url } = await view([scene, "--size", "160x100", "--samples", "1"], port));
  const started = Date.now();
  await first.waitForFunction("window.eosphor.connected");
  console.log(`     connected again ${Date.now() - started} ms after the server has come back`);
  await rest(first);
  report((await eye(first)) === before, "after a restart of the server the tab has the same camera");
  for (const page of [first, second]) await page.browserContext().close();
  viewer.kill();
}

// How it looks and reads: desktop and phone, light and dark.
{
  const { viewer, url } = await view(["builtin:cornell", "--size", "640x360", "--samples", "4"]);
  for (const [name, viewport] of [["desktop", { width: 1280, height: 800 }], ["phone", { width: 390, height: 844, isMobile: true, hasTouch: true }]]) {
    for (const scheme of ["light", "dark"]) {
      const page = await open(url, viewport);
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
      await rest(page);
      await page.screenshot({ path: path.join(out, `${name}-${scheme}.png`) });
      await page.evaluate(axe);
      const { violations } = await page.evaluate("axe.run()");
      const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
      report(serious.length === 0, `${name}, ${scheme}: axe finds nothing serious ${serious.map((v) => `${v.id}: ${v.nodes[0].html}`)}`);
      const wide = await page.evaluate("document.documentElement.scrollWidth > window.innerWidth");
      report(!wide, `${name}, ${scheme}: nothing is wider than the screen`);
      await page.browserContext().close();
    }
  }
  viewer.kill();
}
report(foreign.length === 0, `no request goes elsewhere ${foreign.slice(0, 3)}`);
await browser.close();
process.exit(failures > 0 ? 1 : 0);

// `cargo xtask browser`: the viewer's page in headless Chromium. check.mjs PROGRAM SCENES_DIR OUT_DIR CHROMIUM SECONDS PROCESSES
// Prints a line for each thing that is looked at, and exits with 1 where one is not as it must be.

import { execFileSync, spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import net from "node:net";
import path from "node:path";
import { createRequire } from "node:module";
import puppeteer from "puppeteer-core";

const [, , program, scenes, out, chromium, seconds, processes] = process.argv;
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
/** An empty page. */
async function empty(viewport = { width: 1100, height: 800 }) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  await page.setViewport(viewport);
  page.on("pageerror", (error) => report(false, `error on the page: ${error.message}`));
  page.on("request", (request) => {
    if (!/^(http:\/\/127\.0\.0\.1:|blob:)/.test(request.url())) foreign.push(request.url());
  });
  return page;
}
/** Shows the viewer at this address in it. */
async function show(page, url) {
  await page.goto(url);
  await page.waitForFunction("window.eosphor?.measured.frames > 0", { timeout: 20000 });
  return page;
}
const open = async (url, viewport) => show(await empty(viewport), url);
const rest = async (page) => {
  await pause(250);
  await page.waitForFunction("window.eosphor.file && window.eosphor.measured.last.format === 'image/png'", { timeout: 120000 });
};
const set = (page, id, value) =>
  page.$eval(`#${id}`, (element, value) => {
    element.value = value;
    for (const kind of ["input", "change"]) element.dispatchEvent(new Event(kind, { bubbles: true }));
  }, value);
/** The file that a button of the page hands to the browser, as bytes. */
async function taken(page, button) {
  const bytes = await page.evaluate(async (button) => {
    // The page may not fetch it; what it makes an address for is the file.
    const { createObjectURL } = URL;
    const { click } = HTMLAnchorElement.prototype;
    try {
      const file = await new Promise((done, failed) => {
        let blob = null;
        URL.createObjectURL = (made) => createObjectURL.call(URL, (blob = made));
        HTMLAnchorElement.prototype.click = () => done(blob);
        document.getElementById(button).click();
        setTimeout(() => failed(new Error(document.getElementById("problem").textContent)), 10000);
      });
      return Array.from(new Uint8Array(await file.arrayBuffer()));
    } finally {
      URL.createObjectURL = createObjectURL;
      HTMLAnchorElement.prototype.click = click;
    }
  }, button);
  return Buffer.from(bytes);
}
const pictureOf = async (page) =>
  Buffer.from(await page.evaluate(async () => Array.from(new Uint8Array(await window.eosphor.file.arrayBuffer()))));
async function commandOf(page) {
  await page.$eval("#command", (element) => { element.textContent = ""; });
  await page.click("#copy");
  await page.waitForFunction("document.getElementById('command').textContent !== ''");
  return page.$eval("#command", (element) => element.textContent);
}
/** Runs a copied command line; `name` takes the place of the picture's. */
const run = (command, name, target) => execFileSync("sh", ["-c", `${command.replace(/^eosphor/, program).replace(name, target)} -q`]);

const middle = async (page) => {
  const box = await (await page.$("#picture")).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
};

/** A port that passes on to another one, with so many bytes a second on the way back. */
async function relay(port, rate) {
  const server = net.createServer((near) => {
    const far = net.connect(port, "127.0.0.1");
    near.pipe(far);
    far.on("data", async (data) => {
      far.pause();
      for (let at = 0; at < data.length; at += 2500) {
        await pause((1000 * Math.min(2500, data.length - at)) / rate);
        near.write(data.subarray(at, at + 2500));
      }
      far.resume();
    });
    far.on("end", () => near.end());
    for (const socket of [near, far]) socket.on("error", () => { near.destroy(); far.destroy(); });
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return server;
}
/** The picture on show as 16 x 9 mean colours. */
const colours = (page) =>
  page.$eval("#picture", (canvas) => {
    const small = new OffscreenCanvas(16, 9).getContext("2d");
    small.imageSmoothingQuality = "high";
    small.drawImage(canvas, 0, 0, 16, 9);
    return Array.from(small.getImageData(0, 0, 16, 9).data).filter((_, k) => k % 4 < 3);
  });

// What rests is the file: the PNG of the page and that of the copied command line.
const changes = [
  async () => {},
  // Alone: a camera that was framed for the first size stays.
  (page) => set(page, "height", "140"),
  async (page) => {
    const [x, y] = await middle(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 10, y + 3, { steps: 4 });
    await page.mouse.up();
    await set(page, "exposure", "0.5");
    await set(page, "tone-curve", "agx");
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
  async (page) => {
    // A lens, and what is in the middle of the picture sharp.
    await set(page, "aperture", "0.1");
    await page.click("#focus-click");
    const [x, y] = await middle(page);
    const before = await page.evaluate("window.eosphor.view.camera['focus-distance']");
    await page.mouse.click(x, y);
    await page
      .waitForFunction((before) => window.eosphor.view.camera["focus-distance"] !== before, { timeout: 3000 }, before)
      .catch(() => console.log("     nothing was there to be sharp"));
  },
];
const file = (name) => path.join(scenes, name);
const all = [
  ["builtin:cornell"], ["builtin:cornell-pg1"], ["builtin:solids"], ["builtin:cornell", "--preset", "eos"],
  ...["glass-and-mirrors.json", "leaves.json", "vase.obj", "depth-of-field.json", "coloured-shadows.json"].map((name) => [file(name)]),
  // (Path tracing has no lighting model and shadows to change.)
  [file("knot.glb"), "--integrator", "whitted"],
];
let same = 0;
let sameSaved = 0;
for (const scene of all) {
  const { viewer, url } = await view([...scene, "--size", "160x100", "--samples", "3"]);
  const page = await open(url);
  for (const change of changes) {
    await rest(page);
    await change(page);
    await rest(page);
    const picture = await pictureOf(page);
    const command = await commandOf(page);
    const target = path.join(out, "command.png");
    run(command, "picture.png", target);
    if (fs.readFileSync(target).equals(picture)) same += 1;
    else console.log(`different: ${command}`);
    const saved = path.join(out, "saved.json");
    fs.writeFileSync(saved, await taken(page, "save"));
    execFileSync(program, ["render", saved, "-o", target, "--no-metadata", "--backend", "cpu", "-q"]);
    if (fs.readFileSync(target).equals(picture)) sameSaved += 1;
    else console.log(`the saved scene is different: ${command}\n${fs.readFileSync(saved)}`);
  }
  await page.browserContext().close();
  viewer.kill();
}
report(same === all.length * changes.length, `${same} of ${all.length * changes.length} pictures at rest are those of their command lines`);
report(sameSaved === all.length * changes.length, `${sameSaved} of ${all.length * changes.length} are those of the saved scenes`);

// What is shown beside the picture, the frames of an animation, hierarchies, linear colours, and two pictures compared.
{
  const { viewer, url } = await view(["builtin:solids", "--size", "160x100", "--samples", "3"]);
  const page = await open(url);
  await rest(page);
  const first = await pictureOf(page);
  for (const [index, last] of [["1", "frame_0001.png"], ["7", "frame_0007.png"]]) {
    await set(page, "frame", index);
    await rest(page);
    run(await commandOf(page), "frame_%04d.png", path.join(out, "frame_%04d.png"));
    report(fs.readFileSync(path.join(out, last)).equals(await pictureOf(page)), `the slider shows frame ${index}, as its command line writes it`);
  }
  await page.click("#play");
  await pause(500);
  await page.click("#play");
  report((await page.evaluate("window.eosphor.view.frame")) !== 7, "playing goes on to other frames");
  await set(page, "frame", "0");
  await rest(page);
  const seen = [await pictureOf(page)];
  report(seen[0].equals(first), "the first frame is the picture again");
  for (const show of ["normals", "depth", "objects", "materials", "cost"]) {
    await set(page, "show", show);
    await rest(page);
    seen.push(await pictureOf(page));
    await page.screenshot({ path: path.join(out, `show-${show}.png`) });
    const command = await commandOf(page);
    if (show === "cost") {
      run(command, "picture.png", path.join(out, "cost.png"));
      report(fs.readFileSync(path.join(out, "cost.png")).equals(seen.at(-1)), "costs are those of the command line");
    } else report(command.includes(`--layers=${show.replace(/s$/, "")}`), `${show}: ${command.slice(-44)}`);
  }
  report(new Set(seen.map((picture) => picture.toString("base64"))).size === seen.length, "each of them is another picture");
  await set(page, "show", "picture");
  await rest(page);
  const [x, y] = await middle(page);
  await page.mouse.move(x + 3, y + 2);
  await page.waitForFunction("!document.getElementById('value').hidden", { timeout: 5000 });
  const value = await page.$eval("#value", (element) => element.textContent);
  report(/object \d+ .*\nmaterial \d+ .*\ndistance/.test(value), `the pointer tells: ${value.replaceAll("\n", "; ")}`);
  const exr = path.join(out, "command.exr");
  run((await commandOf(page)).replace("picture.png", "picture.exr"), "picture.exr", exr);
  report(fs.readFileSync(exr).equals(await taken(page, "exr")), "the EXR is that of the command line");
  for (const accel of ["octree", "kdtree", "bvh"]) {
    await page.select("#accel", accel);
    await page.waitForFunction((accel) => window.eosphor.scene.device?.accel === accel, { timeout: 10000 }, accel);
    await rest(page);
    report((await pictureOf(page)).equals(first), `the same picture through ${accel}`);
  }
  await page.focus("#picture");
  await page.keyboard.press("k");
  await set(page, "exposure", "3");
  await rest(page);
  const screen = () => page.$eval("#picture", (canvas) => canvas.toDataURL());
  const now = await screen();
  await page.focus("#picture");
  await page.keyboard.down("c");
  const compared = await screen();
  await page.keyboard.up("c");
  report(compared !== now && (await screen()) === now, "C shows the picture that K has kept");
  await page.click("#reset");
  await rest(page);
  await page.browserContext().close();
  viewer.kill();
}

// Latency of a scripted orbit, each time of a fresh server.
for (let k = 0; k < Number(processes); k += 1) {
  const page = await empty();
  const start = Date.now();
  const { viewer, url } = await view(["builtin:cornell", "--size", "640x360"]);
  await show(page, url);
  console.log(`     first frame ${Date.now() - start} ms after the start`);
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

// A slow line, by a relay: moving frames are video, of the picture that then rests.
{
  const { viewer, url } = await view(["builtin:cornell", "--size", "1280x720", "--samples", "2", "--shadows", "none"]);
  const slow = await relay(new URL(url).port, 250000);
  const page = await open(url.replace(/:\d+\//, `:${slow.address().port}/`));
  await rest(page);
  const [x, y] = await middle(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  const formats = new Map();
  const latencies = [];
  let small = null;
  for (let k = 0; k < 300; k += 1) {
    // Quick at first, and slow in the end: the last moving picture is nearly that at rest.
    await page.mouse.move(x + (k < 250 ? 40 * Math.sin(k * 0.05) : 0.01 * k), y);
    await pause(12);
    const format = await page.evaluate("window.eosphor.measured.last.format");
    formats.set(format, (formats.get(format) ?? 0) + 1);
    if (format === "video/h264") small = await colours(page);
  }
  latencies.push(...(await page.evaluate("window.eosphor.measured.latencies.slice(-50)")));
  await page.mouse.up();
  await rest(page);
  const decodes = await page.evaluate("'VideoDecoder' in window");
  console.log(`     2 Mbit/s: ${[...formats].join("; ")}; input to picture ${latencies.sort((a, b) => a - b)[25]?.toFixed(0)} ms`);
  report(!decodes || small !== null, "on a slow line moving frames are video, where the browser decodes it");
  if (small) {
    const sharp = await colours(page);
    const apart = sharp.reduce((sum, value, k) => sum + Math.abs(value - small[k]), 0) / sharp.length;
    report(apart < 6, `they show the picture that then rests: ${apart.toFixed(2)} of 255 apart`);
  }
  await page.browserContext().close();
  slow.close();
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
  await first.reload();
  await first.waitForFunction("!document.getElementById('problem').hidden && window.eosphor.measured.frames > 0", { timeout: 10000 });
  report(true, "a page that is loaded with the mistake there shows it over the last picture");
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

// Who has no token, comes by another name, or from another page, is refused.
{
  const { viewer, url } = await view(["builtin:cornell", "--size", "160x100", "--samples", "1"]);
  const { port, origin } = new URL(url);
  const page = await open(url);
  report(!page.url().includes("token"), "the token leaves the address bar");
  const [cookie] = await page.cookies();
  report(cookie.httpOnly && cookie.sameSite === "Strict", "the cookie is HttpOnly and SameSite=Strict");
  const status = (path, headers) =>
    new Promise((done) => http.get({ port, path, headers, host: "127.0.0.1" }, (answer) => done(answer.resume().statusCode)));
  const known = { cookie: `${cookie.name}=${cookie.value}` };
  const answers = await Promise.all([
    status("/", known), status("/"), status("/?token=0123456789abcdef0123456789abcdef"), status("/", { ...known, host: "evil.example" }),
  ]);
  report(answers.join() === "200,403,403,403", `who is known gets the page; no token, a wrong one, a foreign name: ${answers}`);
  // A page of another port of this machine is of the same site, so that the cookie is sent: its origin gives it away.
  const other = http.createServer((_, answer) => answer.setHeader("content-type", "text/html").end("<p>other</p>")).listen(0, "127.0.0.1");
  await new Promise((done) => other.once("listening", done));
  const foreignPage = await page.browserContext().newPage();
  await foreignPage.goto(`http://127.0.0.1:${other.address().port}/`);
  const opened = await foreignPage.evaluate((address) => new Promise((done) => {
    const socket = new WebSocket(address);
    [socket.onopen, socket.onerror] = [() => done(true), () => done(false)];
  }), `${origin.replace("http", "ws")}/socket`);
  report(!opened, "a foreign page opens no socket");
  other.close();
  await page.browserContext().close();
  viewer.kill();
}

// The picture of the README.
{
  const { viewer, url } = await view(["builtin:cornell", "--size", "800x640", "--samples", "64"]);
  const page = await open(url, { width: 1150, height: 680 });
  await rest(page);
  const [x, y] = await middle(page);
  await page.mouse.move(x - 60, y + 130);
  await page.waitForFunction("!document.getElementById('value').hidden", { timeout: 5000 });
  await page.screenshot({ path: path.join(out, "viewer.png") });
  await page.browserContext().close();
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

// The page of `eosphor view`: sends where the camera is and which settings it has, and draws the frames that come back.

import { FrameDecoder, canDecode } from "./video.js";

const $ = (id) => document.getElementById(id);
const canvas = $("picture");
const ctx = canvas.getContext("2d", { alpha: false });

/** What the server has on show; `view` is that of the file. */
let scene = null;
/** What this page shows. */
let view = null;
let socket = null;
/** Counts what the user did; times of inputs whose frame has not come yet. */
let input = 0;
const sentAt = new Map();
let moving = false;
/** Whether the camera looks at a point that is worth turning about. */
let isSettled = false;
let restTimer = 0;
let sendPending = false;
/** The last frame: header and bitmap; the picture that K has kept. */
let shown = null;
/** Its number; each connection counts anew. */
let lastFrame = 0;
/** The pieces of a picture at rest that have come. */
let pieceBlobs = [];
/** Of moving frames that come as video; whether this browser has one. */
let decoder = null;
let decodes = canDecode();
let kept = null;
let comparing = false;
/** The picture at rest, as a file, and where the page has it. */
let fileBlob = null;
let file = null;
/** Waits for a click that says what is to be sharp; the pixel that was clicked. */
let isFocusing = false;
let focusPixel = null;
/** What was refused, while it is shown. */
let refusedInput = null;
const drawn = [];
/** Figures for tests: milliseconds from input to picture, and the headers of frames. */
const measured = { latencies: [], frames: 0, last: null };
window.eosphor = { measured, get file() { return fileBlob; }, get scene() { return scene; }, get view() { return view; }, get connected() { return socket?.readyState === 1; } };

// Vectors.
const sub = (a, b) => a.map((x, i) => x - b[i]);
const add = (a, b) => a.map((x, i) => x + b[i]);
const mul = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const length = (a) => Math.hypot(...a);
const unit = (a) => mul(a, 1 / (length(a) || 1));
/** A vector turned about a unit axis (Rodrigues). */
const turned = (v, axis, angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(mul(v, c), mul(cross(axis, v), s)), mul(axis, dot(axis, v) * (1 - c)));
};

// The camera.
const mode = () => document.querySelector("input[name=mode]:checked").value;

/**
 * The point to turn about and to come near to: ahead of the eye, as far as the middle of the scene. Files often look at a point
 * that is only there to give a direction.
 */
function settleAim() {
  if (isSettled) return;
  isSettled = true;
  const { eye, "look-at": aim } = view.camera;
  const ahead = unit(sub(aim, eye));
  const far = dot(sub(scene.center, eye), ahead);
  if (far > scene.radius * 0.05) view.camera["look-at"] = add(eye, mul(ahead, far));
}

/** Turns about the point looked at (orbit) or about the eye (fly), by angles in radians. */
function turn(across, down) {
  settleAim();
  const camera = view.camera;
  const up = unit(camera.up);
  const isOrbit = mode() === "orbit";
  const arm = isOrbit ? sub(camera.eye, camera["look-at"]) : sub(camera["look-at"], camera.eye);
  let next = turned(arm, up, -across);
  const side = unit(cross(isOrbit ? mul(next, -1) : next, up));
  // Not over the poles.
  const height = Math.asin(Math.max(-1, Math.min(1, dot(unit(next), up))));
  const wanted = Math.max(-1.55, Math.min(1.55, height + (isOrbit ? down : -down)));
  next = turned(next, side, isOrbit ? height - wanted : wanted - height);
  if (isOrbit) camera.eye = add(camera["look-at"], next);
  else camera["look-at"] = add(camera.eye, next);
  changed(true);
}

/** Moves eye and aim: to the right, up, ahead, in world units. */
function move(right, above, ahead) {
  const camera = view.camera;
  const forward = unit(sub(camera["look-at"], camera.eye));
  const side = unit(cross(forward, camera.up));
  const by = add(add(mul(side, right), mul(cross(side, forward), above)), mul(forward, ahead));
  camera.eye = add(camera.eye, by);
  camera["look-at"] = add(camera["look-at"], by);
  changed(true);
}

/** Comes nearer (below 1) or goes away. */
function approach(factor) {
  settleAim();
  const camera = view.camera;
  const arm = sub(camera.eye, camera["look-at"]);
  if (mode() === "fly") return move(0, 0, (1 - factor) * scene.radius * 0.5);
  camera.eye = add(camera["look-at"], mul(arm, factor));
  changed(true);
}

const aimDistance = () => length(sub(view.camera["look-at"], view.camera.eye));

// Messages.
const say = (message) => {
  if (socket?.readyState === 1) socket.send(JSON.stringify(message));
};

/** The view has changed; while it `isMoving`, frames are quick, and after that they get sharp. */
function changed(isMoving) {
  if (!view) return;
  moving = isMoving;
  input += 1;
  sentAt.set(input, performance.now());
  if (!sendPending) {
    sendPending = true;
    // One message a frame of the screen; a hidden page draws none.
    const send = () => {
      if (!sendPending) return;
      sendPending = false;
      say({ type: "view", input, moving, view });
    };
    requestAnimationFrame(send);
    setTimeout(send, 40);
  }
  clearTimeout(restTimer);
  if (isMoving) restTimer = setTimeout(() => changed(false), 120);
  else remember();
  if (file) setFile(null);
}

/** The view of this tab, for when it is loaded again: with the viewer's next address, say. */
const memory = () => `view of ${scene.name}`;
function remember() {
  try { sessionStorage.setItem(memory(), JSON.stringify({ of: scene.view, view })); } catch { /* Then it is not kept. */ }
}
function remembered() {
  try {
    const { of, view } = JSON.parse(sessionStorage.getItem(memory()));
    // Of a scene whose file says something else now the file counts.
    return JSON.stringify(of) === JSON.stringify(scene.view) ? view : null;
  } catch {
    return null;
  }
}

function setFile(blob) {
  fileBlob = blob;
  if (file) URL.revokeObjectURL(file);
  file = blob ? URL.createObjectURL(blob) : null;
  const link = $("download");
  if (file) link.href = file;
  else link.removeAttribute("href");
  link.setAttribute("aria-disabled", String(!file));
}

function connect() {
  lastFrame = 0;
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  decoder?.close();
  decoder = null;
  socket.onopen = async () => {
    $("status").hidden = true;
    if (await decodes) say({ type: "decodes", h264: true });
  };
  socket.onclose = () => {
    $("status").textContent = "The viewer is gone; trying again";
    $("status").hidden = false;
    setTimeout(connect, 500);
  };
  socket.onmessage = ({ data }) => (typeof data === "string" ? hear(JSON.parse(data)) : draw(data));
}

function hear(message) {
  switch (message.type) {
    case "scene":
      scene = message;
      $("problem").hidden = true;
      refusedInput = null;
      $("name").textContent = message.name;
      document.title = `${message.name} - Eosphor`;
      $("s-device").textContent = message.backend;
      $("s-triangles").textContent = message.triangles.toLocaleString("en");
      // A page that comes back keeps what it showed, and so does one that is loaded again in this tab.
      view ??= remembered();
      if (!view || (message["take-camera"] && message.version > 1)) {
        const camera = structuredClone(message.view.camera);
        view = view ? { ...view, camera } : structuredClone(message.view);
        isSettled = false;
      }
      view.frame = Math.min(view.frame, scene.frames - 1);
      showDevices();
      showSettings();
      changed(false);
      break;
    case "error":
      $("problem").textContent = message.text;
      $("problem").hidden = false;
      refusedInput = null;
      break;
    case "refused":
      refuse(message.text);
      break;
    case "command":
      $("command").textContent = message.text;
      // Not every browser lets a page without encryption write to the clipboard; the text stands there to be copied.
      navigator.clipboard?.writeText(message.text).catch(() => {});
      break;
    case "pixel":
      if (focusPixel && message.x === focusPixel[0] && message.y === focusPixel[1]) focusOn(message);
      showValue(message);
      break;
  }
}

/** Says what cannot be, until something newer is shown. */
function refuse(text) {
  $("problem").textContent = text;
  $("problem").hidden = false;
  refusedInput = input;
}

async function draw(data) {
  const headerLength = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, headerLength)));
  let blob = new Blob([new Uint8Array(data, 4 + headerLength)], { type: header.format });
  // A picture at rest may come in pieces, one after the other; what comes in between takes its place.
  const [piece, pieces] = header.piece;
  pieceBlobs = piece === 0 ? [blob] : [...pieceBlobs, blob];
  if (piece + 1 < pieces) return say({ type: "ack", frame: header.frame });
  if (pieces > 1) blob = new Blob(pieceBlobs, { type: header.format });
  pieceBlobs = [];
  let bitmap;
  try {
    bitmap = header.format === "video/h264"
      ? await (decoder ??= new FrameDecoder()).decode(header, new Uint8Array(data, 4 + headerLength))
      : await createImageBitmap(blob);
  } catch {
    // What comes then are JPEGs.
    if (header.format === "video/h264") {
      decodes = Promise.resolve(false);
      say({ type: "decodes", h264: false });
    }
    return say({ type: "ack", frame: header.frame });
  }
  if (lastFrame < header.frame) {
    lastFrame = header.frame;
    shown?.bitmap.close();
    shown = { header, bitmap };
    paint();
    measure(header);
    if (refusedInput !== null && header.input > refusedInput) {
      refusedInput = null;
      $("problem").hidden = true;
    }
    if (header.format === "image/png" && header.input === input) setFile(blob);
  }
  say({ type: "ack", frame: header.frame });
}

function paint() {
  const { header, bitmap } = shown;
  if (canvas.width !== header.full[0] || canvas.height !== header.full[1]) [canvas.width, canvas.height] = header.full;
  ctx.imageSmoothingEnabled = true;
  ctx.imageSmoothingQuality = "high";
  ctx.drawImage(comparing && kept ? kept : bitmap, 0, 0, canvas.width, canvas.height);
}

function measure(header) {
  const now = performance.now();
  measured.frames += 1;
  measured.last = header;
  const at = sentAt.get(header.input);
  if (at !== undefined) {
    measured.latencies.push(now - at);
    if (measured.latencies.length > 100000) measured.latencies.splice(0, 50000);
    $("s-latency").textContent = `${Math.round(now - at)} ms`;
  }
  for (const number of sentAt.keys()) if (number <= header.input) sentAt.delete(number);
  drawn.push(now);
  while (drawn[0] < now - 1000) drawn.shift();
  const ms = header.milliseconds;
  $("s-picture").textContent = `${header.size[0]} x ${header.size[1]}`;
  $("s-samples").textContent = header["at-rest"] ? `${header.samples} of ${header["all-samples"]}` : "moving";
  $("s-render").textContent = `${ms.render.toFixed(1)} ms`;
  $("s-encode").textContent = `${ms.develop.toFixed(1)}, ${ms.encode.toFixed(1)} ms`;
  $("s-rate").textContent = `${drawn.length} in the last second`;
}

// Values of a pixel.
let pointer = null;
function showValue({ x, y, linear, samples, surface }) {
  const place = $("value");
  if (!pointer) return;
  const lines = [`(${x}, ${y})`];
  if (linear) lines[0] += `  ${linear.map((v) => v.toPrecision(4)).join("  ")}  ${samples} samples`;
  if (surface) {
    const named = (number, name) => (name ? `${number} ${name}` : `${number}`);
    lines.push(`object ${named(surface.object, surface["object-name"])}`);
    lines.push(`material ${named(surface.material, surface["material-name"])}`);
    lines.push(`distance ${surface.depth.toPrecision(5)}  normal ${surface.normal.map((v) => v.toFixed(3)).join("  ")}`);
  } else lines.push("nothing is here");
  place.textContent = lines.join("\n");
  place.hidden = false;
  const box = document.querySelector("main").getBoundingClientRect();
  place.style.left = `${Math.max(0, Math.min(pointer.x - box.left + 16, box.width - 300))}px`;
  place.style.top = `${Math.max(0, Math.min(pointer.y - box.top + 16, box.height - 100))}px`;
}

/** The pixel of the picture at a place of the window, or null. */
function pixelAt(event) {
  const box = canvas.getBoundingClientRect();
  const x = Math.floor(((event.clientX - box.left) / box.width) * canvas.width);
  const y = Math.floor(((event.clientY - box.top) / box.height) * canvas.height);
  return x >= 0 && y >= 0 && x < canvas.width && y < canvas.height ? [x, y] : null;
}

/** Makes sharp what is at a pixel; a pin-hole becomes a lens. */
function focusOn({ x, y, surface }) {
  setFocusing(false);
  if (!surface) return refuse("Nothing is there to be sharp.");
  const [width, height] = view.size;
  const tangent = Math.tan((view.camera.fov * Math.PI) / 360);
  const right = ((2 * (x + 0.5)) / width - 1) * tangent;
  const above = ((1 - (2 * (y + 0.5)) / height) * tangent * height) / width;
  // The distance is along the ray; what is sharp is a plane.
  const far = surface.depth / Math.hypot(1, right, above);
  view.camera["focus-distance"] = Math.fround(far);
  if (!(view.camera.aperture > 0)) view.camera.aperture = Math.fround(far * 0.02);
  showSettings();
  changed(false);
}

function setFocusing(isOn) {
  isFocusing = isOn;
  focusPixel = null;
  $("focus-click").setAttribute("aria-pressed", String(isOn));
  canvas.classList.toggle("focusing", isOn);
}

// The pointer and fingers.
const fingers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  if (isFocusing) {
    focusPixel = pixelAt(event);
    if (focusPixel) say({ type: "pixel", x: focusPixel[0], y: focusPixel[1] });
    return;
  }
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  $("value").hidden = true;
});
canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId);
  if (!before) {
    pointer = { x: event.clientX, y: event.clientY };
    const pixel = pixelAt(event);
    if (shown?.header["at-rest"] && pixel) say({ type: "pixel", x: pixel[0], y: pixel[1] });
    return;
  }
  if (!view) return;
  const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
  if (fingers.size === 2) {
    const other = [...fingers.entries()].find(([id]) => id !== event.pointerId)[1];
    const far = Math.hypot(before.x - other.x, before.y - other.y);
    const near = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (far > 10 && near > 10) approach(far / near);
    const step = aimDistance() / canvas.clientHeight / 2;
    move(-dx * step, dy * step, 0);
  } else if (event.buttons & 6 || event.shiftKey) {
    const step = aimDistance() / canvas.clientHeight;
    move(-dx * step, dy * step, 0);
  } else {
    turn((dx / canvas.clientHeight) * Math.PI, (dy / canvas.clientHeight) * Math.PI);
  }
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
});
const lift = (event) => {
  if (fingers.delete(event.pointerId) && fingers.size === 0 && moving) changed(false);
};
canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("pointerleave", () => { pointer = null; $("value").hidden = true; });
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  if (view) approach(Math.exp(Math.max(-100, Math.min(100, event.deltaY)) * 0.002));
}, { passive: false });

// Keys: held ones move the camera with every frame of the screen.
const held = new Set();
const MOVES = {
  w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0],
};
const TURNS = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1], arrowdown: [0, 1] };
let lastStep = 0;
function step(now) {
  if (held.size === 0 || !view) return;
  const seconds = Math.min(0.1, (now - lastStep) / 1000);
  lastStep = now;
  for (const key of held) {
    const by = MOVES[key];
    if (by) move(...by.map((x) => x * scene.radius * 0.5 * seconds));
    if (TURNS[key]) turn(...TURNS[key].map((x) => x * 1.2 * seconds));
    if (key === "+" || key === "=") approach(1 - 0.8 * seconds);
    if (key === "-") approach(1 + 0.8 * seconds);
  }
  requestAnimationFrame(step);
}
canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const key = event.key.toLowerCase();
  if (key === "k" && shown) createImageBitmap(canvas).then((bitmap) => { kept = bitmap; });
  if (key === "c") { comparing = true; if (shown) paint(); }
  if (!(key in MOVES || key in TURNS || "+-=".includes(key))) return;
  event.preventDefault();
  if (held.size === 0) {
    lastStep = performance.now();
    requestAnimationFrame(step);
  }
  held.add(key);
});
canvas.addEventListener("keyup", (event) => {
  const key = event.key.toLowerCase();
  if (key === "c") { comparing = false; if (shown) paint(); }
  if (held.delete(key) && held.size === 0 && moving) changed(false);
});
canvas.addEventListener("blur", () => { held.clear(); if (moving) changed(false); });

// Settings.
const numbers = { samples: "samples", "light-samples": "light-samples", depth: "depth" };
function showSettings() {
  $("fov").value = view.camera.fov;
  $("fov-value").textContent = `${Math.round(view.camera.fov * 10) / 10}°`;
  $("width").value = view.size[0];
  $("height").value = view.size[1];
  for (const [id, key] of Object.entries(numbers)) $(id).value = view[key];
  $("exposure").value = view.exposure;
  $("exposure-value").textContent = view.exposure;
  $("lighting").value = view.lighting;
  $("shadows").value = view.shadows;
  $("show").value = view.show;
  $("aperture").value = view.camera.aperture;
  $("focus").value = view.camera["focus-distance"] ?? "";
  $("time").hidden = scene.frames < 2;
  $("frame").max = scene.frames - 1;
  $("frame").value = view.frame;
  $("frame-value").textContent = `${view.frame} of ${scene.frames}`;
}

/** Fills a choice with names. */
function fill(select, names, chosen) {
  select.replaceChildren(...names.map((name) => new Option(name, name, false, name === chosen)));
}
function showDevices() {
  $("device").hidden = scene.devices.length === 0;
  if (scene.devices.length === 0) return;
  const device = scene.device ?? { backend: scene.devices[0].backend, accel: scene.devices[0].accels[0] };
  fill($("backend"), scene.devices.map((one) => one.backend), device.backend);
  fill($("accel"), scene.devices.find((one) => one.backend === device.backend)?.accels ?? [], device.accel);
}
const whole = (element) => {
  const value = Math.round(Number(element.value));
  return Math.max(Number(element.min), Math.min(Number(element.max), Number.isFinite(value) ? value : Number(element.min)));
};
$("fov").addEventListener("input", () => { view.camera.fov = Number($("fov").value); showSettings(); changed(true); });
$("exposure").addEventListener("input", () => { view.exposure = Number($("exposure").value); showSettings(); changed(true); });
for (const [id, key] of Object.entries(numbers)) {
  $(id).addEventListener("change", () => { view[key] = whole($(id)); showSettings(); changed(false); });
}
for (const [id, k] of [["width", 0], ["height", 1]]) {
  $(id).addEventListener("change", () => { view.size[k] = whole($(id)); showSettings(); changed(false); });
}
const length32 = (element) => Math.fround(Math.max(0, Math.min(1e12, Number(element.value) || 0)));
$("aperture").addEventListener("change", () => { view.camera.aperture = length32($("aperture")); showSettings(); changed(false); });
$("focus").addEventListener("change", () => {
  view.camera["focus-distance"] = length32($("focus")) || scene.view.camera["focus-distance"];
  showSettings();
  changed(false);
});
$("focus-click").addEventListener("click", () => setFocusing(!isFocusing));

// Time.
let playing = 0;
function showFrame(frame, isMoving) {
  view.frame = frame;
  showSettings();
  changed(isMoving);
}
$("frame").addEventListener("input", () => showFrame(Number($("frame").value), true));
$("play").addEventListener("click", () => {
  clearInterval(playing);
  const isOn = !playing;
  playing = isOn ? setInterval(() => showFrame((view.frame + 1) % scene.frames, true), 1000 / Math.min(60, scene.fps)) : 0;
  $("play").setAttribute("aria-pressed", String(isOn));
});

// The device.
function chooseDevice(backend, accel) {
  const accels = scene.devices.find((one) => one.backend === backend)?.accels ?? [];
  say({ type: "device", choice: { backend, accel: accels.includes(accel) ? accel : accels[0] } });
}
$("backend").addEventListener("change", () => chooseDevice($("backend").value, $("accel").value));
$("accel").addEventListener("change", () => chooseDevice($("backend").value, $("accel").value));

for (const id of ["lighting", "shadows", "show"]) {
  $(id).addEventListener("change", () => { view[id] = $(id).value; changed(false); });
}
$("reset").addEventListener("click", () => {
  view.camera = structuredClone(scene.view.camera);
  isSettled = false;
  showSettings();
  changed(false);
});
$("copy").addEventListener("click", () => say({ type: "command" }));
/** Asks the server for a file of this page, and hands it to the browser. */
async function download(path, name) {
  const answer = await fetch(`${path}?page=${scene.page}`).catch(() => null);
  if (!answer?.ok) return refuse(answer ? (await answer.text()).trim() : "The viewer is gone.");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
$("save").addEventListener("click", () => download("/scene.json", "scene.json"));
$("exr").addEventListener("click", () => download("/picture.exr", "picture.exr"));
$("fold").addEventListener("click", () => {
  const isOpen = $("controls").hidden;
  $("controls").hidden = !isOpen;
  $("fold").setAttribute("aria-expanded", String(isOpen));
});

setInterval(() => say({ type: "alive" }), 10000);
connect();

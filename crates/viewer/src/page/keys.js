// Keys: held ones move the camera with every frame of the screen.

import { approach, move, turn } from "./camera.js";
import { changed } from "./changes.js";
import { canvas } from "./elements.js";
import { state } from "./page_state.js";
import { compare, keep } from "./picture.js";

const held = new Set();
const MOVES = {
  w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0],
};
const TURNS = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1], arrowdown: [0, 1] };
let lastStep = 0;
function step(now) {
  if (held.size === 0 || !state.view) return;
  const seconds = Math.min(0.1, (now - lastStep) / 1000);
  lastStep = now;
  for (const key of held) {
    const by = MOVES[key];
    if (by) move(...by.map((x) => x * state.scene.radius * 0.5 * seconds));
    if (TURNS[key]) turn(...TURNS[key].map((x) => x * 1.2 * seconds));
    if (key === "+" || key === "=") approach(1 - 0.8 * seconds);
    if (key === "-") approach(1 + 0.8 * seconds);
  }
  requestAnimationFrame(step);
}
canvas.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const key = event.key.toLowerCase();
  if (key === "k") keep();
  if (key === "c") compare(true);
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
  if (key === "c") compare(false);
  if (held.delete(key) && held.size === 0 && state.moving) changed(false);
});
canvas.addEventListener("blur", () => { held.clear(); if (state.moving) changed(false); });

// The pointer and fingers over the picture, and the wheel.

import { aimDistance, approach, move, turn } from "./camera.js";
import { changed } from "./changes.js";
import { canvas } from "./elements.js";
import { askFocus, isFocusing } from "./focus.js";
import { state } from "./page_state.js";
import { isAtRest, pixelAt } from "./picture.js";
import { hideValue, setPointer } from "./pixel_value.js";
import { say } from "./socket.js";

const fingers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  if (isFocusing()) return askFocus(pixelAt(event));
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  hideValue();
});
canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId);
  if (!before) {
    setPointer({ x: event.clientX, y: event.clientY });
    const pixel = pixelAt(event);
    if (isAtRest() && pixel) say({ type: "pixel", x: pixel[0], y: pixel[1] });
    return;
  }
  if (!state.view) return;
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
  if (fingers.delete(event.pointerId) && fingers.size === 0 && state.moving) changed(false);
};
canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("pointerleave", () => { setPointer(null); hideValue(); });
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  if (state.view) approach(Math.exp(Math.max(-100, Math.min(100, event.deltaY)) * 0.002));
}, { passive: false });

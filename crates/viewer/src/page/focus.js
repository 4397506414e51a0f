// The lens's focus by a click: what is there becomes sharp.

import { changed } from "./changes.js";
import { $, canvas } from "./elements.js";
import { state } from "./page_state.js";
import { refuse } from "./problem.js";
import { showSettings } from "./settings.js";
import { say } from "./socket.js";

/** Waits for a click that says what is to be sharp; the pixel that was clicked. */
let waits = false;
let focusPixel = null;

export const isFocusing = () => waits;

function setFocusing(isOn) {
  waits = isOn;
  focusPixel = null;
  $("focus-click").setAttribute("aria-pressed", String(isOn));
  canvas.classList.toggle("focusing", isOn);
}

/** Asks the server what is at the pixel that was clicked, if it is one. */
export function askFocus(pixel) {
  focusPixel = pixel;
  if (focusPixel) say({ type: "pixel", x: focusPixel[0], y: focusPixel[1] });
}

/** The server says what is at a pixel, perhaps at that one. */
export function focusIfAsked(message) {
  if (focusPixel && message.x === focusPixel[0] && message.y === focusPixel[1]) focusOn(message);
}

/** Makes sharp what is at a pixel; a pin-hole becomes a lens. */
function focusOn({ x, y, surface }) {
  setFocusing(false);
  if (!surface) return refuse("Nothing is there to be sharp.");
  const { view } = state;
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

$("focus-click").addEventListener("click", () => setFocusing(!waits));

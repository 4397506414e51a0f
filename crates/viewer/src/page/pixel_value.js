// The value of the pixel under the pointer, shown beside it.

import { $ } from "./elements.js";

/** Where the pointer is; null where it is not over the picture. */
let pointer = null;

export function setPointer(place) {
  pointer = place;
}

export function hideValue() {
  $("value").hidden = true;
}

export function showValue({ x, y, linear, samples, surface }) {
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

// The picture on the page's canvas, and the one that it is compared with.

import { canvas } from "./elements.js";

const ctx = canvas.getContext("2d", { alpha: false });

/** The last frame: header and bitmap; the picture that K has kept. */
let shown = null;
let kept = null;
let comparing = false;

export function show(header, bitmap) {
  shown?.bitmap.close();
  shown = { header, bitmap };
  paint();
}

export const isAtRest = () => shown?.header["at-rest"];

function paint() {
  const { header, bitmap } = shown;
  if (canvas.width !== header.full[0] || canvas.height !== header.full[1]) [canvas.width, canvas.height] = header.full;
  ctx.imageSmoothingEnabled = true;
  ctx.imageSmoothingQuality = "high";
  ctx.drawImage(comparing && kept ? kept : bitmap, 0, 0, canvas.width, canvas.height);
}

/** Keeps what is shown, to be compared with. */
export function keep() {
  if (shown) createImageBitmap(canvas).then((bitmap) => { kept = bitmap; });
}

/** Shows the kept picture, or no longer. */
export function compare(isOn) {
  comparing = isOn;
  if (shown) paint();
}

/** The pixel of the picture at a place of the window, or null. */
export function pixelAt(event) {
  const box = canvas.getBoundingClientRect();
  const x = Math.floor(((event.clientX - box.left) / box.width) * canvas.width);
  const y = Math.floor(((event.clientY - box.top) / box.height) * canvas.height);
  return x >= 0 && y >= 0 && x < canvas.width && y < canvas.height ? [x, y] : null;
}

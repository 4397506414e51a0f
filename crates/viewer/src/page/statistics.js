// The figures below the settings.

import { $ } from "./elements.js";
import { state } from "./page_state.js";

const drawn = [];
/** Figures for tests: milliseconds from input to picture, and the headers of frames. */
export const measured = { latencies: [], frames: 0, last: null };

export function showSceneFigures(scene) {
  $("s-device").textContent = scene.backend;
  $("s-triangles").textContent = scene.triangles.toLocaleString("en");
}

/** Takes in a frame that has just been drawn. */
export function measure(header) {
  const { sentAt } = state;
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

// The settings of the view, as the controls show and change them; those of time and of the device have files of their own.

import { changed } from "./changes.js";
import { $ } from "./elements.js";
import { state } from "./page_state.js";

/** Settings that path tracing does not read. */
const ofWhitted = ["light-samples", "lighting", "shadows"];
const numbers = { samples: "samples", "light-samples": "light-samples", depth: "depth" };
export function showSettings() {
  const { scene, view } = state;
  $("fov").value = view.camera.fov;
  $("fov-value").textContent = `${Math.round(view.camera.fov * 10) / 10}°`;
  $("width").value = view.size[0];
  $("height").value = view.size[1];
  for (const [id, key] of Object.entries(numbers)) $(id).value = view[key];
  $("exposure").value = view.exposure;
  $("exposure-value").textContent = view.exposure;
  $("tone-curve").value = view["tone-curve"];
  $("lighting").value = view.lighting;
  $("shadows").value = view.shadows;
  for (const id of ofWhitted) $(id).closest("label").hidden = scene.integrator === "path";
  $("show").value = view.show;
  $("aperture").value = view.camera.aperture;
  $("focus").value = view.camera["focus-distance"] ?? "";
  $("time").hidden = scene.frames < 2;
  $("frame").max = scene.frames - 1;
  $("frame").value = view.frame;
  $("frame-value").textContent = `${view.frame} of ${scene.frames}`;
}

const whole = (element) => {
  const value = Math.round(Number(element.value));
  return Math.max(Number(element.min), Math.min(Number(element.max), Number.isFinite(value) ? value : Number(element.min)));
};
$("fov").addEventListener("input", () => {
  state.view.camera.fov = Number($("fov").value);
  showSettings();
  changed(true);
});
$("exposure").addEventListener("input", () => {
  state.view.exposure = Number($("exposure").value);
  showSettings();
  changed(true);
});
for (const [id, key] of Object.entries(numbers)) {
  $(id).addEventListener("change", () => { state.view[key] = whole($(id)); showSettings(); changed(false); });
}
for (const [id, k] of [["width", 0], ["height", 1]]) {
  $(id).addEventListener("change", () => { state.view.size[k] = whole($(id)); showSettings(); changed(false); });
}
for (const id of ["tone-curve", "lighting", "shadows", "show"]) {
  $(id).addEventListener("change", () => { state.view[id] = $(id).value; changed(false); });
}
const length32 = (element) => Math.fround(Math.max(0, Math.min(1e12, Number(element.value) || 0)));
$("aperture").addEventListener("change", () => {
  state.view.camera.aperture = length32($("aperture"));
  showSettings();
  changed(false);
});
$("focus").addEventListener("change", () => {
  state.view.camera["focus-distance"] = length32($("focus")) || state.scene.view.camera["focus-distance"];
  showSettings();
  changed(false);
});
$("reset").addEventListener("click", () => {
  state.view.camera = structuredClone(state.scene.view.camera);
  state.isSettled = false;
  showSettings();
  changed(false);
});
$("fold").addEventListener("click", () => {
  const isOpen = $("controls").hidden;
  $("controls").hidden = !isOpen;
  $("fold").setAttribute("aria-expanded", String(isOpen));
});

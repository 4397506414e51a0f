// The device and the hierarchy, which are chosen for all pages.

import { $ } from "./elements.js";
import { state } from "./page_state.js";
import { say } from "./socket.js";

/** Fills a choice with names. */
function fill(select, names, chosen) {
  select.replaceChildren(...names.map((name) => new Option(name, name, false, name === chosen)));
}

export function showDevices() {
  const { scene } = state;
  $("device").hidden = scene.devices.length === 0;
  if (scene.devices.length === 0) return;
  const device = scene.device ?? { backend: scene.devices[0].backend, accel: scene.devices[0].accels[0] };
  fill($("backend"), scene.devices.map((one) => one.backend), device.backend);
  fill($("accel"), scene.devices.find((one) => one.backend === device.backend)?.accels ?? [], device.accel);
}

function chooseDevice(backend, accel) {
  const accels = state.scene.devices.find((one) => one.backend === backend)?.accels ?? [];
  say({ type: "device", choice: { backend, accel: accels.includes(accel) ? accel : accels[0] } });
}
$("backend").addEventListener("change", () => chooseDevice($("backend").value, $("accel").value));
$("accel").addEventListener("change", () => chooseDevice($("backend").value, $("accel").value));

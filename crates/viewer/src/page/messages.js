// What the server says, frames apart.

import { changed } from "./changes.js";
import { showDevices } from "./device.js";
import { $ } from "./elements.js";
import { showCommand } from "./export.js";
import { focusIfAsked } from "./focus.js";
import { remembered } from "./memory.js";
import { state } from "./page_state.js";
import { showValue } from "./pixel_value.js";
import { hideProblem, refuse, showProblem } from "./problem.js";
import { showSettings } from "./settings.js";
import { showSceneFigures } from "./statistics.js";

export function hear(message) {
  switch (message.type) {
    case "scene":
      takeScene(message);
      break;
    case "error":
      showProblem(message.text);
      break;
    case "refused":
      refuse(message.text);
      break;
    case "command":
      showCommand(message.text);
      break;
    case "pixel":
      focusIfAsked(message);
      showValue(message);
      break;
  }
}

function takeScene(scene) {
  state.scene = scene;
  hideProblem();
  $("name").textContent = scene.name;
  document.title = `${scene.name} - Eosphor`;
  showSceneFigures(scene);
  // A page that comes back keeps what it showed, and so does one that is loaded again in this tab.
  state.view ??= remembered();
  if (!state.view || (scene["take-camera"] && scene.version > 1)) {
    const camera = structuredClone(scene.view.camera);
    state.view = state.view ? { ...state.view, camera } : structuredClone(scene.view);
    state.isSettled = false;
  }
  state.view.frame = Math.min(state.view.frame, scene.frames - 1);
  showDevices();
  showSettings();
  changed(false);
}

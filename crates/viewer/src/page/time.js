// The time of an animation: the slider over its frames, and playing.

import { changed } from "./changes.js";
import { $ } from "./elements.js";
import { state } from "./page_state.js";
import { showSettings } from "./settings.js";

let playing = 0;
function showFrame(frame, isMoving) {
  state.view.frame = frame;
  showSettings();
  changed(isMoving);
}
$("frame").addEventListener("input", () => showFrame(Number($("frame").value), true));
$("play").addEventListener("click", () => {
  clearInterval(playing);
  const isOn = !playing;
  const next = () => showFrame((state.view.frame + 1) % state.scene.frames, true);
  playing = isOn ? setInterval(next, 1000 / Math.min(60, state.scene.fps)) : 0;
  $("play").setAttribute("aria-pressed", String(isOn));
});

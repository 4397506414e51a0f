// What can be taken away: the PNG, the EXR, the scene, the command line.

import { $ } from "./elements.js";
import { state } from "./page_state.js";
import { refuse } from "./problem.js";
import { say } from "./socket.js";

/** The picture at rest, as a file, and where the page has it. */
let fileBlob = null;
let file = null;

export const pictureFile = () => fileBlob;

/** The link has this picture from now on; null where none rests. */
export function setFile(blob) {
  fileBlob = blob;
  if (file) URL.revokeObjectURL(file);
  file = blob ? URL.createObjectURL(blob) : null;
  const link = $("download");
  if (file) link.href = file;
  else link.removeAttribute("href");
  link.setAttribute("aria-disabled", String(!file));
}

export function showCommand(text) {
  $("command").textContent = text;
  // Not every browser lets a page without encryption write to the clipboard; the text stands there to be copied.
  navigator.clipboard?.writeText(text).catch(() => {});
}

/** Asks the server for a file of this page, and hands it to the browser. */
async function download(path, name) {
  const answer = await fetch(`${path}?page=${state.scene.page}`).catch(() => null);
  if (!answer?.ok) return refuse(answer ? (await answer.text()).trim() : "The viewer is gone.");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

$("copy").addEventListener("click", () => say({ type: "command" }));
$("save").addEventListener("click", () => download("/scene.json", "scene.json"));
$("exr").addEventListener("click", () => download("/picture.exr", "picture.exr"));

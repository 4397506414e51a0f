// The problem that is shown over the picture.

import { $ } from "./elements.js";
import { state } from "./page_state.js";

/** What was refused, while it is shown. */
let refusedInput = null;

function show(text) {
  $("problem").textContent = text;
  $("problem").hidden = false;
}

/** Says what is wrong with the scene, until it is repaired. */
export function showProblem(text) {
  show(text);
  refusedInput = null;
}

/** Says what cannot be, until something newer is shown. */
export function refuse(text) {
  show(text);
  refusedInput = state.input;
}

export function hideProblem() {
  $("problem").hidden = true;
  refusedInput = null;
}

/** The frame of an input is shown: what was refused before it has passed. */
export function passRefusal(input) {
  if (refusedInput !== null && input > refusedInput) hideProblem();
}

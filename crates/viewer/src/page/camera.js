// The camera: turns, moves and comes near.

import { changed } from "./changes.js";
import { state } from "./page_state.js";
import { add, cross, dot, length, mul, sub, turned, unit } from "./vectors.js";

const mode = () => document.querySelector("input[name=mode]:checked").value;

/**
 * The point to turn about and to come near to: ahead of the eye, as far as the middle of the scene. Files often look at a point
 * that is only there to give a direction.
 */
function settleAim() {
  if (state.isSettled) return;
  state.isSettled = true;
  const { scene, view } = state;
  const { eye, "look-at": aim } = view.camera;
  const ahead = unit(sub(aim, eye));
  const far = dot(sub(scene.center, eye), ahead);
  if (far > scene.radius * 0.05) view.camera["look-at"] = add(eye, mul(ahead, far));
}

/** Turns about the point looked at (orbit) or about the eye (fly), by angles in radians. */
export function turn(across, down) {
  settleAim();
  const camera = state.view.camera;
  const up = unit(camera.up);
  const isOrbit = mode() === "orbit";
  const arm = isOrbit ? sub(camera.eye, camera["look-at"]) : sub(camera["look-at"], camera.eye);
  let next = turned(arm, up, -across);
  const side = unit(cross(isOrbit ? mul(next, -1) : next, up));
  // Not over the poles.
  const height = Math.asin(Math.max(-1, Math.min(1, dot(unit(next), up))));
  const wanted = Math.max(-1.55, Math.min(1.55, height + (isOrbit ? down : -down)));
  next = turned(next, side, isOrbit ? height - wanted : wanted - height);
  if (isOrbit) camera.eye = add(camera["look-at"], next);
  else camera["look-at"] = add(camera.eye, next);
  changed(true);
}

/** Moves eye and aim: to the right, up, ahead, in world units. */
export function move(right, above, ahead) {
  const camera = state.view.camera;
  const forward = unit(sub(camera["look-at"], camera.eye));
  const side = unit(cross(forward, camera.up));
  const by = add(add(mul(side, right), mul(cross(side, forward), above)), mul(forward, ahead));
  camera.eye = add(camera.eye, by);
  camera["look-at"] = add(camera["look-at"], by);
  changed(true);
}

/** Comes nearer (below 1) or goes away. */
export function approach(factor) {
  settleAim();
  const camera = state.view.camera;
  const arm = sub(camera.eye, camera["look-at"]);
  if (mode() === "fly") return move(0, 0, (1 - factor) * state.scene.radius * 0.5);
  camera.eye = add(camera["look-at"], mul(arm, factor));
  changed(true);
}

export const aimDistance = () => length(sub(state.view.camera["look-at"], state.view.camera.eye));

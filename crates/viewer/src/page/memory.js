// The view of this tab, for when it is loaded again: with the viewer's next address, say.

import { state } from "./page_state.js";

const key = () => `view of ${state.scene.name}`;

export function remember() {
  const { scene, view } = state;
  try { sessionStorage.setItem(key(), JSON.stringify({ of: scene.view, view })); } catch { /* Then it is not kept. */ }
}

export function remembered() {
  try {
    const { of, view } = JSON.parse(sessionStorage.getItem(key()));
    // Of a scene whose file says something else now the file counts.
    return JSON.stringify(of) === JSON.stringify(state.scene.view) ? view : null;
  } catch {
    return null;
  }
}

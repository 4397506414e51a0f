// Changes of the view: each is counted, and sent to the server.

import { pictureFile, setFile } from "./export.js";
import { remember } from "./memory.js";
import { state } from "./page_state.js";
import { say } from "./socket.js";

let restTimer = 0;
let sendPending = false;

/** The view has changed; while it `isMoving`, frames are quick, and after that they get sharp. */
export function changed(isMoving) {
  if (!state.view) return;
  state.moving = isMoving;
  state.input += 1;
  state.sentAt.set(state.input, performance.now());
  if (!sendPending) {
    sendPending = true;
    // One message a frame of the screen; a hidden page draws none.
    const send = () => {
      if (!sendPending) return;
      sendPending = false;
      const { input, moving, view } = state;
      say({ type: "view", input, moving, view });
    };
    requestAnimationFrame(send);
    setTimeout(send, 40);
  }
  clearTimeout(restTimer);
  if (isMoving) restTimer = setTimeout(() => changed(false), 120);
  else remember();
  if (pictureFile()) setFile(null);
}

// The page of `eosphor view`: sends where the camera is and which settings it has, and draws the frames that come back.

import { pictureFile } from "./export.js";
import { begin, draw, offerVideo } from "./frames.js";
import { hear } from "./messages.js";
import { state } from "./page_state.js";
import { connect, isConnected } from "./socket.js";
import { measured } from "./statistics.js";
// These listen to the user.
import "./device.js";
import "./focus.js";
import "./keys.js";
import "./pointer.js";
import "./settings.js";
import "./time.js";

/** For tests. */
window.eosphor = {
  measured,
  get file() { return pictureFile(); },
  get scene() { return state.scene; },
  get view() { return state.view; },
  get connected() { return isConnected(); },
};

connect({ begin, opened: offerVideo, hear, draw });

// The frames that come: put together, decoded, shown, and acknowledged.

import { setFile } from "./export.js";
import { state } from "./page_state.js";
import { show } from "./picture.js";
import { passRefusal } from "./problem.js";
import { say } from "./socket.js";
import { measure } from "./statistics.js";
import { FrameDecoder, canDecode } from "./video.js";

/** Counts connections; what was on its way when one ended is of no use to the next. */
let connection = 0;
/** The number of the last frame; each connection counts anew. */
let lastFrame = 0;
/** The pieces of a picture at rest that have come. */
let pieceBlobs = [];
/** Of moving frames that come as video; whether this browser has one. */
let decoder = null;
let decodes = canDecode();

/** A new connection begins. */
export function begin() {
  connection += 1;
  lastFrame = 0;
  pieceBlobs = [];
  decoder?.close();
  decoder = null;
}

/** Tells the server if frames may come as video. */
export async function offerVideo() {
  if (await decodes) say({ type: "decodes", h264: true });
}

export async function draw(data) {
  const headerLength = new DataView(data).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, headerLength)));
  let blob = new Blob([new Uint8Array(data, 4 + headerLength)], { type: header.format });
  // A picture at rest may come in pieces, one after the other; what comes in between takes its place.
  const [piece, pieces] = header.piece;
  pieceBlobs = piece === 0 ? [blob] : [...pieceBlobs, blob];
  if (piece + 1 < pieces) return say({ type: "ack", frame: header.frame });
  if (pieces > 1) blob = new Blob(pieceBlobs, { type: header.format });
  pieceBlobs = [];
  const ofConnection = connection;
  let bitmap = null;
  try {
    bitmap = header.format === "video/h264"
      ? await (decoder ??= new FrameDecoder()).decode(header, new Uint8Array(data, 4 + headerLength))
      : await createImageBitmap(blob);
  } catch {
    // It is acknowledged below, so that others come.
  }
  if (ofConnection !== connection) return bitmap?.close();
  if (!bitmap && header.format === "video/h264") {
    // What comes then are JPEGs.
    decodes = Promise.resolve(false);
    say({ type: "decodes", h264: false });
  }
  if (bitmap && lastFrame < header.frame) {
    lastFrame = header.frame;
    show(header, bitmap);
    measure(header);
    passRefusal(header.input);
    if (header.format === "image/png" && header.input === state.input) setFile(blob);
  }
  say({ type: "ack", frame: header.frame });
}

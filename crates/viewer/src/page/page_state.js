// What several parts of the page know and change. It stands below all of them; what one part alone knows is in its file.

export const state = {
  /** What the server has on show; its `view` is that of the file. */
  scene: null,
  /** What this page shows. */
  view: null,
  /** Counts what the user did; times of inputs whose frame has not come yet. */
  input: 0,
  sentAt: new Map(),
  moving: false,
  /** Whether the camera looks at a point that is worth turning about. */
  isSettled: false,
};

// The connection to the server. What comes through it is handed to callbacks: they stand above, for most of them answer.

import { $ } from "./elements.js";

let socket = null;

export const isConnected = () => socket?.readyState === 1;

export const say = (message) => {
  if (isConnected()) socket.send(JSON.stringify(message));
};

/**
 * Connects, and anew whenever the connection ends: `begin` is called before each connection and `opened` when it stands, `hear`
 * with each message and `draw` with each frame.
 */
export function connect(callbacks) {
  const { begin, opened, hear, draw } = callbacks;
  begin();
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    $("status").hidden = true;
    opened();
  };
  socket.onclose = () => {
    $("status").textContent = "The viewer is gone; trying again";
    $("status").hidden = false;
    setTimeout(() => connect(callbacks), 500);
  };
  socket.onmessage = ({ data }) => (typeof data === "string" ? hear(JSON.parse(data)) : draw(data));
}

// The server closes connections that are silent.
setInterval(() => say({ type: "alive" }), 10000);

// Opens the WebSocket to the server. In a page saved as a file, shelf.js takes the place of this module.

import { SUBPROTOCOL, enter } from "./credential.js";

/** @returns {Promise<WebSocket | "refused" | "no answer">} */
export async function dial() {
  const found = await enter();
  if (typeof found === "string") return found;
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return new WebSocket(`${scheme}://${location.host}/ws`, [SUBPROTOCOL, found.credential]);
}

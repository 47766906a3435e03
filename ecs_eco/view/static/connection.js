// The WebSocket to the server: passes each message to the listeners for its kind, and reconnects with increasing delays.

import { dial } from "./socket.js";

/** @typedef {import("./protocol.js").Message} Message */
/** @typedef {"connecting" | "open" | "lost" | "ended" | "refused"} Link */

const WAITS = [0.5, 1, 2, 4, 8]; // [s] between attempts; after the last attempt, the run is considered ended

const ENDS = [1000, 1001, 1012]; // close codes of a server that stopped deliberately

export class Connection {
  constructor() {
    /** @type {Map<string, ((message: any) => void)[]>} */
    this.listeners = new Map();
    /** @type {(buffer: ArrayBuffer) => number} decodes a frame and returns its number */
    this.onframe = () => 0;
    /** @type {(link: Link) => void} */
    this.onlink = () => {};
    /** @type {Record<string, number>} */
    this.counts = {};
    /** @type {WebSocket | null} */
    this.socket = null;
    this.attempts = 0;
    this.attempt = 0; // number of the latest attempt
    this.greeted = false;
    this.live = false;
    this.done = false; // whether a live world has reached its end
  }

  /**
   * Calls the listener with each message of this kind.
   * @template {Message["kind"]} K
   * @param {K} kind
   * @param {(message: Extract<Message, {kind: K}>) => void} listener
   */
  on(kind, listener) {
    this.listeners.set(kind, [...(this.listeners.get(kind) ?? []), listener]);
  }

  async open() {
    this.onlink("connecting");
    const attempt = ++this.attempt;
    const socket = await dial();
    if (attempt !== this.attempt) return typeof socket === "string" ? undefined : socket.close(); // a newer attempt has started
    if (socket === "no answer") return this.closed(1006);
    if (socket === "refused") return this.onlink("refused");
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.onlink("open");
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.read(JSON.parse(data)) : this.frame(data));
    socket.onclose = (event) => this.closed(event.code);
  }

  /** @param {Message} message */
  read(message) {
    if (message.kind === "hello") {
      this.greeted = true;
      this.live = message.mode === "live";
      this.attempts = 0;
    }
    if (message.kind === "state") this.done = message.done && this.live;
    this.counts[message.kind] = (this.counts[message.kind] ?? 0) + 1;
    for (const listener of this.listeners.get(message.kind) ?? []) listener(message);
  }

  /** @param {ArrayBuffer} buffer */
  frame(buffer) {
    this.send({ kind: "ack", frame: this.onframe(buffer) });
  }

  /** @param {number} code */
  closed(code) {
    this.socket = null;
    if (this.done || ENDS.includes(code) || this.attempts >= WAITS.length) return this.onlink("ended");
    this.onlink("lost");
    setTimeout(() => this.open(), WAITS[this.attempts++] * 1000);
  }

  /** Tries to connect again after giving up. */
  again() {
    this.attempts = 0;
    this.open();
  }

  /**
   * Sends a message to the server if connected.
   * @param {{kind: string} & Record<string, unknown>} message
   */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}

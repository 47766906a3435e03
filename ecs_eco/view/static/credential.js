// What lets this tab in: the code of its address, which works once, exchanged for a credential that the tab keeps for itself.

export const SUBPROTOCOL = "ecs-eco";
const KEPT = "credential"; // in sessionStorage, which knows origins with their ports, and ends with the tab

/** Takes the code out of the address, so that neither the address bar nor a copy of it shows one. */
export function taken() {
  const words = new URLSearchParams(location.hash.slice(1));
  const code = words.get("code");
  const port = Number(words.get("map")); // of the map of islands that led here
  if (code !== null && Number.isInteger(port) && port > 0 && port < 65536) keepMap(port);
  words.delete("code");
  words.delete("map");
  const rest = [...words].map(([name, value]) => `${name}=${value}`).join("&"); // what a link asks for
  if (code !== null) history.replaceState(history.state, "", location.pathname + (rest && `#${rest}`));
  return code;
}

const MAP = "map";

/** @param {number} port */
function keepMap(port) {
  try {
    sessionStorage.setItem(MAP, String(port));
  } catch {} // as for the credential
}

/** The address of the map of islands that led to this page; null where none did. */
export function cameFrom() {
  try {
    const port = sessionStorage.getItem(MAP);
    return port === null ? null : `http://${location.hostname}:${port}/`;
  } catch {
    return null;
  }
}

/** @param {string} authorization */
async function ask(authorization) {
  try {
    return await fetch("/enter", { method: "POST", headers: { authorization }, cache: "no-store" });
  } catch {
    return null; // nobody listens
  }
}

/** @type {string | null} a code that nobody has answered yet */
let pending = null;
/** @type {string | null} the credential, where the browser lets a page in a frame, as in a notebook, keep nothing */
let inMemory = null;

/** The credential that this tab has. */
function recalled() {
  try {
    return sessionStorage.getItem(KEPT) ?? inMemory;
  } catch {
    return inMemory;
  }
}

/** @param {string} credential */
function keep(credential) {
  inMemory = credential;
  try {
    sessionStorage.setItem(KEPT, credential);
  } catch {
    // it lives as long as this page
  }
}

/**
 * Asks to be let in: with the code of the address, else with the credential that this tab has.
 * @returns {Promise<{credential: string} | "refused" | "no answer">}
 */
export async function enter() {
  pending = taken() ?? pending;
  const kept = recalled();
  const words = [pending === null ? null : `Code ${pending}`, kept === null ? null : `Bearer ${kept}`];
  for (const word of words) {
    if (word === null) continue;
    const answer = await ask(word);
    if (answer === null) return "no answer";
    pending = null;
    if (!answer.ok) continue;
    const { credential } = await answer.json();
    keep(credential);
    return { credential };
  }
  return "refused";
}

// Access to the server: the code in the address works once and is exchanged for a credential that only this tab stores.

export const SUBPROTOCOL = "ecs-eco";
const KEPT = "credential"; // in sessionStorage, which is separate for each origin and port and is deleted with the tab

/** Removes the code from the address, so that neither the address bar nor a copied address reveals it. */
export function taken() {
  const words = new URLSearchParams(location.hash.slice(1));
  const code = words.get("code");
  const port = Number(words.get("map")); // port of the archipelago map that led here
  if (code !== null && Number.isInteger(port) && port > 0 && port < 65536) keepMap(port);
  words.delete("code");
  words.delete("map");
  const rest = [...words].map(([name, value]) => `${name}=${value}`).join("&"); // the parameters of a link
  if (code !== null) history.replaceState(history.state, "", location.pathname + (rest && `#${rest}`));
  return code;
}

const MAP = "map";

/** @param {number} port */
function keepMap(port) {
  try {
    sessionStorage.setItem(MAP, String(port));
  } catch {} // storage may be unavailable, as for the credential
}

/** The address of the archipelago map that led to this page, or null. */
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
    return null; // the server does not respond
  }
}

/** @type {string | null} a code that awaits a response */
let pending = null;
/** @type {string | null} the credential, for browsers that give an embedded page (as in a notebook) no storage */
let inMemory = null;

/** The credential stored in this tab. */
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
    // the credential is lost when this page closes
  }
}

/**
 * Requests access with the code in the address or with this tab's credential.
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

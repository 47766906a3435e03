// Saves files.

import { h } from "./dom.js";

/** @param {string} title */
export const slug = (title) => title.toLowerCase().replace(/[^a-z0-9]+/g, "-");

/** @param {string} name @param {Blob} blob */
export function save(name, blob) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

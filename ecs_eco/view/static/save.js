// Charts as files: the numbers with commas, the picture as PNG.

import { h } from "./dom.js";

/**
 * Buttons that save a chart.
 * @param {string} title
 * @param {() => string} table
 * @param {() => HTMLCanvasElement | undefined} canvas
 */
export function saves(title, table, canvas) {
  const name = title.toLowerCase().replace(/[^a-z0-9]+/g, "-");
  const button = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ does) =>
    h("button", { class: "mini", type: "button", text, title: label, "aria-label": label, onclick: does });
  return [
    button("csv", `Save the numbers: ${title}`, () => save(`${name}.csv`, new Blob([table()], { type: "text/csv" }))),
    button("png", `Save the picture: ${title}`, () => canvas()?.toBlob((blob) => blob && save(`${name}.png`, blob))),
  ];
}

/** @param {string} name @param {Blob} blob */
function save(name, blob) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

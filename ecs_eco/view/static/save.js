// Saves charts as files: the numbers as CSV, the picture as PNG or SVG.

import { h, s } from "./dom.js";
import { css } from "./theme.js";

/**
 * Buttons that save a chart.
 * @param {string} title
 * @param {() => string} table
 * @param {() => HTMLCanvasElement | undefined} canvas
 */
export function saves(title, table, canvas) {
  const name = slug(title);
  const button = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ does) =>
    h("button", { class: "mini", type: "button", text, title: label, "aria-label": label, onclick: does });
  return [
    button("csv", `Save the numbers: ${title}`, () => save(`${name}.csv`, new Blob([table()], { type: "text/csv" }))),
    button("png", `Save the picture: ${title}`, () => canvas()?.toBlob((blob) => blob && save(`${name}.png`, blob))),
  ];
}

/**
 * A button that saves a drawing as SVG.
 * @param {string} title
 * @param {() => SVGElement | null | undefined} drawn
 */
export function drawing(title, drawn) {
  const label = `Save the drawing: ${title}`;
  return h("button", { class: "mini", type: "button", text: "svg", title: label, "aria-label": label, onclick: () => {
    const svg = drawn();
    if (!svg) return;
    const copy = /** @type {SVGElement} */ (svg.cloneNode(true));
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("font-family", "sans-serif");
    copy.setAttribute("font-size", "11");
    copy.prepend(s("rect", { width: "100%", height: "100%", fill: css("--card") }));
    save(`${slug(title)}.svg`, new Blob([copy.outerHTML], { type: "image/svg+xml" }));
  } });
}

/** @param {string} title */
export const slug = (title) => title.toLowerCase().replace(/[^a-z0-9]+/g, "-");

/** @param {string} name @param {Blob} blob */
export function save(name, blob) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

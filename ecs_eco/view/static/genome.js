// The genome of one organism, with genes marked in color and their decoded values.

import { genes as hues } from "./colours.js";
import { h, number } from "./dom.js";
import { isDark } from "./theme.js";

/** @param {import("./protocol.js").Gene} gene */
function decoded({ value, text }) {
  if (typeof value === "number") return number(value);
  return Array.isArray(value) ? value.map((one) => number(one)).join(", ") : (text ?? String(value ?? "–"));
}

/** @param {import("./protocol.js").Genome} genome */
export function drawGenome(genome) {
  const strings = genome.strings ?? (genome.string ? [genome.string] : []);
  const genes = [...genome.genes].sort((a, b) => a.from - b.from);
  /** @type {Map<string, HTMLElement[]>} */
  const marked = new Map();
  const light = (/** @type {string} */ name, /** @type {boolean} */ on) => marked.get(name)?.forEach((mark) => mark.classList.toggle("lit", on));
  const root = h("div", {}, ...strings.map((string, s) => letters(string, genes, marked, s)));
  const list = h("ul", { class: "genes" }, ...genes.map((gene, i) => h("li", {
    style: `--c:${hues(isDark())[i % hues(isDark()).length]}`, title: explain(gene),
    onpointerenter: () => light(gene.name, true), onpointerleave: () => light(gene.name, false),
  }, h("i"), h("span", { text: gene.name }), h("b", { text: decoded(gene) }))));
  root.append(list);
  return root;
}

/** @param {import("./protocol.js").Gene} gene */
function explain(gene) {
  return `${gene.name}${gene.trait && gene.trait !== gene.name ? ` (${gene.trait})` : ""} = ${decoded(gene)}, ${gene.to > gene.from ? `letters ${gene.from + 1}–${gene.to}` : "absent"}${gene.alleles ? `; alleles ${gene.alleles.map((allele) => decoded({ ...gene, value: allele })).join(" and ")}` : ""}`;
}

/**
 * @param {string} string
 * @param {import("./protocol.js").Gene[]} genes sorted by start; `to` is exclusive
 * @param {Map<string, HTMLElement[]>} marked filled in by this function
 * @param {number} s index of the string
 */
function letters(string, genes, marked, s) {
  const root = h("div", { class: "genome", tabindex: 0, role: "group", "aria-label": `Genome of ${string.length} letters` });
  let at = 0;
  genes.forEach((gene, i) => {
    if ((gene.string ?? s) !== s || gene.to === gene.from) return;
    if (gene.from > at) root.append(string.slice(at, gene.from));
    const mark = h("mark", { style: `--c:${hues(isDark())[i % hues(isDark()).length]}`, title: explain(gene), text: string.slice(Math.max(at, gene.from), gene.to) });
    marked.set(gene.name, [...(marked.get(gene.name) ?? []), mark]);
    root.append(mark);
    at = Math.max(at, gene.to);
  });
  if (at < string.length) root.append(string.slice(at));
  return root;
}

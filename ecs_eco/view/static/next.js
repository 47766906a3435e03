// Chooses the next organism to select.

/** @typedef {import("./stage.js").Stage} Stage */

/** The next or previous organism relative to the selected one; animals first. @param {Stage} stage @param {number} by @returns {number | null} */
export function beside(stage, by) {
  const layers = stage.layers.filter((layer) => layer.kind.moves && layer.shown && layer.block.n);
  const layer = (stage.selected !== null && stage.find(stage.selected)?.layer) || layers[0] || stage.layers.find(({ block }) => block.n);
  if (!layer) return null;
  const row = stage.selected === null ? (by > 0 ? -1 : 0) : layer.row(stage.selected);
  return layer.uid((row + by + layer.block.n) % layer.block.n);
}

/** An organism of a kind, other than the selected one. @param {Stage} stage @param {string} name @returns {number | null} */
export function anyOf(stage, name) {
  const layer = stage.layers.find(({ kind, block }) => kind.name === name && block.n);
  return layer ? layer.uid((layer.row(stage.selected ?? 0) + 1) % layer.block.n) : null;
}

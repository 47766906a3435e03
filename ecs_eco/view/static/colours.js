// Palettes: colors for kinds, distinguishable by color-blind people (Okabe and Ito 2008), and ramps for values.

import { DataTexture, LinearFilter, NoColorSpace, RGBAFormat, UnsignedByteType } from "./vendor.js";

const GREY = "#7f888d", UNSET = "#4477aa"; // the default of `color` in world files

/** Gene colors on light and dark backgrounds, distinct from all species colors (Tol 2021, "muted", and its grays). */
const GENES = [["#332288", "#882255", "#117733", "#8a6d1f", "#AA4499", "#555555"], ["#b0a4ff", "#ff9ecb", "#9be3a5", "#DDCC77", "#88e0e8", "#c8c8c8"]];

/** @param {boolean} dark */
export const genes = (dark) => GENES[Number(dark)];

/** Stops of ramps from low to high. Lightness rises steadily, or falls from the middle to both sides. */
const RAMPS = {
  // like viridis, but without the dark end, which would be invisible on a dark background
  sequential: ["#6247a8", "#5558ab", "#3f6fa0", "#2a8093", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"],
  // hues that no species has
  field: ["#f7e9ec", "#efc3cd", "#e5939d", "#d05e6e", "#b02c4d", "#7d0539"], fieldInDark: ["#2b1a20", "#55203a", "#8c2447", "#c43c58", "#ec737c", "#ffb6b4"],
  diverging: ["#b35806", "#e08214", "#fdb863", "#e9e2d6", "#b2c7e0", "#6f9fd0", "#2166ac"],
};

/** @param {string} hex */
export const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** @param {number[]} colour */
const hexOf = (colour) => "#" + colour.map((part) => Math.round(part).toString(16).padStart(2, "0")).join("");

/**
 * Assigns each kind the safe color nearest to its own hue: species before objects, closest pairs first.
 * Kinds with the default color take the remaining ones in order, green first. If there are more kinds than colors, repeated colors are shifted toward the ink color.
 * @param {import("./protocol.js").Kind[]} kinds
 * @param {boolean} dark
 * @param {import("./protocol.js").Swatch[]} palette
 * @returns {string[]}
 */
export function safe(kinds, dark, palette) {
  /** @type {string[]} */
  const found = kinds.map((kind) => (nearGrey(rgb(kind.color)) ? GREY : ""));
  const choice = palette.map((colour) => ({ hex: dark ? colour[1] : colour[0], hue: colour[2] }));
  let offers = [...choice];
  for (const things of [false, true]) {
    const wanting = () => kinds.map((_, k) => k).filter((k) => !found[k] && Boolean(kinds[k].inanimate) === things);
    for (let left = wanting(); left.length; left = wanting()) {
      if (!offers.length) offers = choice.map(({ hex, hue }) => ({ hex: hexOf(rgb(hex).map((part) => Math.floor(0.6 * part + (dark ? 102 : 0) + 0.5))), hue }));
      const pairs = left.filter((k) => kinds[k].color !== UNSET).flatMap((k) => offers.map((offer) => ({ k, offer, gap: gap(hueOf(rgb(kinds[k].color)), offer.hue) })));
      const best = pairs.reduce((a, b) => (b.gap < a.gap ? b : a), { k: left[0], offer: offers[0], gap: pairs.length ? Infinity : 0 });
      found[best.k] = best.offer.hex;
      offers = offers.filter((offer) => offer !== best.offer);
    }
  }
  return found;
}

/** @param {number[]} colour */
const nearGrey = (colour) => Math.max(...colour) - Math.min(...colour) < 24;

/** The hue of a color [degrees]. @param {number[]} colour */
const hueOf = ([r, g, b]) => (Math.atan2(Math.sqrt(3) * (g - b), 2 * r - g - b) * 180) / Math.PI;

/** The angle between two hues [degrees]. @param {number} a @param {number} b */
const gap = (a, b) => Math.abs(((((a - b + 180) % 360) + 360) % 360) - 180);

/**
 * Makes a color from a world file light enough for a dark background or dark enough for a light one.
 * @param {string} hex
 * @param {boolean} dark
 */
export function legible(hex, dark) {
  const colour = rgb(hex);
  const luminance = (0.3 * colour[0] + 0.59 * colour[1] + 0.11 * colour[2]) / 255;
  if (dark && luminance < 0.36) return hexOf(colour.map((part) => part + (255 - part) * (0.36 - luminance) * 1.1));
  if (!dark && luminance > 0.78) return hexOf(colour.map((part) => (part * 0.74) / luminance));
  return hex;
}

/**
 * The ramp of fields: the highest value differs most from the ground.
 * @param {boolean} dark
 * @returns {"field" | "fieldInDark"}
 */
export const fieldRamp = (dark) => (dark ? "fieldInDark" : "field");

/**
 * The color ramp for a quantity by which organisms are colored.
 * @param {string} by
 * @returns {"sequential" | "diverging" | "families" | "kin"}
 */
export const rampOf = (by) => (by === "happiness" ? "diverging" : by === "family" ? "families" : by.startsWith("kin:") ? "kin" : "sequential");

/** @param {ReturnType<typeof rampOf> | ReturnType<typeof fieldRamp>} name */
export const gradient = (name) => {
  const stops = name === "families" ? FAMILIES.map((hex, i) => `${hex} ${(100 * i) / 12}% ${(100 * (i + 1)) / 12}%`) : name === "kin" ? [DESCENDANT, DESCENDANT] : RAMPS[name];
  return `linear-gradient(90deg, ${stops.join(", ")})`;
};

/**
 * A color of a ramp.
 * @param {keyof typeof RAMPS} name
 * @param {number} share 0 … 1
 */
export function rampColour(name, share) {
  const stops = RAMPS[name].map(rgb);
  const level = Math.min(1, Math.max(0, share)) * (stops.length - 1) * 0.99999;
  const i = Math.floor(level);
  return stops[i].map((part, k) => part + (stops[i + 1][k] - part) * (level - i));
}

/** Colors of the twelve largest families (Tol 2021, "light" and "vibrant"): easily distinguished, in no particular order. */
export const FAMILIES = ["#ee7733", "#0077bb", "#33bbee", "#ee3377", "#009988", "#aa4499", "#999933", "#cc3311", "#7d73c9", "#ddaa33", "#44aa66", "#a0765b"];
const DESCENDANT = "#ee3377";

/** The color of a value from 0 to 255. @param {ReturnType<typeof rampOf>} name @param {number} value */
const colourAt = (name, value) => (name === "families" ? rgb(FAMILIES[Math.min(11, Math.floor((value - 0.5) / 21))] ?? GREY) : name === "kin" ? rgb(DESCENDANT) : rampColour(name, value / 255));

/**
 * The clade of an organism as a color and text, or null if it has none.
 * @param {string} by
 * @param {import("./protocol.js").Relative} life
 */
export function cladeOf(by, { uid, clade }) {
  if (!clade) return null;
  const whose = by === `kin:${uid}` ? "its descendants are tracked" : `descends from #${by.slice(4)}`;
  return { fill: hexOf(colourAt(rampOf(by), clade)), words: by === "family" ? `family ${1 + Math.floor((clade - 0.5) / 21)}` : whose };
}

/** The colors of all 256 values, for the shader. @param {ReturnType<typeof rampOf>} name */
export function rampTexture(name) {
  const data = new Uint8Array(256 * 4);
  for (let value = 0; value < 256; value++) data.set([...colourAt(name, value).map(Math.round), 255], 4 * value);
  const texture = new DataTexture(data, 256, 1, RGBAFormat, UnsignedByteType, undefined, undefined, undefined, LinearFilter, LinearFilter);
  texture.colorSpace = NoColorSpace;
  texture.needsUpdate = true;
  return texture;
}

// The dark or light theme, set by the system or chosen on the page.

import { $ } from "./dom.js";

const SUN = '<svg viewBox="0 0 20 20" aria-hidden="true"><circle cx="10" cy="10" r="3.6"/><path d="M10 1.8v2.4M10 15.8v2.4M1.8 10h2.4M15.8 10h2.4M4.2 4.2l1.7 1.7M14.1 14.1l1.7 1.7M4.2 15.8l1.7-1.7M14.1 5.9l1.7-1.7"/></svg>';
const MOON = '<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M16.5 12.2A7 7 0 0 1 7.8 3.5a7 7 0 1 0 8.7 8.7z"/></svg>';

const system = matchMedia("(prefers-color-scheme: dark)");

/** Whether the page is dark now. */
export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : system.matches;
}

/**
 * Calls the listener immediately and whenever the theme changes.
 * @param {(dark: boolean) => void} listener
 */
export function onTheme(listener) {
  const tell = () => {
    document.documentElement.dataset.shade = isDark() ? "dark" : "light";
    $("theme").innerHTML = isDark() ? SUN : MOON;
    listener(isDark());
  };
  system.addEventListener("change", tell);
  document.documentElement.addEventListener("themechange", tell);
  tell();
}

/** Switches the theme and stores the choice if the browser allows it. */
export function switchTheme() {
  const theme = isDark() ? "light" : "dark";
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem("ecs-eco-theme", theme);
  } catch {} // storage may be unavailable in private windows
  document.documentElement.dispatchEvent(new Event("themechange"));
}

/** Restores the previous choice. */
export function recallTheme() {
  try {
    const theme = localStorage.getItem("ecs-eco-theme");
    if (theme) document.documentElement.dataset.theme = theme;
  } catch {}
}

/**
 * The value of a CSS variable.
 * @param {string} name
 */
export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

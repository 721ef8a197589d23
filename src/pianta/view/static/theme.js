// Dark or light: as the system has it, until somebody switches. The page has it as data-theme.

import { byId } from "./elements.js";

const KEY = "pianta theme";
const system = matchMedia("(prefers-color-scheme: dark)");
let chosen = null;

function show() {
  const theme = chosen ?? (system.matches ? "dark" : "light");
  document.documentElement.dataset.theme = theme;
  byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
  // For what no style sheet colours.
  document.dispatchEvent(new Event("themechange"));
}

export function switchTheme() {
  chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try {
    localStorage.setItem(KEY, chosen);
  } catch {
    // Without a store the choice holds until the page is left.
  }
  show();
}

export function startTheme() {
  try {
    const kept = localStorage.getItem(KEY);
    if (kept === "dark" || kept === "light") chosen = kept;
  } catch {
    // As above.
  }
  byId("theme").onclick = switchTheme;
  system.addEventListener("change", show);
  show();
}

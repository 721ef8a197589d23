// Dark or light: as the system has it, until somebody switches.

import { byId } from "./elements.js";

const KEY = "pianta theme";

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function nameButton() {
  byId("theme").textContent = isDark() ? "Light" : "Dark";
}

export function switchTheme() {
  const theme = isDark() ? "light" : "dark";
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // Without a store the choice holds until the page is left.
  }
  nameButton();
}

export function startTheme() {
  let theme = null;
  try {
    theme = localStorage.getItem(KEY);
  } catch {
    // As above.
  }
  if (theme === "dark" || theme === "light") document.documentElement.dataset.theme = theme;
  byId("theme").onclick = switchTheme;
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", nameButton);
  nameButton();
}

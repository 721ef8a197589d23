// Keys that work wherever the focus is.

import { ask, byId } from "./elements.js";
import { Tools } from "./tools.js";

const HELP = `Tab: next part of the page. Arrow keys: move the map. + and -: zoom. 0: whole floor.
/: find a room. In the list: arrow keys, Enter shows a room.
Ctrl+Z: undo. Ctrl+Y or Ctrl+Shift+Z: redo. Ctrl+S: save. Esc: stop drawing, then leave the tool. T: dark or light.
Drawing by keys: choose a tool, go to the map (Tab), move the cross-hair by arrow keys (Shift: one pixel), Enter sets a point or picks, Backspace takes the last point back. Enter twice at the last corner closes an outline. Alt with a click: no snapping.
Tools: `;

function isTyping(target) {
  return target.matches?.("input, textarea, select");
}

export function showHelp() {
  const tools = Object.values(Tools.all).map((tool) => `${tool.key.toUpperCase()} ${tool.text}`).join(", ");
  ask(HELP + tools, [{ text: "Close", value: null, main: true }]);
}

// actions: undo, redo, save, cancel, fit, theme, tool(name), find
export function listenToKeys(actions) {
  document.addEventListener("keydown", (event) => {
    if (byId("dialog").open) return;
    const action = event.ctrlKey || event.metaKey ? withControl(event, actions) : alone(event, actions);
    if (!action) return;
    event.preventDefault();
    action();
  });
}

function withControl(event, actions) {
  const key = event.key.toLowerCase();
  if (key === "s") return actions.save;
  // In a field these keys are of its text.
  if (isTyping(event.target)) return null;
  if (key === "z") return event.shiftKey ? actions.redo : actions.undo;
  return key === "y" ? actions.redo : null;
}

function alone(event, actions) {
  if (event.key === "Escape") {
    return isTyping(event.target) ? () => event.target.blur() : actions.cancel;
  }
  if (isTyping(event.target) || event.altKey) return null;
  if (event.key === "/") return actions.find;
  if (event.key === "?") return showHelp;
  if (event.key === "0") return actions.fit;
  if (event.key === "t") return actions.theme;
  const tool = Object.entries(Tools.all).find(([, each]) => each.key === event.key);
  return tool ? () => actions.tool(tool[0]) : null;
}

// The page of `pianta view`: a gallery of maps, or one of them. The address has the map: #map=0, and may have a room: #map=0&room=3.

import { byId, warn } from "./elements.js";
import { FloorPage } from "./floor_page.js";
import { Collection } from "./collection.js";
import { showGallery } from "./gallery.js";
import { listenToKeys, showHelp } from "./keys.js";
import { openSource } from "./server.js";
import { startTheme, switchTheme } from "./theme.js";

const source = openSource();
let page = null;
let collection = null;
let maps = [];

function placeInAddress() {
  const [, number, room] = /^#map=(\d+)(?:&room=(\d+))?$/.exec(location.hash) ?? [];
  return { number: number === undefined ? null : Number(number), room: room === undefined ? null : Number(room) };
}

async function show() {
  const place = placeInAddress();
  const number = place.number ?? (maps.length === 1 ? maps[0].map : null);
  const one = number !== null;
  collection?.close();
  collection = null;
  // Of results alone, as a floor is loaded by its page.
  const hasKind = one && maps.find((entry) => entry.map === number)?.kind;
  const shown = hasKind ? await source.getMap(number).catch(() => ({})) : {};
  byId("collection").hidden = !shown.items;
  byId("floor-page").hidden = !one || Boolean(shown.items);
  byId("gallery").hidden = one;
  byId("to-gallery").hidden = !one || maps.length < 2;
  byId("history").hidden = !one;
  if (shown.items) {
    page?.close();
    collection = new Collection(byId("collection"), source, shown);
    return;
  }
  if (one) {
    page ??= new FloorPage(source);
    // For the console of the browser, and for tests.
    globalThis.pianta = page;
    await page.open(number);
    if (place.room !== null) page.select(page.shapes?.byId.get(place.room) ?? null, true);
    return;
  }
  page?.close();
  maps = await source.listMaps();
  byId("title").textContent = "pianta";
  byId("summary").textContent = `${maps.length} maps`;
  document.title = "pianta";
  showGallery(maps, source);
}

async function start() {
  startTheme();
  byId("help").onclick = showHelp;
  byId("to-gallery").onclick = () => {
    location.hash = "";
  };
  window.addEventListener("hashchange", () => show().catch((fault) => warn(fault.message)));
  listenToKeys({
    theme: switchTheme,
    undo: () => page?.session && page.undo(),
    redo: () => page?.session && page.redo(),
    save: () => page?.session && page.save(),
    cancel: () => page?.session && page.cancel(),
    fit: () => page?.session && page.fit(),
    tool: (name) => page?.session && page.useTool(name),
    find: () => byId("find").focus(),
  });
  try {
    maps = await source.listMaps();
    await show();
  } catch (fault) {
    byId("floor-page").hidden = false;
    warn(fault.message);
  }
}

start();

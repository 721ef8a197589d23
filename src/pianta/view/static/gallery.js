// The gallery of several maps.

import { byId, element, formatArea } from "./elements.js";
import { drawSmallPart } from "./collection.js";
import { drawSmall } from "./patterns.js";
import { Shapes } from "./shapes.js";

export function showGallery(maps, source) {
  const cards = maps.map((entry) => makeCard(entry));
  byId("gallery").replaceChildren(...cards);
  // A floor is loaded when its card comes into view.
  const watcher = new IntersectionObserver((seen) => {
    for (const { target, isIntersecting } of seen) {
      if (!isIntersecting) continue;
      watcher.unobserve(target);
      drawCard(target, source);
    }
  });
  for (const card of cards) if (!card.classList.contains("problem")) watcher.observe(card);
}

function makeCard(entry) {
  const facts = entry.facts ?? [`${entry.rooms} rooms`, entry.areas?.trust === "unknown" ? null : formatArea(entry.area, entry.areas), entry.type, correctionsOf(entry.corrections)];
  const card = element("a", { className: entry.error ? "card problem" : "card", href: `#map=${entry.map}` },
    element("div", { className: "picture" }), element("h2", {}, entry.name),
    element("p", {}, entry.error ?? facts.filter(Boolean).join(", ")));
  card.dataset.map = entry.map;
  return card;
}

function correctionsOf(count) {
  if (!count) return null;
  return count === 1 ? "1 correction" : `${count} corrections`;
}

async function drawCard(card, source) {
  const picture = card.querySelector(".picture");
  try {
    const number = Number(card.dataset.map);
    const state = await source.getMap(number);
    if (state.items) {
      await drawSmallPart(picture, source, number, 0);
      return;
    }
    const { rooms } = new Shapes(state);
    if (rooms.length) picture.replaceChildren(drawSmall(rooms));
  } catch (fault) {
    picture.textContent = fault.message;
  }
}

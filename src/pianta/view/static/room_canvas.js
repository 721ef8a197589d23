// The rooms on a canvas: hundreds of paths of their own make the browser stop at each zoom, a canvas does not.

import { fillOf } from "./patterns.js";

const OPACITY = 0.62;
// The shape of a partial room is not known, so that less of it covers the map.
const PARTIAL_OPACITY = 0.4;
const BORDER_OPACITY = 0.5;

// A polygon on it has the option `room`.
export const RoomCanvas = L.Canvas.extend({
  // After a change of the theme.
  repaint() {
    if (this._map) this._redraw();
  },

  _draw() {
    this._border = getComputedStyle(this._container).color;
    L.Canvas.prototype._draw.call(this);
  },

  _fillStroke(context, { options: { room } }) {
    context.globalAlpha = room.partial ? PARTIAL_OPACITY : OPACITY;
    context.fillStyle = fillOf(room, context);
    context.fill("evenodd");
    context.globalAlpha = BORDER_OPACITY;
    context.lineWidth = 1;
    context.strokeStyle = this._border;
    context.stroke();
    context.globalAlpha = 1;
  },
});

// The picture of a map below the floor, turned as the map is.

// corners: of the picture's top left, top right and bottom left, [x, y] in metres.
export const Background = L.Layer.extend({
  initialize(url, corners) {
    this._url = url;
    this._corners = corners.map(([x, y]) => L.latLng(y, x));
  },

  onAdd(map) {
    if (!this._image) {
      this._image = L.DomUtil.create("img", "leaflet-image-layer background");
      this._image.alt = "";
      this._image.decoding = "async";
      this._image.onload = () => {
        this._size = [this._image.naturalWidth, this._image.naturalHeight];
        this._image.classList.add("loaded");
        this._place();
        this.fire("load");
      };
      this._image.src = this._url;
    }
    L.DomUtil.addClass(this._image, map.options.zoomAnimation ? "leaflet-zoom-animated" : "leaflet-zoom-hide");
    map.getPane("tilePane").appendChild(this._image);
    this._place();
  },

  onRemove() {
    this._image.remove();
  },

  getEvents() {
    return {
      viewreset: this._place,
      zoom: this._place,
      zoomanim: (event) =>
        this._transform((corner) => this._map._latLngToNewLayerPoint(corner, event.zoom, event.center)),
    };
  },

  setCorners(corners) {
    this._corners = corners.map(([x, y]) => L.latLng(y, x));
    if (this._map) this._place();
  },

  _place() {
    if (this._map) this._transform((corner) => this._map.latLngToLayerPoint(corner));
  },

  // The matrix that takes the pixels of the picture to the three corners.
  _transform(project) {
    if (!this._size) return;
    const [width, height] = this._size;
    const [start, right, down] = this._corners.map(project);
    const numbers = [
      (right.x - start.x) / width, (right.y - start.y) / width,
      (down.x - start.x) / height, (down.y - start.y) / height, start.x, start.y,
    ];
    this._image.style.transform = `matrix(${numbers.join(",")})`;
    this._image.classList.toggle("pixels", Math.hypot(numbers[0], numbers[1]) > 1);
  },

});

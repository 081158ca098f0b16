"use strict";
// The canvas: two views of the same place, beside each other or with a divider between them, and how one moves about in them.
//
// Coordinates: pixels (u, v) of the image's window, and CSS pixels of the canvas. A panel is a rectangle of the canvas with one view;
// all panels have the same `zoom` (CSS pixels a pixel) and `center` (in the window).

const Stage = (() => {
  const MOST_ZOOM = 64;
  /** How close a pointer has to be to the divider to take it (CSS pixels). */
  const GRIP = 12;
  const MOST_PAINTED = 120;

  return class {
    /** `told` is called with the pixel under the cursor whenever it is another one. */
    constructor(canvas, source, told) {
      Object.assign(this, { canvas, source, told });
      this.views = [null, null];
      this.layout = "divider";
      this.divider = 0.5;
      this.style = { stops: 0, tone: "natural" };
      this.cursor = [0, 0];
      this.fitted = true;
      this.zoom = 1;
      this.center = [0, 0];
      this.painted = new Map();
      this.pointers = new Map();
      this.waiting = false;
      new ResizeObserver(() => this.resize()).observe(canvas);
      canvas.addEventListener("pointerdown", (e) => this.down(e));
      canvas.addEventListener("pointermove", (e) => this.move(e));
      for (const name of ["pointerup", "pointercancel", "pointerleave"]) canvas.addEventListener(name, (e) => this.up(e));
      canvas.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
      this.resize();
    }

    get window() {
      return this.source.images[this.views[0]?.image ?? 0]?.window ?? [0, 0, 1, 1];
    }

    resize() {
      const { width, height } = this.canvas.getBoundingClientRect();
      const ratio = window.devicePixelRatio || 1;
      Object.assign(this, { width, height, ratio });
      this.canvas.width = Math.max(1, Math.round(width * ratio));
      this.canvas.height = Math.max(1, Math.round(height * ratio));
      if (this.fitted) this.fit();
      this.draw();
    }

    /** Rectangles of the canvas and the views in them: [x, y, width, height, view]. */
    panels() {
      const { width, height, views } = this;
      if (this.layout === "one") return [[0, 0, width, height, views[0]]];
      if (this.layout === "divider") return [[0, 0, width, height, views[0]], [0, 0, width, height, views[1]]];
      const gap = 4;
      if (width >= height) {
        const half = (width - gap) / 2;
        return [[0, 0, half, height, views[0]], [half + gap, 0, half, height, views[1]]];
      }
      const half = (height - gap) / 2;
      return [[0, 0, width, half, views[0]], [0, half + gap, width, half, views[1]]];
    }

    panelAt(x, y) {
      return this.panels().find(([left, top, width, height]) => x >= left && y >= top && x < left + width && y < top + height);
    }

    toPixel([left, top, width, height], x, y) {
      return [
        (x - left - width / 2) / this.zoom + this.center[0],
        (y - top - height / 2) / this.zoom + this.center[1],
      ];
    }

    toCanvas([left, top, width, height], u, v) {
      return [
        (u - this.center[0]) * this.zoom + left + width / 2,
        (v - this.center[1]) * this.zoom + top + height / 2,
      ];
    }

    // ---- moving about ----

    get leastZoom() {
      const [, , width, height] = this.panels()[0];
      return Math.min(width / this.window[2], height / this.window[3], 1) || 1;
    }

    fit() {
      const [, , width, height] = this.panels()[0];
      this.zoom = Math.min(width / this.window[2], height / this.window[3], MOST_ZOOM) || 1;
      this.center = [this.window[2] / 2, this.window[3] / 2];
      this.fitted = true;
      this.draw();
    }

    /** Zooms so that the pixel stays where it is on the canvas. */
    zoomTo(zoom, [u, v] = this.cursor.map((c) => c + 0.5)) {
      const next = Math.max(0.5 * this.leastZoom, Math.min(MOST_ZOOM, zoom));
      const keep = 1 - this.zoom / next;
      this.center = [this.center[0] + (u - this.center[0]) * keep, this.center[1] + (v - this.center[1]) * keep];
      this.zoom = next;
      this.fitted = false;
      this.hold();
      this.draw();
    }

    pan(dx, dy) {
      this.center = [this.center[0] - dx / this.zoom, this.center[1] - dy / this.zoom];
      this.fitted = false;
      this.hold();
      this.draw();
    }

    /** The image is not lost out of sight. */
    hold() {
      const clamp = (value, most) => Math.max(0, Math.min(most, value));
      this.center = [clamp(this.center[0], this.window[2]), clamp(this.center[1], this.window[3])];
    }

    setDivider(share) {
      this.divider = Math.max(0, Math.min(1, share));
      this.draw();
    }

    setCursor(u, v, follow) {
      const [, , width, height] = this.window;
      const next = [Math.max(0, Math.min(width - 1, Math.floor(u))), Math.max(0, Math.min(height - 1, Math.floor(v)))];
      if (follow) {
        const panel = this.panels()[0];
        const [x, y] = this.toCanvas(panel, next[0] + 0.5, next[1] + 0.5);
        const [left, top, w, h] = panel;
        if (x < left || y < top || x > left + w || y > top + h) this.center = [next[0] + 0.5, next[1] + 0.5];
      }
      if (next[0] === this.cursor[0] && next[1] === this.cursor[1]) return;
      this.cursor = next;
      this.told();
      this.draw();
    }

    // ---- pointers ----

    place(e) {
      const { left, top } = this.canvas.getBoundingClientRect();
      return [e.clientX - left, e.clientY - top];
    }

    onDivider(x) {
      return this.layout === "divider" && Math.abs(x - this.divider * this.width) < GRIP;
    }

    down(e) {
      const [x, y] = this.place(e);
      this.canvas.setPointerCapture(e.pointerId);
      this.pointers.set(e.pointerId, [x, y]);
      this.takesDivider = this.pointers.size === 1 && this.onDivider(x);
      this.pointAt(x, y);
    }

    move(e) {
      const [x, y] = this.place(e);
      const before = this.pointers.get(e.pointerId);
      this.canvas.style.cursor = this.takesDivider || this.onDivider(x) ? "col-resize" : "crosshair";
      if (!before) {
        this.pointAt(x, y);
        return;
      }
      if (this.takesDivider) {
        this.setDivider(x / this.width);
      } else if (this.pointers.size === 1) {
        this.pan(x - before[0], y - before[1]);
      } else {
        const other = [...this.pointers].find(([id]) => id !== e.pointerId)[1];
        const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        const panel = this.panels()[0];
        const middle = this.toPixel(panel, (x + other[0]) / 2, (y + other[1]) / 2);
        this.zoomTo((this.zoom * apart([x, y])) / apart(before), middle);
      }
      this.pointers.set(e.pointerId, [x, y]);
    }

    up(e) {
      this.pointers.delete(e.pointerId);
      if (!this.pointers.size) this.takesDivider = false;
    }

    wheel(e) {
      e.preventDefault();
      const [x, y] = this.place(e);
      const panel = this.panelAt(x, y);
      if (panel) this.zoomTo(this.zoom * 2 ** (-e.deltaY / (e.deltaMode ? 8 : 240)), this.toPixel(panel, x, y));
    }

    pointAt(x, y) {
      const panel = this.panelAt(x, y);
      if (!panel) return;
      const [u, v] = this.toPixel(panel, x, y);
      const [, , width, height] = this.window;
      if (u >= 0 && v >= 0 && u < width && v < height) this.setCursor(u, v);
    }

    // ---- drawing ----

    draw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.drawNow();
      });
    }

    drawNow() {
      const context = this.canvas.getContext("2d");
      context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      context.clearRect(0, 0, this.width, this.height);
      context.imageSmoothingEnabled = false;
      this.panels().forEach((panel, side) => {
        const [left, top, width, height, view] = panel;
        if (!view || !this.source.images[view.image]) return;
        const split = this.divider * this.width;
        const [from, to] = this.layout !== "divider" ? [left, left + width] : side ? [split, width] : [0, split];
        if (to <= from) return;
        context.save();
        context.beginPath();
        context.rect(from, top, to - from, height);
        context.clip();
        this.drawView(context, panel, view);
        this.drawCursor(context, panel);
        context.restore();
      });
      if (this.layout === "divider") this.drawDivider(context);
    }

    drawView(context, panel, view) {
      const [left, top, width, height] = panel;
      const seen = [...this.toPixel(panel, left, top), ...this.toPixel(panel, left + width, top + height)];
      const [, , across, down] = this.source.images[view.image].window;
      for (const patch of this.source.patches(view.image, seen, this.zoom * this.ratio)) {
        const picture = this.paint(view, patch);
        if (!picture) continue;
        // The last row and column of blocks may reach beyond the image.
        const [x0, y0] = this.toCanvas(panel, patch.left, patch.top);
        const w = Math.min(patch.width * patch.scale, across - patch.left);
        const h = Math.min(patch.height * patch.scale, down - patch.top);
        context.drawImage(picture, 0, 0, w / patch.scale, h / patch.scale, x0, y0, w * this.zoom, h * this.zoom);
      }
    }

    /** A patch as a picture; made again only when its samples or its style are others. */
    paint(view, patch) {
      const hasStop = this.source.images[view.image].planes.some(({ name }) => name === Record.plane.stop);
      const arrays = patch.planes(hasStop ? [...view.planes, Record.plane.stop] : view.planes);
      const key = `${view.id}|${patch.key}`;
      const known = this.painted.get(key);
      if (!arrays) return known?.picture;
      const stop = hasStop ? arrays.at(-1)[0] : null;
      const style = JSON.stringify([this.style, view.kind === "value" ? view.legend(this.style) : 0], (k, v) => (k === "ramp" ? 0 : v));
      if (known && known.style === style && known.arrays.every((a, i) => a === arrays[i])) {
        return known.picture;
      }
      const image = new ImageData(patch.width, patch.height);
      view.paint(arrays, image.data, this.style);
      if (stop) {
        for (let i = 0; i < stop.length; i++) if (stop[i] === Record.stop.not_rendered) image.data[4 * i + 3] = 0;
      }
      const picture = known?.picture ?? document.createElement("canvas");
      picture.width = patch.width;
      picture.height = patch.height;
      picture.getContext("2d").putImageData(image, 0, 0);
      this.painted.delete(key);
      this.painted.set(key, { picture, style, arrays });
      if (this.painted.size > MOST_PAINTED) this.painted.delete(this.painted.keys().next().value);
      return picture;
    }

    drawCursor(context, panel) {
      const [u, v] = this.cursor;
      const [x, y] = this.toCanvas(panel, u, v);
      const side = Math.max(this.zoom, 7);
      const shift = (this.zoom - side) / 2;
      for (const [color, width] of [["#000", 3], ["#fff", 1]]) {
        context.strokeStyle = color;
        context.lineWidth = width;
        context.strokeRect(x + shift, y + shift, side, side);
      }
    }

    drawDivider(context) {
      const x = this.divider * this.width;
      for (const [color, width] of [["#000", 4], ["#fff", 2]]) {
        context.strokeStyle = color;
        context.lineWidth = width;
        context.beginPath();
        context.moveTo(x, 0);
        context.lineTo(x, this.height);
        context.stroke();
      }
      context.fillStyle = "#fff";
      context.strokeStyle = "#000";
      context.lineWidth = 1;
      context.beginPath();
      context.arc(x, this.height / 2, 7, 0, 7);
      context.fill();
      context.stroke();
    }
  };
})();

"use strict";
// Where samples come from: planes written into the page, or tiles fetched from the program that serves it.
//
// A source has `images`, each { label, size, window: [x, y, width, height], planes: [{ name, channels, unit, doc, kind }], metadata },
// and gives patches: { key, left, top, scale, width, height, planes(names) }, where sample (i, j) of a patch shows the block of
// `scale` x `scale` pixels at (left + i * scale, top + j * scale) of the window. `planes(names)` is a list of planes, each a list of
// one typed array for each channel, all of the same moment; or null while they are on their way.

const Planes = (() => {
  const bytesOf = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

  const inflate = async (bytes) => {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  /** Undoes what report/page/embedded.rs did: differences of bytes, then the four bytes of samples put together again. */
  const samplesOf = async (base64, kind, channels, count) => {
    const bytes = await inflate(bytesOf(base64));
    for (let i = 1; i < bytes.length; i++) bytes[i] = (bytes[i] + bytes[i - 1]) & 255;
    const all = channels * count;
    const words = new Uint32Array(all);
    for (let i = 0; i < all; i++) {
      words[i] = bytes[i] | (bytes[all + i] << 8) | (bytes[2 * all + i] << 16) | (bytes[3 * all + i] << 24);
    }
    const typed = kind === "u32" ? words : new Float32Array(words.buffer);
    return Array.from({ length: channels }, (_, c) => typed.subarray(c * count, (c + 1) * count));
  };

  /** Planes in the page: one patch an image. */
  class Embedded {
    constructor(images) {
      this.images = images;
      this.live = false;
    }

    async open() {
      for (const image of this.images) {
        const across = Math.ceil(image.window[2] / image.factor);
        const down = Math.ceil(image.window[3] / image.factor);
        const arrays = new Map();
        for (const plane of image.planes) {
          const { name, kind, channels, data, same_as: same } = plane;
          const shared = same == null ? null : this.images[same].patch.planes([name])[0];
          arrays.set(name, shared ?? (await samplesOf(data, kind, channels.length, across * down)));
          delete plane.data;
        }
        if (image.picks) {
          [image.picks] = await samplesOf(image.picks, "u32", 1, across * down);
        }
        image.patch = {
          key: "0",
          left: 0,
          top: 0,
          scale: image.factor,
          width: across,
          height: down,
          planes: (names) => names.map((name) => arrays.get(name)),
        };
      }
    }

    /** The pixel that is shown for the pixel (u, v) of the window: itself, unless the page shows one of several. */
    shown(index, u, v) {
      const { picks, factor, patch, window } = this.images[index];
      if (!picks) return [u, v];
      const column = Math.floor(u / factor);
      const row = Math.floor(v / factor);
      const across = Math.min(factor, window[2] - column * factor);
      const pick = picks[row * patch.width + column];
      return [column * factor + (pick % across), row * factor + Math.floor(pick / across)];
    }

    patches(index) {
      return [this.images[index].patch];
    }

    overview(index) {
      return this.images[index].patch;
    }

    async pixel(index, u, v) {
      const { patch, planes } = this.images[index];
      const at = Math.floor(v / patch.scale) * patch.width + Math.floor(u / patch.scale);
      const values = ({ name }) => patch.planes([name])[0].map((channel) => channel[at]);
      return Object.fromEntries(planes.map((plane) => [plane.name, values(plane)]));
    }
  }

  const TILE = 256;
  /** Tiles that are kept. */
  const MOST_TILES = 400;

  /** Planes of the program that serves the page. `arrived` is called when a tile came. */
  class Served {
    constructor(arrived) {
      this.arrived = arrived;
      this.tiles = new Map();
      this.state = null;
      this.images = [];
      this.live = true;
    }

    async open() {
      await this.poll();
    }

    /** Asks how far the program is; true if something else is to be shown. */
    async poll() {
      const answer = await fetch("state");
      if (!answer.ok) throw new Error(`state: ${answer.status}`);
      const before = this.state;
      this.state = await answer.json();
      const known = this.images.length;
      // Descriptions do not change once they are known.
      this.images = this.state.images.map((image, i) => this.images[i] ?? image).filter((image) => image?.planes);
      return before?.version !== this.state.version || known !== this.images.length;
    }

    shown(index, u, v) {
      return [u, v];
    }

    patch(index, level, x, y) {
      const [, , width, height] = this.images[index].window;
      const side = TILE * 2 ** level;
      return {
        key: `${level},${x},${y}`,
        left: x * side,
        top: y * side,
        scale: 2 ** level,
        width: Math.ceil(Math.min(side, width - x * side) / 2 ** level),
        height: Math.ceil(Math.min(side, height - y * side) / 2 ** level),
        planes: (names) => this.tile(index, level, x, y, names),
      };
    }

    /** Patches for the part of the window from (left, top) to (right, bottom), coarse enough for `zoom` screen pixels a pixel. */
    patches(index, [left, top, right, bottom], zoom) {
      const { levels, window } = this.images[index];
      const level = Math.max(0, Math.min(levels - 1, Math.floor(Math.log2(1 / zoom) + 0.01)));
      const side = TILE * 2 ** level;
      const found = [];
      for (let y = Math.max(0, Math.floor(top / side)); y * side < Math.min(bottom, window[3]); y++) {
        for (let x = Math.max(0, Math.floor(left / side)); x * side < Math.min(right, window[2]); x++) {
          found.push(this.patch(index, level, x, y));
        }
      }
      return found;
    }

    overview(index) {
      return this.patch(index, this.images[index].levels - 1, 0, 0);
    }

    /** Planes of a tile, an older version while the present one is on its way, null before there is any. */
    tile(index, level, x, y, names) {
      const key = `${index}/${level}/${x}/${y}/${names.join("&")}`;
      let tile = this.tiles.get(key);
      if (!tile) {
        tile = { planes: null, version: -1, asked: false };
      }
      // The order of a map is that of insertion: what is used stays at its end.
      this.tiles.delete(key);
      this.tiles.set(key, tile);
      if (this.tiles.size > MOST_TILES) this.tiles.delete(this.tiles.keys().next().value);
      if (tile.version !== this.state.version && !tile.asked) {
        tile.asked = true;
        this.fetch(tile, index, level, x, y, names).finally(() => {
          tile.asked = false;
        });
      }
      return tile.planes;
    }

    async fetch(tile, index, level, x, y, names) {
      const version = this.state.version;
      const query = new URLSearchParams({ image: index, level, x, y });
      for (const name of names) query.append("plane", name);
      const answer = await fetch(`tile?${query}`);
      if (!answer.ok) return;
      const bytes = await answer.arrayBuffer();
      const described = names.map((wanted) => this.images[index].planes.find(({ name }) => name === wanted));
      const count = bytes.byteLength / 4 / described.reduce((sum, { channels }) => sum + channels.length, 0);
      let at = 0;
      tile.planes = described.map(({ channels, kind }) => {
        const Typed = kind === "u32" ? Uint32Array : Float32Array;
        return channels.map(() => new Typed(bytes, 4 * count * at++, count));
      });
      tile.version = version;
      this.arrived();
    }

    async pixel(index, u, v) {
      const [left, top] = this.images[index].window;
      const query = new URLSearchParams({ image: index, x: left + u, y: top + v });
      const answer = await fetch(`pixel?${query}`);
      if (!answer.ok) return null;
      const numbers = { inf: Infinity, "-inf": -Infinity, nan: NaN };
      const { planes } = await answer.json();
      for (const name of Object.keys(planes)) planes[name] = planes[name].map((value) => numbers[value] ?? value);
      return planes;
    }
  }

  return { Embedded, Served };
})();

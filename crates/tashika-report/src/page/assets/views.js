"use strict";
// What can be shown of an image: for each view its planes, how samples become colours, its legend, and numbers in words.

const Views = (() => {
  const { plane: PLANE, key: KEY } = Record;
  /** What is known of planes, by name. */
  const ROWS = new Map(Record.planes.map((row) => [row.name, row]));
  const KEPT = [
    { id: 0, label: "kept: the reference is inside the interval", color: "#56b4e9" },
    { id: 1, label: "broken: the reference is outside", color: "#d55e00" },
    { id: 2, label: "nothing is claimed", color: "#969696" },
    { id: 3, label: "undecidable: the reference is too noisy", color: "#f0e442" },
  ];
  /** What the code of a plane means. */
  const meaning = (plane, id) => ROWS.get(plane).shown.code.find((code) => code.id === id)?.label;

  const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

  // ---- numbers in words ----

  /** The shortest decimal that is this 32-bit number and no other. */
  const shortest = (value) => {
    if (!Number.isFinite(value) || Number.isInteger(value)) return String(value);
    for (let digits = 1; digits < 9; digits++) {
      const text = value.toPrecision(digits);
      if (Math.fround(Number(text)) === value) return String(Number(text));
    }
    return String(Number(value.toPrecision(9)));
  };
  const count = (n) => Math.round(n).toLocaleString("en-US");
  const percent = (share) => {
    const p = 100 * share;
    if (!Number.isFinite(p)) return "infinite";
    return `${p >= 99.95 ? p.toFixed(0) : p >= 9.995 ? p.toFixed(1) : Number(p.toPrecision(3))} %`;
  };
  /** A share as somebody typed it: no more digits than it has. */
  const typed = (share) => `${Number((100 * share).toFixed(6))} %`;
  /** A value with as many digits as its half-width has sense for. */
  const withHalfWidth = (value, half) => {
    if (!(half > 0) || !Number.isFinite(half)) return [Number(value.toPrecision(4)).toString(), null];
    const digits = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(half))));
    return [value.toFixed(digits), half.toFixed(digits)];
  };

  // ---- from radiance to the screen: the formulas of the PNG beside the page (film/tone) ----

  const KNEE = 0.6;
  const shoulder = (l) => (l <= KNEE ? l : KNEE + (1 - KNEE) * (1 - Math.exp(-(l - KNEE) / (1 - KNEE))));
  const STEPS = 8192;
  const ENCODED = Uint8ClampedArray.from({ length: STEPS + 1 }, (_, i) => {
    const v = i / STEPS;
    return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  });
  const encode = (v) => ENCODED[Math.round(Math.min(1, Math.max(0, v)) * STEPS)];

  const natural = (r, g, b, out, at) => {
    const l = luminance(r, g, b);
    if (!(l > 0)) {
      out[at] = out[at + 1] = out[at + 2] = 0;
      return;
    }
    const shown = shoulder(l);
    let [x, y, z] = [r, g, b].map((v) => Math.max(0, v) * (shown / l));
    const largest = Math.max(x, y, z);
    if (largest > 1) {
      const t = (largest - 1) / (largest - shown);
      [x, y, z] = [x, y, z].map((v) => v + (shown - v) * t);
    }
    out[at] = encode(x);
    out[at + 1] = encode(y);
    out[at + 2] = encode(z);
  };

  const times = (rows, [x, y, z]) => rows.map(([r, g, b]) => r * x + g * y + b * z);
  /** From the constant on. */
  const polynomial = (coefficients, x) => coefficients.reduceRight((sum, c) => sum * x + c, 0);
  const along = ({ rational, logarithmic }, x) => {
    if (rational) return polynomial(rational.over, x) / polynomial(rational.under, x);
    const [low, high] = logarithmic.between;
    const stops = Math.min(high, Math.max(low, Math.log2(x)));
    return polynomial(logarithmic.polynomial, (stops - low) / (high - low));
  };

  const published = ({ inset, curve, outset, power }) => (r, g, b, out, at) => {
    const exposed = [r, g, b].map((v) => Math.min(1e6, Math.max(0, v || 0)));
    const shown = times(outset, times(inset, exposed).map((v) => along(curve, v)));
    for (let k = 0; k < 3; k++) out[at + k] = encode(Math.min(1, Math.max(0, shown[k])) ** power);
  };

  const linear = (r, g, b, out, at) => {
    out[at] = encode(r);
    out[at + 1] = encode(g);
    out[at + 2] = encode(b);
  };

  /** By the names of the control. */
  const TONES = { natural, linear };
  for (const [name, tone] of Object.entries(Record.tones)) TONES[name] = published(tone);

  /** Stops that put the log-average of a picture at middle gray (Reinhard et al. 2002, eq. 1). */
  const automaticStops = ([r, g, b], stop) => {
    const lit = [];
    let sum = 0;
    for (let i = 0; i < r.length; i++) {
      const l = luminance(r[i], (g ?? r)[i], (b ?? r)[i]);
      if (stop?.[i] !== Record.stop.not_rendered && l > 0 && Number.isFinite(l)) {
        lit.push(l);
        sum += l;
      }
    }
    const floor = (1e-4 * sum) / lit.length;
    const logs = lit.filter((l) => l >= floor).map(Math.log);
    if (!logs.length) return 0;
    const mean = logs.reduce((a, b) => a + b, 0) / logs.length;
    return Math.max(-64, Math.min(64, (Math.log(0.18) - mean) / Math.LN2));
  };

  // ---- painters: from the channels of some planes to bytes ----

  /** Colours of all views of a page: the scale of errors comes from the program, so that pages and pictures agree. */
  class Palette {
    constructor({ scale, beyond, no_value: noValue }) {
      this.scale = scale.map(rgb);
      this.beyond = rgb(beyond);
      this.noValue = rgb(noValue);
    }

    /** Colour of a value in 0 to 1, of what is beyond, of NaN. */
    color(value) {
      if (Number.isNaN(value)) return this.noValue;
      if (value > 1) return this.beyond;
      return this.scale[Math.round(Math.max(0, value) * (this.scale.length - 1))];
    }
  }

  const each = (value, palette) => (arrays, out) => {
    const n = out.length / 4;
    for (let i = 0; i < n; i++) {
      const [r, g, b] = palette.color(value(arrays, i));
      out[4 * i] = r;
      out[4 * i + 1] = g;
      out[4 * i + 2] = b;
      out[4 * i + 3] = 255;
    }
  };

  const radiance = (palette) => (arrays, out, { stops, tone }) => {
    const [r, g, b] = arrays[0].length >= 3 ? arrays[0] : [arrays[0][0], arrays[0][0], arrays[0][0]];
    const gain = 2 ** stops;
    for (let i = 0; i < r.length; i++) {
      const at = 4 * i;
      const [x, y, z] = [r[i] * gain, g[i] * gain, b[i] * gain];
      if (tone === "false colour") {
        // Six stops below and above middle gray.
        const l = Math.log2(luminance(x, y, z) / 0.18) / 12 + 0.5;
        [out[at], out[at + 1], out[at + 2]] = palette.color(Math.min(l, 1));
      } else {
        TONES[tone](x, y, z, out, at);
      }
      out[at + 3] = 255;
    }
  };

  const codes = (list) => {
    const colors = new Map(list.map(({ id, color }) => [id, rgb(color)]));
    return (value) => (arrays, out) => {
      for (let i = 0; i < out.length / 4; i++) {
        const [r, g, b] = colors.get(value(arrays, i)) ?? [0, 0, 0];
        out[4 * i] = r;
        out[4 * i + 1] = g;
        out[4 * i + 2] = b;
        out[4 * i + 3] = 255;
      }
    };
  };

  // ---- views ----

  const extents = new WeakMap();
  /** Least and largest finite values of an overview's channel, positive ones only if `log`; looked for once. */
  const extent = (channel, log) => {
    if (!channel) return log ? [1, 10] : [0, 1];
    if (!extents.has(channel)) extents.set(channel, search(channel, log));
    return extents.get(channel);
  };
  const search = (channel, log) => {
    let [low, high] = [Infinity, -Infinity];
    for (const v of channel) {
      if (Number.isFinite(v) && (!log || v > 0)) {
        low = Math.min(low, v);
        high = Math.max(high, v);
      }
    }
    if (!(low <= high)) return log ? [1, 10] : [0, 1];
    if (log) {
      const ends = [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high))];
      return ends[0] < ends[1] ? ends : [ends[0], 10 * ends[0]];
    }
    return low < high ? [low, high] : [low, low + 1];
  };

  const controlsChannels = (metadata) => metadata?.[KEY.control] === Record.control.channels;

  /** Size of a radiance that errors are relative to, and the distance of two: by luminance, or by the worst channel. */
  const measure = (metadata) => {
    const byChannels = controlsChannels(metadata);
    return {
      size: (c, i) => {
        const [r, g, b] = c.length >= 3 ? c : [c[0], c[0], c[0]];
        const sizes = [r[i], g[i], b[i]].map(Math.abs);
        return byChannels ? Math.max(...sizes) : Math.abs(luminance(r[i], g[i], b[i]));
      },
      distance: (c, d, i) => {
        const [r, g, b] = c.length >= 3 ? c : [c[0], c[0], c[0]];
        const [s, t, u] = d.length >= 3 ? d : [d[0], d[0], d[0]];
        const off = [r[i] - s[i], g[i] - t[i], b[i] - u[i]];
        return byChannels ? Math.max(...off.map(Math.abs)) : Math.abs(luminance(...off));
      },
    };
  };
  const ratio = (a, b) => (a === 0 ? 0 : a / b);

  /**
   * All views of one image. A view: { id, label, kind, planes, paint(arrays, bytes, style), legend(style) }, where arrays[k] are the
   * channels of planes[k]; pixels that were not rendered are left out by whoever draws.
   */
  const of = (image, index, source, palette, tolerance, prefix) => {
    const planes = new Map(image.planes.map((plane) => [plane.name, plane]));
    const metadata = image.metadata ?? {};
    const { size, distance } = measure(metadata);
    const views = [];
    const add = (id, label, fields) => views.push({ id: `${index}/${id}`, image: index, label: prefix + label, ...fields });
    const ends = (plane, channel, log) => extent(source.overview(index).planes([plane])?.[0][channel], log);
    const ramp = (from, to, beyond) => ({ ramp: palette.scale, from, to, beyond });
    const single = (name) => planes.get(name)?.channels.length === 1;
    const relative = (id, label, plane, channel = 0) => {
      // Where nothing is claimed there is no half-width.
      const claim = plane === PLANE.half_width && single(PLANE.claim) ? [PLANE.claim] : [];
      // Nearly all are below the tolerance, which is the middle of the scale.
      const value = ([c, h, k], i) =>
        k && k[0][i] === Record.claim.none ? NaN : ratio(h[channel][i], size(c, i)) / (2 * tolerance);
      add(id, label, {
        kind: "error",
        planes: [PLANE.radiance, plane, ...claim],
        paint: each(value, palette),
        legend: () => ramp("0 %", typed(2 * tolerance), `> ${typed(2 * tolerance)}`),
      });
    };
    const sequential = (id, label, plane, channel, log) => {
      const place = (v, [low, high]) =>
        log ? Math.log(Math.max(v, low) / low) / Math.log(high / low) : (v - low) / (high - low);
      add(id, label, {
        kind: "value",
        planes: [plane],
        paint: (arrays, out) => {
          const range = ends(plane, channel, log);
          each(([c], i) => Math.min(1, place(c[channel][i], range)), palette)(arrays, out);
        },
        legend: () => {
          const [low, high] = ends(plane, channel, log);
          const told = (v) => (log ? count(v) : shortest(Math.fround(v)));
          return ramp(told(low), `${told(high)} ${planes.get(plane).unit === "1" ? "" : planes.get(plane).unit}`);
        },
      });
    };
    const coded = (id, label, list, names, value) =>
      add(id, label, { kind: "code", planes: names, paint: codes(list)(value), legend: () => ({ codes: list.map(({ label, color }) => [label, color]) }) });
    const isColor = ({ name, channels }) => ROWS.get(name)?.shown === "color" || channels.join("") === "RGB";
    for (const { name, unit } of [...planes.values()].filter(isColor)) {
      if (unit === "1") {
        // Shares of light are what they are, however the picture is exposed.
        add(name, ROWS.get(name)?.label ?? name, {
          kind: "share",
          planes: [name],
          paint: ([[r, g = r, b = r]], out) => {
            for (let i = 0; i < r.length; i++) {
              TONES.linear(r[i], g[i], b[i], out, 4 * i);
              out[4 * i + 3] = 255;
            }
          },
          legend: () => null,
        });
        continue;
      }
      add(name || "estimate", ROWS.get(name)?.label ?? name, {
        kind: "radiance",
        planes: [name],
        paint: radiance(palette),
        legend: ({ tone, stops }) =>
          tone === "false colour"
            ? ramp(shortest(Math.fround(0.18 * 2 ** (-6 - stops))), `${shortest(Math.fround(0.18 * 2 ** (6 - stops)))} W·m⁻²·sr⁻¹`)
            : null,
      });
    }
    if (planes.has(PLANE.radiance) && planes.has(PLANE.reference)) {
      const error = ([c, r], i) => ratio(distance(c, r, i), size(r, i)) / (5 * tolerance);
      add("error", "true relative error", {
        kind: "error",
        planes: [PLANE.radiance, PLANE.reference],
        paint: each(error, palette),
        legend: () => ramp("0 %", typed(5 * tolerance), `> ${typed(5 * tolerance)}`),
      });
      if (single(PLANE.half_width)) {
        const claim = single(PLANE.claim) ? [PLANE.claim] : [];
        // How far the reference may be off itself.
        const own = single(PLANE.reference_half_width) ? [PLANE.reference_half_width] : [];
        coded("kept", "claims kept", KEPT, [PLANE.radiance, PLANE.reference, PLANE.half_width, ...own, ...claim], ([c, r, h, ...more], i) => {
          const q = own.length ? more[0][0][i] : 0;
          const k = claim.length ? more[own.length] : null;
          if (k && k[0][i] === Record.claim.none) return 2;
          const off = distance(c, r, i);
          const allowed = h[0][i] + 2 ** -23 * (size(r, i) + off);
          return off + q <= allowed ? 0 : off - q <= allowed ? 3 : 1;
        });
      }
    }
    // By their rows: half-widths first, then codes and counts; what is left, in the order of the film.
    // Ranks of mattes are for programs; numbers of objects and materials are shown by planes of their own.
    const isMatte = ({ name }) => /^Crypto(Object|Material)\d\d$/.test(name);
    const rest = [...planes.values()].filter((plane) => !isColor(plane) && !isMatte(plane));
    const rank = ({ name }) => {
      const shown = ROWS.get(name)?.shown;
      if (name === PLANE.half_width) return 0;
      return shown?.code ? 1 : shown === "count" ? 2 : 3;
    };
    for (const { name, channels } of rest.sort((a, b) => rank(a) - rank(b))) {
      const { shown, label = name.replaceAll("_", " ") } = ROWS.get(name) ?? { shown: channels.join("") === "XYZ" ? "direction" : "value" };
      if (shown === "direction") {
        add(name, label, {
          kind: "vector",
          planes: [name],
          paint: ([c], out) => {
            for (let i = 0; i < out.length / 4; i++) {
              for (let k = 0; k < 3; k++) out[4 * i + k] = 127.5 * (1 + c[k][i]);
              out[4 * i + 3] = 255;
            }
          },
          legend: () => null,
        });
        continue;
      }
      if (shown === "id") {
        // The number is a hash: its bits are a colour.
        add(name, label, {
          kind: "value",
          planes: [name],
          paint: ([[ids]], out) => {
            for (let i = 0; i < out.length / 4; i++) {
              for (let k = 0; k < 3; k++) out[4 * i + k] = ids[i] ? 48 + ((ids[i] >>> (8 * k)) & 255) * 0.8 : 0;
              out[4 * i + 3] = 255;
            }
          },
          legend: () => null,
        });
        continue;
      }
      channels.forEach((channel, c) => {
        const [id, what] = channels.length > 1 ? [`${name}.${channel}`, `${label}: ${channel}`] : [name, label];
        if (shown.code) coded(id, what, shown.code, [name], ([codes], i) => codes[c][i]);
        else if (shown !== "relative") sequential(id, what, name, c, shown === "count");
        else if (planes.has(PLANE.radiance)) relative(id, what, name, c);
      });
    }
    return views;
  };

  /** A pixel in one line: `0.4213 ± 0.0081 (calibrated, 95 %), 1,212 rays, rule met`. */
  const sentence = (pixel, metadata) => {
    const told = [];
    const stop = pixel[PLANE.stop]?.[0];
    if (stop === Record.stop.not_rendered) return meaning(PLANE.stop, stop);
    const radiance = pixel[PLANE.radiance];
    if (radiance) {
      const [r, g = r, b = r] = radiance;
      const controlled = controlsChannels(metadata) ? Math.max(r, g, b) : luminance(r, g, b);
      const claim = pixel[PLANE.claim]?.[0];
      const [value, half] = withHalfWidth(controlled, claim === Record.claim.none ? 0 : pixel[PLANE.half_width]?.[0]);
      const confidence = metadata?.[KEY.confidence];
      const kind = claim === undefined ? null : meaning(PLANE.claim, claim);
      const sure = [kind, half && confidence ? typed(confidence) : null].filter(Boolean).join(", ");
      told.push(value + (half ? ` ± ${half}` : "") + (sure ? ` (${sure})` : ""));
    }
    if (pixel[PLANE.rays]) told.push(`${count(pixel[PLANE.rays][0])} rays`);
    if (stop !== undefined) told.push(meaning(PLANE.stop, stop));
    if (pixel[PLANE.reference] && radiance) {
      const wrap = (c) => c.map((v) => [v]);
      const { size, distance } = measure(metadata);
      const [image, reference] = [wrap(radiance), wrap(pixel[PLANE.reference])];
      told.push(`off by ${percent(ratio(distance(image, reference, 0), size(reference, 0)))}`);
    }
    return told.join(", ");
  };

  return { Palette, of, sentence, shortest, automaticStops };
})();

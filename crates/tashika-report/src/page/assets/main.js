"use strict";
// Puts the page together: the source, the stage, controls, keys, the line about the pixel under the cursor, and news of a live render.

(async () => {
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("tashika-data").textContent);
  const viewer = byId("viewer");
  if (!viewer) return;

  const fail = (error) => {
    byId("trouble").textContent = `The images cannot be shown: ${error.message}`;
    byId("trouble").hidden = false;
  };
  if (typeof DecompressionStream === "undefined") {
    fail(new Error("this browser has no DecompressionStream; browsers since 2023 have"));
    return;
  }

  const palette = new Views.Palette(data);
  const source = data.served ? new Planes.Served(() => arrived()) : new Planes.Embedded(data.images);
  try {
    await source.open();
  } catch (error) {
    fail(error);
    return;
  }

  const canvas = byId("stage");
  const stage = new Stage(canvas, source, () => tell());
  const controls = {
    left: byId("left"),
    right: byId("right"),
    layout: byId("layout"),
    tone: byId("tone"),
    exposure: byId("exposure"),
  };
  const state = { views: [], automatic: 0, touched: false, told: 0 };

  // ---- views ----

  const option = (value, text) => Object.assign(document.createElement("option"), { value, textContent: text });

  /** Lists all views of all images; what is chosen stays chosen. */
  const list = () => {
    const several = source.images.length > 1;
    const tolerance = data.tolerance ?? source.images[0]?.metadata?.[Record.key.error] ?? 0.02;
    state.views = source.images.flatMap((image, i) =>
      Views.of(image, i, source, palette, tolerance, several ? `${image.label}: ` : ""),
    );
    const { half_width: halfWidth, standard_error: standardError, rays } = Record.plane;
    const wantedRight = ["0/error", `0/${halfWidth}`, `0/${standardError}`, "1/estimate", `0/${rays}`, "0/estimate"];
    for (const [side, wanted] of [["left", ["0/estimate"]], ["right", wantedRight]]) {
      const select = controls[side];
      const before = select.value;
      select.replaceChildren(...state.views.map(({ id, label }) => option(id, label)));
      const found = [before, ...wanted].find((id) => state.views.some((view) => view.id === id));
      if (found) select.value = found;
    }
    choose();
  };

  const choose = () => {
    const chosen = (select) => state.views.find(({ id }) => id === select.value) ?? null;
    stage.views = [chosen(controls.left), chosen(controls.right)];
    stage.layout = controls.layout.value;
    if (stage.fitted) stage.fit();
    legends();
    stage.draw();
  };

  const legend = (view) => {
    const box = document.createElement("div");
    const shown = view?.legend(stage.style);
    if (!view) return box;
    box.append(Object.assign(document.createElement("strong"), { textContent: view.label }));
    const swatch = (color) => {
      const mark = Object.assign(document.createElement("i"), { className: "swatch" });
      mark.style.background = color;
      return mark;
    };
    const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
    if (shown?.ramp) {
      const bar = Object.assign(document.createElement("i"), { className: "ramp" });
      const stops = shown.ramp.filter((_, i) => i % 15 === 0);
      bar.style.background = `linear-gradient(to right, ${stops.map(css).join(",")})`;
      box.append(shown.from, bar, shown.to);
      if (shown.beyond) box.append(swatch(css(palette.beyond)), shown.beyond);
    }
    for (const [name, color] of shown?.codes ?? []) box.append(swatch(color), name);
    return box;
  };
  const legends = () => {
    const shown = stage.layout === "one" ? stage.views.slice(0, 1) : stage.views;
    byId("legends").replaceChildren(...shown.map(legend));
  };

  // ---- exposure ----

  const expose = () => {
    const offset = Number(controls.exposure.value);
    stage.style = { stops: state.automatic + offset, tone: controls.tone.value };
    const stops = stage.style.stops;
    byId("stops").textContent = `${stops >= 0 ? "+" : "−"}${Math.abs(stops).toFixed(2)} stops`;
    legends();
    stage.draw();
  };

  /** Follows the picture until somebody has chosen an exposure. */
  const autoExpose = () => {
    if (state.touched || !source.images.length) return;
    const overview = source.overview(0);
    const has = (name) => source.images[0].planes.some((plane) => plane.name === name);
    const { radiance, stop } = Record.plane;
    const planes = has(radiance) ? overview.planes(has(stop) ? [radiance, stop] : [radiance]) : null;
    if (!planes) return;
    state.automatic = Views.automaticStops(planes[0], planes[1]?.[0]);
    expose();
  };

  // ---- the pixel under the cursor ----

  const tell = async () => {
    const image = stage.views[0]?.image ?? 0;
    if (!source.images[image]) return;
    const turn = ++state.told;
    const [u, v] = source.shown(image, ...stage.cursor);
    let pixel = null;
    try {
      pixel = await source.pixel(image, ...stage.cursor);
    } catch {
      // Whoever served the page has ended; the line says nothing new.
    }
    if (turn !== state.told || !pixel) return;
    const { window, metadata, planes } = source.images[image];
    const [x, y] = [window[0] + u, window[1] + v];
    const line = byId("pixel");
    line.textContent = `pixel ${x},${y}: ${Views.sentence(pixel, metadata)}`;
    Object.assign(line.dataset, { x, y });
    byId("values").replaceChildren(
      ...planes.map(({ name, channels, unit, doc }) => {
        const row = document.createElement("tr");
        const cell = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
        const values = pixel[name].map((value, c) => `${channels.length > 1 ? `${channels[c]} ` : ""}${Views.shortest(value)}`);
        row.dataset.plane = name;
        row.append(cell("th", name || "radiance"), cell("td", values.join("  ")), cell("td", unit === "1" ? "" : unit), cell("td", doc));
        return row;
      }),
    );
  };

  const arrived = () => {
    autoExpose();
    legends();
    stage.draw();
  };

  // ---- controls and keys ----

  for (const name of ["left", "right", "layout"]) controls[name].addEventListener("change", choose);
  for (const [event, control] of [["change", controls.tone], ["input", controls.exposure]]) {
    control.addEventListener(event, () => {
      state.touched = true;
      expose();
    });
  }
  const cycle = (select, step) => {
    const n = select.options.length;
    select.selectedIndex = (select.selectedIndex + step + n) % n;
    select.dispatchEvent(new Event("change"));
  };
  const brighten = (step) => {
    controls.exposure.value = Number(controls.exposure.value) + step;
    controls.exposure.dispatchEvent(new Event("input"));
  };
  const actions = {
    "+": () => stage.zoomTo(stage.zoom * 1.5),
    "=": () => stage.zoomTo(stage.zoom * 1.5),
    "-": () => stage.zoomTo(stage.zoom / 1.5),
    0: () => stage.fit(),
    1: () => stage.zoomTo(1),
    e: () => brighten(0.5),
    E: () => brighten(-0.5),
    t: () => cycle(controls.tone, 1),
    l: () => cycle(controls.left, 1),
    L: () => cycle(controls.left, -1),
    r: () => cycle(controls.right, 1),
    R: () => cycle(controls.right, -1),
    v: () => cycle(controls.layout, 1),
    x: () => {
      [controls.left.value, controls.right.value] = [controls.right.value, controls.left.value];
      choose();
    },
    "[": () => stage.setDivider(stage.divider - 0.05),
    "]": () => stage.setDivider(stage.divider + 0.05),
    "?": () => byId("keys").toggleAttribute("open"),
  };
  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  viewer.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.altKey || e.metaKey || ["SELECT", "INPUT"].includes(e.target.tagName)) return;
    const arrow = e.target === canvas ? ARROWS[e.key] : null;
    if (arrow) {
      const [u, v] = stage.cursor;
      const step = e.shiftKey ? 10 : 1;
      stage.setCursor(u + arrow[0] * step, v + arrow[1] * step, true);
    } else if (actions[e.key]) {
      actions[e.key]();
    } else {
      return;
    }
    e.preventDefault();
  });
  for (const button of viewer.querySelectorAll("button[data-key]")) {
    button.addEventListener("click", () => actions[button.dataset.key]());
  }
  byId("full").addEventListener("click", () => {
    if (document.fullscreenElement) document.exitFullscreen();
    else viewer.requestFullscreen?.();
  });

  const begin = () => {
    const [, , width, height] = stage.window;
    stage.setCursor(width / 2, height / 2);
  };

  list();
  autoExpose();
  expose();
  begin();
  tell();
  viewer.dataset.ready = "true";
  if (!source.live) return;

  // ---- a render that is under way, or a file that is still being read ----

  const POLL_MS = 700;
  const news = () => {
    const { headline, finished, ready } = source.state;
    byId("news").hidden = !headline && ready >= 1;
    byId("news-bar").hidden = Boolean(finished);
    byId("news-text").textContent = finished ? "finished" : (headline?.text ?? "reading the file: what is not read yet looks like what is above it");
    byId("news-bar").value = headline?.of ? headline.pixels / headline.of : ready;
    viewer.dataset.finished = String(Boolean(finished));
    viewer.dataset.version = source.state.version;
  };
  news();
  addEventListener("pagehide", () => navigator.sendBeacon("bye"));
  const watch = async () => {
    const known = source.images.length;
    try {
      if (await source.poll()) {
        if (source.images.length !== known) {
          list();
          begin();
        }
        arrived();
        tell();
      }
      news();
    } catch {
      byId("news").hidden = false;
      byId("news-text").textContent = "The program that showed this has ended; what was fetched stays here.";
      viewer.dataset.ended = "true";
      return;
    }
    setTimeout(watch, POLL_MS);
  };
  setTimeout(watch, POLL_MS);
})();

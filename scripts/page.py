"""The pages in a browser: they show the data of the files, and all their controls work.

Usage: page.py PROGRAM FOLDER

Needs the packages playwright, OpenEXR and pillow, and Chromium (CHROMIUM names it; else the first
of the usual names). Screenshots go to FOLDER, to be looked at after a change of the pages.
"""

import base64
import contextlib
import io
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys

import OpenEXR
from PIL import Image
from playwright.sync_api import sync_playwright

PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
FOLDER = pathlib.Path(sys.argv[2]).resolve()
SIZE = [64, 36]
CROP = [10, 6, 48, 27]


def run(line, folder=FOLDER):
    done = subprocess.run([PROGRAM, *line.split()], cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 4), f"{line}: {done.returncode}\n{done.stderr}"
    return done.stdout


def chromium():
    names = [os.environ.get("CHROMIUM"), "chromium", "chromium-browser", "google-chrome"]
    found = next((path for path in (name and shutil.which(name) for name in names) if path), None)
    assert found, "Chromium is not installed, and CHROMIUM does not name it"
    return found


def channels(path):
    """Arrays by channel name, and the corner of the data window."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        window = file.header()["dataWindow"]
        return {name: channel.pixels for name, channel in file.channels().items()}, [int(v) for v in window[0]]


class Opened:
    """A page, with everything that went wrong in it."""

    def __init__(self, browser, address, width=1280, height=900, **options):
        self.page = browser.new_page(viewport={"width": width, "height": height}, **options)
        self.troubles, self.requests = [], []
        self.page.on("console", self.said)
        self.page.on("pageerror", lambda e: self.troubles.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.goto(address)
        self.page.wait_for_selector("#viewer[data-ready=true]", timeout=60_000)

    def said(self, message):
        # Reading the canvas, in these checks alone, causes this warning.
        if message.type in ("error", "warning") and "willReadFrequently" not in message.text:
            self.troubles.append(message.text)

    def close(self):
        assert not self.troubles, self.troubles
        self.page.close()

    def shot(self, name):
        self.page.wait_for_timeout(300)
        self.page.screenshot(path=FOLDER / f"{name}.png", full_page=True)

    def top(self, selector):
        return self.page.locator(selector).bounding_box()["y"]

    def value(self, script, *values):
        return self.page.evaluate(script, *values)

    def at(self, x, y):
        """Colour of the canvas at shares of its width and height."""
        self.page.wait_for_timeout(120)
        return self.value(
            """([x, y]) => { const c = document.getElementById('stage');
            return [...c.getContext('2d').getImageData(c.width * x, c.height * y, 1, 1).data] }""",
            [x, y],
        )

    def brightness(self):
        self.page.wait_for_timeout(120)
        return self.value(
            """() => { const c = document.getElementById('stage'); let sum = 0;
            const d = c.getContext('2d').getImageData(0, 0, c.width / 2, c.height).data;
            for (let i = 0; i < d.length; i += 4) sum += d[i] + d[i + 1] + d[i + 2];
            return sum / d.length }"""
        )

    def key(self, *keys):
        self.page.focus("#stage")
        for key in keys:
            self.page.keyboard.press(key)

    def cursor(self):
        self.page.wait_for_timeout(60)
        return [int(v) for v in self.value("() => [pixel.dataset.x, pixel.dataset.y]")]

    def go(self, x, y):
        """Moves the cursor by keys alone."""
        for _ in range(400):
            at = self.cursor()
            if at == [x, y]:
                return
            axis = 0 if at[0] != x else 1
            off = [x, y][axis] - at[axis]
            arrow = [["ArrowLeft", "ArrowRight"], ["ArrowUp", "ArrowDown"]][axis][off > 0]
            self.key(f"Shift+{arrow}" if abs(off) >= 10 else arrow)
        raise AssertionError(f"the cursor stays at {self.cursor()}, not {x},{y}")

    def line(self):
        return self.page.text_content("#pixel")

    def values(self):
        """All values that the page shows of the pixel, by plane."""
        rows = self.value(
            "() => [...document.querySelectorAll('#values tr')].map(r => [r.dataset.plane, r.cells[1].textContent])"
        )
        number = lambda word: {"Infinity": float("inf")}.get(word) or float(word)
        return {plane: [number(part.split(" ")[-1]) for part in text.split("  ")] for plane, text in rows}

    def choose(self, side, label):
        self.page.select_option(f"#{side}", label=label)


def single(value):
    return struct.unpack("f", struct.pack("f", value))[0]


def check_values(opened, path, pixels, planes):
    """The page shows the values of the file, to the last bit."""
    found, (left, top) = channels(path)
    for x, y in pixels:
        opened.go(x, y)
        told = opened.values()
        for plane, names in planes.items():
            stored = [float(found[name][y - top, x - left]) for name in names]
            assert [single(v) for v in told[plane]] == stored, f"{x},{y} {plane}: {told[plane]} is not {stored}"


PLANES = {
    "": ["R", "G", "B"],
    "half_width": ["half_width.Y"],
    "claim": ["claim.id"],
    "stop": ["stop.id"],
    "pairs": ["pairs.n"],
    "rays": ["rays.n"],
}


def dozen(x, y, width, height):
    corners = [(x, y), (x + width - 1, y), (x, y + height - 1), (x + width - 1, y + height - 1)]
    return corners + [(x + (7 * i + 3) * 5 % width, y + (11 * i + 2) * 3 % height) for i in range(8)]


def rendered_page(browser):
    crop = ",".join(map(str, CROP))
    run(f"render builtin:tiny --truth vpl --vpls 300 --gather 2 --size {SIZE[0]}x{SIZE[1]} --crop {crop} --error 5% --max-pairs 100k -o tiny.exr --json tiny.json")
    path = FOLDER / "tiny.html"
    opened = Opened(browser, path.as_uri())
    same_as_the_picture(opened, "tiny", "image")
    check_values(opened, FOLDER / "tiny.exr", dozen(*CROP), PLANES)

    # The sentence: value and half-width with significant digits, claim, confidence, cost, reason.
    found, (left, top) = channels(FOLDER / "tiny.exr")
    claims = found["claim.id"]
    spots = [(x + left, y + top) for y in range(CROP[3]) for x in range(CROP[2]) if claims[y, x] == 3]
    assert spots, "no pixel claims a calibrated interval"
    x, y = spots[len(spots) // 2]
    opened.go(x, y)
    row, column = y - top, x - left
    luminance = sum(w * float(found[c][row, column]) for w, c in zip((0.2126, 0.7152, 0.0722), "RGB"))
    half = float(found["half_width.Y"][row, column])
    digits = next(d for d in range(12) if round(half * 10**d) >= 10)
    expected = (
        f"pixel {x},{y}: {luminance:.{digits}f} ± {half:.{digits}f} (calibrated, 95 %), "
        f"{int(found['rays.n'][row, column]):,} rays, rule met"
    )
    assert opened.line() == expected, f"{opened.line()!r} is not {expected!r}"

    # The divider, by keys and by dragging.
    opened.choose("left", "claim")
    opened.choose("right", "image")
    opened.key(*["]"] * 20)
    over_left = opened.at(0.4, 0.5)
    opened.key(*["["] * 20)
    over_right = opened.at(0.4, 0.5)
    assert over_left != over_right, "the divider does not move"
    box = opened.page.locator("#stage").bounding_box()
    middle = box["y"] + box["height"] / 2
    opened.page.mouse.move(box["x"] + 2, middle)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + 0.7 * box["width"], middle, steps=5)
    opened.page.mouse.up()
    assert opened.at(0.4, 0.5) == over_left, "the divider cannot be dragged"
    opened.page.mouse.move(5, 5)

    # Exposure, tones, layouts, zoom, all by keys.
    opened.choose("left", "image")
    opened.key(*["]"] * 10)
    before = opened.brightness()
    opened.key("e", "e", "e")
    assert opened.brightness() > 1.1 * before, "brighter is not brighter"
    assert "stops" in opened.page.text_content("#stops")
    opened.key(*["t"] * 5)
    assert opened.page.input_value("#tone") == "false colour"
    opened.key("t", *["E"] * 3)
    for layout in ("beside", "one", "divider"):
        opened.key("v")
        assert opened.page.input_value("#layout") == layout
    opened.key("l")
    assert opened.page.input_value("#left") != "0/estimate"
    opened.key("L", "+", "+", "+", "0", "x", "x", "?")
    assert opened.page.locator("#keys").get_attribute("open") is not None
    assert abs(opened.brightness() - before) < 2, "what was changed is changed back"
    assert all(url.startswith(("file:", "data:", "blob:")) for url in opened.requests), opened.requests
    opened.shot("render-wide")
    opened.close()

    narrow = Opened(browser, path.as_uri(), 390, 844, color_scheme="dark", has_touch=True, is_mobile=True)
    wider = narrow.value("() => document.documentElement.scrollWidth - innerWidth")
    assert wider <= 0, f"a phone has to scroll sideways by {wider}"
    assert narrow.top("#stage") < narrow.top(".bar"), "the controls come before the picture"
    narrow.shot("render-narrow-dark")
    narrow.close()
    wide = Opened(browser, path.as_uri())
    assert wide.top(".bar") < wide.top("#stage")
    wide.close()
    still_page(browser, path)


def still_page(browser, path):
    """Without scripts the page has its picture, the one beside it first, and no dead control."""
    context = browser.new_context(java_script_enabled=False, viewport={"width": 400, "height": 800})
    page = context.new_page()
    page.goto(path.as_uri())
    picture = page.locator("#still")
    box = picture.bounding_box()
    assert picture.is_visible() and box["y"] + box["height"] < 800, "the picture is not what one sees first"
    assert abs(box["width"] - (400 - 2 * box["x"])) < 1, box
    for hidden in (".bar", "#stage", "#keys"):
        assert not page.locator(hidden).is_visible(), f"{hidden} does not work without scripts"
    held = page.get_attribute("#still", "src").removeprefix("data:image/png;base64,")
    shown, beside = (Image.open(f) for f in (io.BytesIO(base64.b64decode(held)), path.with_suffix(".png")))
    assert shown.size == beside.size and shown.tobytes() == beside.tobytes(), "it is not the picture beside the page"
    page.click("#words summary")
    assert page.locator("#words dd").first.is_visible()
    page.screenshot(path=FOLDER / "still.png", full_page=True)
    context.close()


def picture_page(browser):
    """The page of an audited picture opens on the picture."""
    crop = ",".join(map(str, CROP))
    run(f"render builtin:tiny --vpls 20k --passes 3 --size {SIZE[0]}x{SIZE[1]} --crop {crop} -o picture.exr --json picture.json")
    opened = Opened(browser, (FOLDER / "picture.html").as_uri())
    assert opened.page.input_value("#left") == "0/estimate"
    same_as_the_picture(opened, "picture", "image")
    assert "of the pixels are within 10 %" in opened.page.text_content("body")
    opened.shot("picture")
    opened.close()


def same_as_the_picture(opened, name, view):
    """The page shows radiance as the PNG beside it does: the same exposure, the same colours."""
    stops = json.loads((FOLDER / f"{name}.json").read_text())["exposure_stops"]
    told = opened.page.text_content("#stops").replace("−", "-")
    assert abs(float(told.split()[0]) - stops) < 0.006, f"{told} is not {stops}"
    opened.choose("right", view)
    picture = Image.open(FOLDER / f"{name}.png").convert("RGB")
    assert picture.size == tuple(CROP[2:])
    canvas = opened.page.locator("#stage").bounding_box()
    # The image fits the canvas by its height and stands in its middle.
    zoom = canvas["height"] / CROP[3]
    for u, v in [(3, 4), (12, 9), (20, 20), (25, 2), (40, 13), (45, 25)]:
        place = 0.5 + (u + 0.5 - CROP[2] / 2) * zoom / canvas["width"], (v + 0.5) / CROP[3]
        shown, expected = opened.at(*place)[:3], picture.getpixel((u, v))
        assert all(abs(a - b) <= 1 for a, b in zip(shown, expected)), f"{u},{v}: {shown} is not {expected}"


def toned_page(browser):
    """Each tone mapping is that of the PNG, and the page begins with the requested one."""
    crop = ",".join(map(str, CROP))
    for tone in ("linear", "filmic", "aces", "agx"):
        run(f"render builtin:tiny --truth vpl --vpls 300 --gather 2 --size {SIZE[0]}x{SIZE[1]} --crop {crop} --error 5% --max-pairs 100k "
            f"--tonemap {tone} -o {tone}.exr --json {tone}.json")
        assert (FOLDER / f"{tone}.exr").read_bytes() == (FOLDER / "tiny.exr").read_bytes(), "a picture changed the image"
        opened = Opened(browser, (FOLDER / f"{tone}.html").as_uri())
        assert opened.page.input_value("#tone") == tone
        same_as_the_picture(opened, tone, "image")
        opened.close()


def large_page(browser):
    """On the page of a large image, the shown pixels are pixels of the file."""
    run("render builtin:tiny --truth vpl --vpls 30 --gather 1 --size 1000x600 --error 20% --max-pairs 100k -o large.exr -q")
    page = FOLDER / "large.html"
    assert page.stat().st_size < 8e6, f"a page of {page.stat().st_size} bytes"
    opened = Opened(browser, page.as_uri())
    found, _ = channels(FOLDER / "large.exr")
    for _ in range(5):
        opened.key("Shift+ArrowRight", "Shift+ArrowDown", "ArrowRight")
        x, y = opened.cursor()
        told = opened.values()
        assert [single(v) for v in told[""]] == [float(found[c][y, x]) for c in "RGB"], f"{x},{y}"
    assert "least certain" in opened.page.text_content("#viewer")
    opened.close()


def compared_page(browser):
    run("render builtin:tiny --truth vpl --vpls 300 --gather 2 --size 64x36 --method exact -o exact.exr -q")
    run("render builtin:tiny --truth vpl --vpls 300 --gather 2 --size 64x36 --error 5% --max-pairs 100k -o ours.exr -q")
    run("compare ours.exr exact.exr --error 2% --html compare.html -q --json compare.json")
    opened = Opened(browser, (FOLDER / "compare.html").as_uri())
    assert "The tolerance of 2 % is what was asked for." in opened.page.text_content("header")
    check_values(opened, FOLDER / "exact.exr", [(3, 5), (40, 20)], {"reference": ["R", "G", "B"]})
    worst = json.loads((FOLDER / "compare.json").read_text())
    opened.go(*worst["worst_at"])
    told = float(opened.line().split("off by ")[1].removesuffix(" %")) / 100
    assert abs(told - worst["worst"]) < 0.01 * worst["worst"], f"{told} is not {worst['worst']}"
    assert opened.page.input_value("#right") == "0/error", "the true error is what one sees first"
    opened.key("v")
    opened.shot("compare-wide")
    opened.close()


def experiment_page(browser):
    run("experiment iwasaki2019 builtin:tiny --size 48x27 --vpls 300 --gather 4 --methods mdlc,iwasaki2019,tashika --out seed -q")
    opened = Opened(browser, (FOLDER / "seed/index.html").as_uri())
    views = opened.value("() => [...document.querySelectorAll('#left option')].map(o => o.textContent)")
    for method in ("mdlc", "iwasaki2019", "tashika"):
        assert f"{method}: image" in views and f"{method}: true relative error" in views, views
    check_values(opened, FOLDER / "seed/mdlc.exr", [(30, 9)], {"": ["R", "G", "B"]})
    for name in ("table.csv", "table.json", "table.md", "quality-and-cost.svg", "quality-and-cost.csv"):
        assert (FOLDER / "seed" / name).stat().st_size > 100, name
    opened.shot("experiment-wide")
    opened.close()
    run("coverage builtin:tiny --size 48x27 --vpls 300 --gather 4 --methods mdlc,tashika --error 2%,5% --confidence 95% "
        "--pixels 60 --html coverage.html --csv coverage.csv -q")
    page = browser.new_page()
    page.goto((FOLDER / "coverage.html").as_uri())
    assert page.locator(".plots svg").count() >= 3
    assert "mdlc" in page.text_content("table")
    page.screenshot(path=FOLDER / "coverage-wide.png", full_page=True)
    page.close()


@contextlib.contextmanager
def started(line):
    """The running program; it is ended if it has not ended by itself."""
    process = subprocess.Popen([PROGRAM, *line.split()], cwd=FOLDER, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def viewed_page(browser):
    """A file and its reference, served tile by tile."""
    with started("view ours.exr exact.exr --no-browser") as program:
        address = next(word for word in program.stdout.readline().split() if word.startswith("http"))
        opened = Opened(browser, address)
        opened.page.wait_for_selector("#news", state="hidden")
        assert opened.page.input_value("#right") == "0/error", "the true error is what one sees first"
        check_values(opened, FOLDER / "ours.exr", dozen(0, 0, 64, 36), PLANES | {"normal": [f"normal.{c}" for c in "XYZ"]})
        check_values(opened, FOLDER / "exact.exr", [(3, 5), (40, 20)], {"reference": ["R", "G", "B"]})
        # The canvas shows the same colours as the page that holds its samples.
        still = Opened(browser, (FOLDER / "compare.html").as_uri())
        for page in (opened, still):
            page.choose("right", "claims kept")
            page.go(32, 18)
        places = [(x, y) for x in (0.3, 0.45, 0.62, 0.7) for y in (0.2, 0.5, 0.8)]
        assert [opened.at(*p) for p in places] == [still.at(*p) for p in places]
        still.close()
        opened.shot("view-wide")
        foreign = [url for url in opened.requests if not url.startswith((address, "blob:", "data:"))]
        assert not foreign, foreign
        opened.page.goto("about:blank")
        opened.close()


RENDER = "render builtin:tiny --truth vpl --vpls 2000 --gather 6 --size 240x135 --error 1% --serve --no-browser --log json --threads 1"


def address_of(program):
    for line in program.stderr:
        told = json.loads(line)
        if told["event"] == "note" and "watched at" in told["what"]:
            return told["what"].split()[-1]
    raise AssertionError("no address was told")


def live_page(browser):
    """A render that is watched: tiles appear, claims are shown, and the end equals the file."""
    with started(f"{RENDER} -o live.exr") as program:
        opened = Opened(browser, address_of(program))
        opened.page.wait_for_selector("#left option", state="attached", timeout=60_000)
        opened.page.wait_for_function("() => /with a claim/.test(document.getElementById('news-text').textContent)")
        assert opened.page.get_attribute("#viewer", "data-finished") == "false", "it was over before it was seen"
        opened.shot("live-midway")
        opened.page.wait_for_selector("#viewer[data-finished=true]", timeout=300_000)
        opened.page.wait_for_timeout(1500)
        opened.choose("right", "relative half-width")
        check_values(opened, FOLDER / "live.exr", dozen(110, 60, 20, 20), PLANES)
        opened.shot("live-end")
        still = Opened(browser, (FOLDER / "live.html").as_uri())
        # Not the image itself: the exposure is found from a smaller one here.
        for page in (opened, still):
            page.choose("left", "claim")
            page.go(120, 66)
        places = [(x, y) for x in (0.3, 0.45, 0.62, 0.7) for y in (0.2, 0.5, 0.8)]
        assert [opened.at(*p) for p in places] == [still.at(*p) for p in places], "the end is not what was written"
        still.close()
        assert program.poll() is None, "it went before the page was closed"
        opened.page.goto("about:blank")
        opened.close()
        assert program.wait(20) == 0, "it stays though nobody watches"
    # Closing the page does not stop the render.
    with started(f"{RENDER} -o closed.exr") as program:
        page = browser.new_page()
        page.goto(address_of(program))
        page.wait_for_selector("#viewer[data-ready=true]")
        page.close()
        assert program.wait(300) == 0
    for ending in ("exr", "png"):
        assert (FOLDER / f"closed.{ending}").read_bytes() == (FOLDER / f"live.{ending}").read_bytes(), "watching changed the image"


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        # Nothing is requested from other machines, by the browser itself neither.
        options = ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
        options += ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = playwright.chromium.launch(executable_path=chromium(), args=options)
        with contextlib.closing(browser):
            for check in (rendered_page, picture_page, toned_page, large_page, compared_page, experiment_page, viewed_page, live_page):
                check(browser)
                print(f"{check.__name__}: ok", flush=True)


main()

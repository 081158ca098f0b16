"""When a film is seen in `tashika view`, and how much memory the program takes: open.py PROGRAM FILE.exr SHOT.png

Needs the package playwright, and Chromium.
"""

import re
import shutil
import subprocess
import sys
import time

from playwright.sync_api import sync_playwright

program, path, shot = sys.argv[1:]


def memory(pid):
    with open(f"/proc/{pid}/status") as status:
        return int(re.search(r"VmHWM:\s+(\d+)", status.read())[1]) // 1024


painted = """() => { const c = document.getElementById("stage");
  const d = c.getContext("2d").getImageData(c.width * 0.2, 0, 2, c.height).data;
  let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return 4 * n / d.length }"""
begun = time.time()
view = subprocess.Popen([program, "view", path, "--no-browser"], stdout=subprocess.PIPE, text=True)
address = next(word for word in view.stdout.readline().split() if word.startswith("http"))
print(f"address after {time.time() - begun:.2f} s")
with sync_playwright() as playwright:
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    page = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"]).new_page(viewport={"width": 1280, "height": 900})
    begun = time.time()

    def until(done, what):
        while not done():
            page.wait_for_timeout(50)
        print(f"{what} after {time.time() - begun:.2f} s, {memory(view.pid)} MB", flush=True)

    page.goto(address)
    page.wait_for_selector("#viewer[data-ready=true]")
    until(lambda: True, "page")
    until(lambda: page.evaluate(painted) > 0.98, "all of the image, coarsely,")
    until(lambda: page.evaluate("() => document.getElementById('news').hidden"), "every strip read")
    begun = time.time()
    page.focus("#stage")
    page.keyboard.press("1")
    page.wait_for_timeout(100)
    until(lambda: page.evaluate(painted) > 0.98, "one to one in the middle")
    begun = time.time()
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_function("() => pixel.dataset.x === '3850'")
    until(lambda: True, "the pixel under the cursor")
    page.screenshot(path=shot)
view.kill()

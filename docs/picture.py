"""The picture of a page for the README: picture.py PAGE.html OUT.png

Needs the package playwright, and Chromium.
"""

import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

page_file, out = (pathlib.Path(path).resolve() for path in sys.argv[1:])
with sync_playwright() as playwright:
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
    page = browser.new_page(viewport={"width": 1200, "height": 640})
    page.goto(page_file.as_uri())
    page.wait_for_selector("#viewer[data-ready=true]")
    # Side by side.
    page.focus("#stage")
    page.keyboard.press("v")
    page.keyboard.press("0")
    page.wait_for_timeout(500)
    page.screenshot(path=out)
    browser.close()

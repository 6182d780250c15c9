# SPDX-License-Identifier: GPL-3.0-or-later
"""The documentation is built without a warning, and a browser shows every page, on a desk and on a phone, no wider than the
screen, with its pictures and its mathematics, without the network.
"""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest
from browser import browser
from harness import SOURCE
from selenium.webdriver import Chrome

SCREENS = {"desk": (1280, 900), "phone": (390, 844)}  # pixels
PATIENCE = 60  # s
# Whether the mathematics of the page is drawn; its number of formulas, of drawn ones and of errors; pictures that are not there; the
# width of the page and of the screen.
DRAWN = """
  const formulas = document.querySelectorAll('.math').length, wanted = formulas > 0;
  return !wanted || !!(window.MathJax && MathJax.Hub && MathJax.Hub.queue.pending == 0 && document.querySelector('.MathJax_SVG'))"""
LOOK = """
  const count = selector => document.querySelectorAll(selector).length, root = document.documentElement
  return [count('.math'), count('.MathJax_SVG'), count('.merror, .MathJax_Error'),
          [...document.images].filter(one => !one.complete || one.naturalWidth == 0).length, root.scrollWidth, root.clientWidth]"""


@pytest.fixture(scope="module")
def html(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-q", "-n", "-W", "--keep-going", "-b", "html", "-d", str(folder / "doctrees"),
               str(SOURCE / "docs"), str(folder / "html")]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr.strip(), f"the documentation is not built without a warning:\n{done.stderr}"
    return folder / "html"


def requested(driver: Chrome) -> list[str]:
    """The addresses in the network that the page asked for."""
    sent = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    urls = [one["params"]["request"]["url"] for one in sent if one["method"] == "Network.requestWillBeSent"]
    return [url for url in urls if url.startswith("http")]


def problems(driver: Chrome, page: Path, width: int) -> list[str]:
    driver.get(page.as_uri())
    end = time.monotonic() + PATIENCE
    while not driver.execute_script(DRAWN) and time.monotonic() < end:
        time.sleep(0.05)
    formulas, drawn, errors, missing, wide, screen = driver.execute_script(LOOK)
    found = []
    if wide > screen or screen > width:
        found.append(f"is {wide} pixels wide")
    if drawn != formulas or errors:
        found.append(f"{formulas} formulas, {drawn} drawn, {errors} errors")
    if missing:
        found.append(f"{missing} pictures are missing")
    if urls := requested(driver):
        found.append(f"asks the network for {urls[0]}")
    return found


@pytest.mark.parametrize("screen", SCREENS)
def test_pages(screen: str, html: Path, tmp_path: Path) -> None:
    pages = [page for page in sorted(html.rglob("*.html")) if "_static" not in page.parts]
    width, height = SCREENS[screen]
    found, formulas = [], 0
    with browser(tmp_path) as driver:
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": screen == "phone"}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        for page in pages:
            found += [f"{page.relative_to(html)} {problem}" for problem in problems(driver, page, width)]
            formulas += driver.execute_script("return document.querySelectorAll('.MathJax_SVG').length")
    print(f"{len(pages)} pages, {formulas} formulas")
    assert len(pages) > 25 and formulas > 250, "hardly anything was shown"
    assert not found, "\n".join(found)

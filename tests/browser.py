# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of pages share: making a page, and a browser that opens it and does what a reader does."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from harness import SOURCE
from selenium.webdriver import Chrome, ChromeOptions
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

SCRIPT = SOURCE / "postprocess" / "report.py"
PATIENCE = 60  # s
BODY = "document.getElementById('body-plot').data"


def make(*folders: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(SCRIPT), *map(str, folders)], capture_output=True, text=True)


def page_of(*folders: Path) -> Path:
    """The page of a folder, or of two. What it is of is said before where it is, and within."""
    done, page = make(*folders), folders[-1] / ("report.html" if len(folders) == 1 else "comparison.html")
    assert done.returncode == 0 and not done.stderr, done.stdout + done.stderr
    identity, path = done.stdout.splitlines()
    text = page.read_text(encoding="utf-8")
    assert path == str(page) and '<meta name="generator" content="signorini report">' in text, path
    assert f'<meta name="signorini-shows" content="{identity}">' in text and f"This page shows: {identity}." in text, identity
    for folder in folders:
        if (folder / "run.json").is_file():
            finished = json.loads((folder / "run.json").read_text())["finished"]
            assert finished.replace("T", " ").replace("Z", " UTC") in identity, f"{finished} is not in {identity}"
    return page


@contextmanager
def browser(folder: Path) -> Iterator[Chrome]:
    """A browser with an empty profile that writes down its complaints and what it asks of the network."""
    options = ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in ("headless", "no-sandbox", "use-gl=angle", "use-angle=swiftshader", "enable-unsafe-swiftshader", "disable-quic",
                 "no-first-run", "disable-background-networking", "disable-component-update", "disable-sync",
                 "window-size=1280,900", f"user-data-dir={folder}"):  # fmt: skip
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        yield driver
    finally:
        driver.quit()


class Reader:
    """Opens a page and uses it. Fails where the page asks for another file or the browser reports an error."""

    def __init__(self, driver: Chrome, page: Path, width: int, height: int) -> None:
        self.driver = driver
        driver.get("about:blank")
        for log in ("browser", "performance"):
            driver.get_log(log)
        self.size(width, height)
        driver.get(page.as_uri())
        self.wait("'ready' in document.documentElement.dataset || !document.getElementById('trouble').hidden")
        trouble = self.ask("document.getElementById('trouble').textContent")
        assert not trouble, trouble
        self.page = page

    def size(self, width: int, height: int) -> None:
        screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)

    def ask(self, expression: str) -> object:
        return self.driver.execute_script(f"return {expression}")

    def wait(self, expression: str) -> None:
        WebDriverWait(self.driver, PATIENCE).until(lambda _: self.ask(expression), f"never true: {expression}")

    def changed(self, expression: str, act: Callable[[], object]) -> None:
        """Asserts that the action changes the expression's value."""
        before = self.ask(f"JSON.stringify({expression})")
        act()
        WebDriverWait(self.driver, PATIENCE).until(lambda _: self.ask(f"JSON.stringify({expression})") != before,
                                                   f"did not change: {expression}")  # fmt: skip

    def find(self, selector: str) -> object:
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def select(self, selector: str, index: int) -> None:
        Select(self.find(selector)).select_by_index(index)

    def fits(self) -> None:
        """Nothing makes the page wider than the screen."""
        wide, screen = self.ask("document.documentElement.scrollWidth"), self.ask("document.documentElement.clientWidth")
        assert wide <= screen, f"{self.page}: {wide} pixels wide on a screen of {screen}"

    def close(self) -> None:
        """Asserts that the browser reported no error and that the page asked for no other file."""
        errors = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        assert not errors, errors
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        asked = {event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"}
        assert {url for url in asked if not url.startswith(("data:", "blob:"))} == {self.page.as_uri()}, asked


@contextmanager
def opened(driver: Chrome, page: Path, width: int = 1280, height: int = 900) -> Iterator[Reader]:
    """The reader of a page in a window, by default of a desk's size; checks at the end what the browser reported."""
    reader = Reader(driver, page, width, height)
    yield reader
    reader.close()

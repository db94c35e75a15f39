"""A browser without a network, for tests of pages: chromium with its chromedriver.

Tests that import this are skipped where selenium, chromium or chromedriver is missing.
"""

from __future__ import annotations

import shutil
from contextlib import contextmanager

import pytest

from tests.support.waiting import HANGS

MISSING = "selenium is not installed"
webdriver = pytest.importorskip("selenium.webdriver", reason=MISSING)
Select = pytest.importorskip("selenium.webdriver.support.select", reason=MISSING).Select
WebDriverWait = pytest.importorskip(
    "selenium.webdriver.support.wait", reason=MISSING
).WebDriverWait
Keys = webdriver.Keys

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), ""
)
DRIVER = shutil.which("chromedriver")
needs_browser = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="no chromium or chrome with its chromedriver on the PATH"
)
FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync "
    "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=800,700"
)


@contextmanager
def started(folder):
    """A browser with its profile in a folder, until the end of the block."""
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    profile = f"--user-data-dir={folder}"
    for flag in (*FLAGS.split(), "--host-resolver-rules=MAP * ~NOTFOUND", profile):
        options.add_argument(flag)
    service = webdriver.ChromeService(executable_path=DRIVER)
    with webdriver.Chrome(options=options, service=service) as driver:
        driver.command_executor.client_config.timeout = HANGS
        driver.set_script_timeout(HANGS)
        yield driver


@contextmanager
def screen(driver, width, height=800, scheme="light"):
    """A screen of a width, on a phone if it is narrow, and a colour scheme, for a block."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    yield
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def show(driver, folder, text):
    """Write a page into a folder and open it."""
    path = folder / "page.html"
    path.write_text(text, encoding="utf-8")
    driver.get_log("browser")
    driver.get(path.as_uri())


def complaints(driver):
    """What the browser reports as wrong."""
    return [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]


def too_wide(driver):
    """By how many pixels the page is wider than the screen."""
    wide = "return document.documentElement.scrollWidth - window.innerWidth"
    return max(driver.execute_script(wide), 0)


def wait_until(driver, condition):
    """Wait until a condition on the page holds."""
    WebDriverWait(driver, HANGS, poll_frequency=0.05).until(condition)


def one(driver, selector):
    """The first element of a CSS selector."""
    return driver.find_element("css selector", selector)


def settle(driver):
    """Wait until nothing is being drawn."""
    busy = "return document.querySelectorAll('[aria-busy=true]').length"
    wait_until(driver, lambda page: page.execute_script(busy) == 0)


# Called with a button, the text of a condition, and a function to call when it holds.
STOP = """
const [button, condition, done] = arguments, holds = new Function(`return ${condition}`);
const look = () => {
  if (!holds()) return requestAnimationFrame(look);
  const label = button.textContent;
  button.click();
  done([label, button.textContent]);
};
look();
"""


def play_until(driver, selector, condition):
    """Play until a condition of JavaScript holds, and stop in the same frame.

    Returns:
        The labels of the button while it plays, and after it.
    """
    button = one(driver, selector)
    button.click()
    labels = driver.execute_async_script(STOP, button, condition)
    settle(driver)
    return labels

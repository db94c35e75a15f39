"""Claim: the page of the 6-UPS is small, and its scripts take half a second on a slow machine.

A page is opened by Chromium without a window and without a network. Script time is counted by
the browser with its processor slowed down four times (``Emulation.setCPUThrottlingRate``). A
machine that is busy lengthens it, since it is a time of the wall; the processor time of
the thread that runs the page, which also parses and paints, is not.
"""

from __future__ import annotations

import shutil
import time
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from balance import design_space, explain
from balance.app.answers.data import Report
from balance.app.answers.html.report import report_page

# Slower than the machine by this factor.
SLOWER = 4.0
FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
    "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader "
    "--window-size=1280,900"
)


class PagesLoadQuickly:
    """The page of a design space, from its file to the first drawing."""

    params = (("stewart_6ups",),)
    runs = 5
    claims = (
        ("track_script_seconds", 0.5),
        ("track_thread_seconds", 0.5),
        ("track_megabytes", 1.5),
    )

    def setup(self, model: str) -> None:
        """Make the page."""
        if not (shutil.which("chromium") and shutil.which("chromedriver")):
            raise NotImplementedError("no chromium with its chromedriver on the PATH")
        space = design_space(model)
        self.text = report_page(Report(space, explain(space)))

    def track_megabytes(self, model: str) -> float:
        """Size of the page."""
        return len(self.text.encode()) / 1e6

    def track_script_seconds(self, model: str) -> np.ndarray:
        """Time in scripts, on a processor that is slowed down."""
        with self._opened() as (driver, address):
            driver.execute_cdp_cmd("Performance.enable", {})
            return np.array([_script(driver, address) for _ in range(self.runs)])

    def track_thread_seconds(self, model: str) -> np.ndarray:
        """Processor time of the thread of the page, times the factor of the slower machine."""
        with self._opened() as (driver, address):
            return np.array([SLOWER * _thread(driver, address) for _ in range(self.runs)])

    @contextmanager
    def _opened(self) -> Any:
        """Start a browser, and write the page."""
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium") or ""
        with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            for flag in (*FLAGS.split(), f"--user-data-dir={folder}/profile"):
                options.add_argument(flag)
            page = Path(folder) / "page.html"
            page.write_text(self.text, encoding="utf-8")
            service = webdriver.ChromeService(executable_path=shutil.which("chromedriver"))
            with webdriver.Chrome(options=options, service=service) as driver:
                yield driver, page.as_uri()


def _open(driver: Any, address: str) -> None:
    """Open a page anew and wait until it is drawn."""
    driver.get(address)
    busy = "return document.querySelectorAll('[aria-busy=true]').length"
    while driver.execute_script(busy):
        time.sleep(0.02)


def _script(driver: Any, address: str) -> float:
    """Measure the time in scripts of one load, in seconds."""
    driver.get("about:blank")
    driver.execute_cdp_cmd("Emulation.setCPUThrottlingRate", {"rate": SLOWER})
    _open(driver, address)
    metrics = driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
    driver.execute_cdp_cmd("Emulation.setCPUThrottlingRate", {"rate": 1})
    return next(one["value"] for one in metrics if one["name"] == "ScriptDuration")


def _thread(driver: Any, address: str) -> float:
    """Measure the processor time of the main threads of all pages during one load."""
    driver.get("about:blank")
    time.sleep(0.2)
    before = _renderers(driver.service.process.pid)
    _open(driver, address)
    after = _renderers(driver.service.process.pid)
    return sum(after[pid] - before.get(pid, 0.0) for pid in after)


def _renderers(root: int) -> dict[int, float]:
    """Read the processor time, in seconds, of the main thread of each page below a process."""
    parents, found = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            status = (folder / "stat").read_text().rpartition(")")[2].split()
            parents[int(folder.name)] = int(status[1])
            words = (folder / "cmdline").read_bytes()
            if b"--type=renderer" in words:
                used = (folder / "task" / folder.name / "schedstat").read_text().split()[0]
                found[int(folder.name)] = int(used) / 1e9
        except OSError:
            continue

    def below(pid: int) -> bool:
        return pid == root or (pid in parents and below(parents[pid]))

    return {pid: used for pid, used in found.items() if below(pid)}

"""A command says in one line that it uses much memory."""

from __future__ import annotations

from pathlib import Path
from time import sleep

import pytest

from balance.app.cli import memory_notice
from balance.app.cli.main import main

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/statm").exists(), reason="the system does not tell the memory"
)


def test_a_command_says_once_that_it_uses_much_memory(monkeypatch, caplog):
    monkeypatch.setattr(memory_notice, "MUCH", 1e6)
    monkeypatch.setattr(memory_notice, "INTERVAL", 0.001)
    assert main(["report", "four_bar_general"]) == 0
    lines = [x for x in caplog.messages if "memory" in x]
    assert lines == ["this command uses more than 0.001 GB of memory"]


def test_the_limit_is_that_of_the_resident_memory(monkeypatch, caplog):
    pages = Path("/proc/self/status").read_text().split("VmRSS:")[1].split()[0]
    used = 1000 * float(pages)
    monkeypatch.setattr(memory_notice, "INTERVAL", 0.001)
    for limit, said in ((2 * used, False), (used / 2, True)):
        caplog.clear()
        monkeypatch.setattr(memory_notice, "MUCH", limit)
        with memory_notice.memory_notice():
            sleep(0.1)
        assert ("memory" in caplog.text) is said

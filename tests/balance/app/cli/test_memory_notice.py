"""A command says in one line that it uses much memory."""

from __future__ import annotations

import numpy as np

from balance.app.cli import memory_notice
from balance.app.cli.main import main


def test_a_command_says_once_that_it_uses_much_memory(monkeypatch, caplog):
    monkeypatch.setattr(memory_notice, "MUCH", 1e6)
    monkeypatch.setattr(memory_notice, "INTERVAL", 0.001)
    assert main(["report", "four_bar_general"]) == 0
    lines = [x for x in caplog.messages if "memory" in x]
    assert lines == ["this command uses more than 0.001 GB of memory"]


def test_memory_is_that_which_is_in_use():
    before = memory_notice.resident_memory()
    reserved = np.empty(10**9)
    assert memory_notice.resident_memory() - before < 0.1 * reserved.nbytes
    used = np.ones(4 * 10**7)
    assert 0.9 < (memory_notice.resident_memory() - before) / used.nbytes < 1.5

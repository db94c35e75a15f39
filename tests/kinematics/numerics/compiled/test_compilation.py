"""Commands do not wait for a compiler: uncompiled kernels, and one process that compiles.

The rules are tried on a package with two kernels; a warm-up that tells who runs it stands in
for the real one, which is tried at the end.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from filelock import FileLock

from kinematics import gallery
from kinematics.numerics.compiled.jit import kernel
from tests.support.covering import ALL_CASES
from tests.support.small_package import ROOT, clean, run
from tests.support.waiting import HANGS, wait_until_true

WARM_UP = """
import os, pathlib
from filelock import FileLock
from kinematics.numerics.compiled.background import register_warm_up

def stages():
    with pathlib.Path(os.environ["NUMBA_CACHE_DIR"], "compilers").open("a") as file:
        print(os.getpid(), file=file)
    from kinematics.above import outer
    outer(1.0)
    yield
    with FileLock(os.environ["WAIT_FOR"]):
        pass
    if os.environ.get("BROKEN"):
        raise RuntimeError("a compiler that fails")

register_warm_up("kinematics.loading.warmup", stages)
"""
# What a command does: kernels run, and seem to take a second, whatever they take.
COMMAND = """
import sys, kinematics.loading.warmup, kinematics.numerics.compiled.jit
from kinematics.numerics.compiled.background import kernel_clock, begin_command
kinematics.numerics.compiled.jit.perf_counter = lambda: 0.0
begin_command()
from kinematics.above import outer
print(outer(1.0))
kernel_clock.add(1.0)
print(outer(1.0), "numba" in sys.modules)
"""
QUICK = COMMAND.replace("kernel_clock.add(1.0)", "kernel_clock.add(0.1)")


@pytest.fixture
def small(copy, tmp_path):
    """The small packages with a warm-up, and the environment of a command.

    A process that compiles in the background waits before it ends for a lock that tests may
    hold, and which is free as soon as they end.
    """
    (copy / "kinematics" / "loading" / "warmup.py").write_text(WARM_UP, encoding="utf-8")
    (tmp_path / "cache").mkdir()
    lock = str(tmp_path / "wait.lock")
    return copy, {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "WAIT_FOR": lock}


def compilers(environment):
    """Processes that have begun to compile, in their order."""
    file = Path(environment["NUMBA_CACHE_DIR"], "compilers")
    return [int(word) for word in file.read_text().split()] if file.exists() else []


def wait_for_the_end(environment):
    """Wait until the process that compiles has ended, which has its lock until then."""
    with FileLock(Path(environment["NUMBA_CACHE_DIR"], "kernels.lock"), timeout=HANGS):
        pass


def is_complete(environment):
    """Whether all kernels are said to be there."""
    files = list(Path(environment["NUMBA_CACHE_DIR"]).glob("*/kernels.ready"))
    return bool(files) and all(file.read_text().split()[-1] == "all" for file in files)


def test_a_short_command_compiles_nothing(small):
    folder, environment = small
    assert run(folder, QUICK, **environment) == (["20.0", "20.0", "False"], [])
    assert not compilers(environment)


@pytest.mark.compile
def test_a_long_command_has_kernels_compiled_for_the_next(small):
    folder, environment = small
    out, told = run(folder, COMMAND, **environment)
    assert out == ["20.0", "20.0", "False"]
    assert len(told) == 1 and "BALANCE_COMPILE=now|background|never" in told[0]
    wait_until_true(lambda: is_complete(environment))
    wait_for_the_end(environment)
    assert run(folder, COMMAND, **environment) == (["20.0", "20.0", "True"], [])
    assert len(compilers(environment)) == 1
    for file in folder.glob("kinematics/below.py"):
        file.write_text(file.read_text().replace("1.0", "2.0"))
    out, told = run(folder, COMMAND, **environment)
    assert out == ["30.0", "30.0", "False"] and len(told) == 1, "other kernels, not yet there"
    wait_until_true(lambda: len(compilers(environment)) == 2)


@pytest.mark.compile
def test_a_command_that_foresees_a_long_run_loads_compiled_kernels_before_it(small):
    folder, environment = small
    run(folder, COMMAND, **environment)
    wait_until_true(lambda: is_complete(environment))
    for seconds, loaded in (("0.1", "False"), ("2.0", "True")):
        code = QUICK.replace("print(outer", f"kernel_clock.foresee({seconds}); print(outer", 1)
        assert run(folder, code, **environment) == (["20.0", "20.0", loaded], [])


@pytest.mark.compile
def test_a_command_changes_to_compiled_kernels_that_come_meanwhile(small):
    folder, environment = small
    code = COMMAND.replace(
        "print(outer(1.0), ",
        """
import time
while not kernel_clock.runs_compiled("kinematics.above.outer()"):
    time.sleep(0.05)
    kernel_clock.add(0.0)
print(outer(1.0), """,
    )
    assert run(folder, code, **environment)[0] == ["20.0", "20.0", "True"]


@pytest.mark.compile
def test_eight_commands_at_once_compile_once_and_do_not_wait(small):
    folder, environment = small
    with FileLock(environment["WAIT_FOR"]), ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: run(folder, COMMAND, **environment), range(8)))
        assert not is_complete(environment)
    assert all(out[:2] == ["20.0", "20.0"] for out, _ in answers)
    wait_until_true(lambda: is_complete(environment))
    wait_for_the_end(environment)
    assert len(compilers(environment)) == 1


@pytest.mark.compile
def test_processes_of_a_command_compile_nothing_themselves(small):
    """The command has kernels compiled for them, once."""
    folder, environment = small
    code = f"""
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from kinematics.numerics.compiled.background import begin_command
begin_command()
with ProcessPoolExecutor(2, get_context("spawn")) as pool:
    list(pool.map(exec, 2 * [{COMMAND.replace("begin_command()", "")!r}]))
"""
    out, told = run(folder, code, **environment)
    assert out == 2 * ["20.0", "20.0", "False"] and not told
    assert not compilers(environment)


@pytest.mark.compile
def test_a_compiler_that_is_killed_does_no_harm(small):
    folder, environment = small
    with FileLock(environment["WAIT_FOR"]):
        run(folder, COMMAND, **environment)
        wait_until_true(lambda: len(compilers(environment)) == 1)
        os.kill(compilers(environment)[0], getattr(signal, "SIGKILL", signal.SIGTERM))
        wait_for_the_end(environment)
    assert run(folder, COMMAND, **environment)[0][:2] == ["20.0", "20.0"]
    wait_until_true(lambda: is_complete(environment))
    assert len(compilers(environment)) == 2


@pytest.mark.compile
def test_a_compiler_that_fails_is_told_and_tried_again(small):
    folder, environment = small
    assert run(folder, COMMAND, **environment, BROKEN="1")[0][:2] == ["20.0", "20.0"]
    log = Path(environment["NUMBA_CACHE_DIR"], "kernels.log")
    wait_until_true(lambda: log.exists() and "a compiler that fails" in log.read_text())
    run(folder, COMMAND, **environment)
    wait_until_true(lambda: is_complete(environment))


@pytest.mark.slow
@pytest.mark.parametrize("choice, imported", [("now", "True"), ("never", "False")])
def test_the_environment_chooses(small, choice, imported):
    folder, environment = small
    out, told = run(folder, COMMAND, **environment, BALANCE_COMPILE=choice)
    assert out == ["20.0", "20.0", imported]
    assert bool(told) == (choice == "now") and not compilers(environment)


@pytest.mark.compile
def test_a_session_compiles_at_once_or_ahead(small):
    folder, environment = small
    code = (
        "import kinematics.loading.warmup, kinematics.numerics.compiled.background as b; "
        "b.compile()"
    )
    out, told = run(folder, code, **environment)
    assert len(told) == 1 and told[0].startswith("compiling kernels")
    assert is_complete(environment)
    ask = "from kinematics.above import outer; print(outer(1.0), len(outer.signatures))"
    assert run(folder, ask, **environment) == (["20.0", "1"], [])
    assert not run(folder, code, **environment, BALANCE_COMPILE="never")[1]


@pytest.mark.compile
def test_a_kernel_is_loaded_without_the_rules_by_which_numba_compiles(small):
    """A compilation after it, for another type of number, collects them."""
    folder, environment = small
    code = (
        "import sys; from kinematics.above import outer; "
        "print(outer(1.0), 'numba.np.arraymath' in sys.modules); "
        "print(outer(1), 'numba.np.arraymath' in sys.modules, len(outer.signatures))"
    )
    run(folder, "from kinematics.above import outer; outer(1.0)", **environment)
    out, _ = run(folder, code, **environment)
    assert out == ["20.0", "False", "20.0", "True", "2"]


@pytest.mark.compile
def test_a_kernel_is_loaded_with_the_rules_where_numba_asks_for_them(small):
    """As another version of Numba may, whose runtime cannot be started alone."""
    folder, environment = small
    code = (
        "import sys, numba.core.runtime; numba.core.runtime.rtsys = None; "
        "from kinematics.above import outer; "
        "print(outer(1.0), 'numba.np.arraymath' in sys.modules)"
    )
    assert run(folder, code, **environment)[1], "it is compiled, and that is told"
    assert run(folder, code, **environment) == (["20.0", "True"], [])


def on_terminal(folder, *words, **environment):
    """What a process writes to a terminal that is its standard error."""
    pty = pytest.importorskip("pty", reason="there are no pseudo-terminals here")
    ours, theirs = pty.openpty()
    try:
        done = subprocess.Popen(
            [sys.executable, *words],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=theirs,
            env=clean() | {"TERM": "xterm", "COLUMNS": "120"} | environment,
        )
        os.close(theirs)
        text = b""
        with contextlib.suppress(OSError):  # the end of it
            while piece := os.read(ours, 65536):
                text += piece
        assert done.wait() == 0, text
    finally:
        os.close(ours)
    return text.decode(errors="replace")


@pytest.mark.slow
def test_a_terminal_counts_kernels(small):
    folder, environment = small
    code = (
        "import kinematics.loading.warmup, kinematics.numerics.compiled.background as b; "
        "b.compile()"
    )
    text = on_terminal(folder, "-c", code, **environment)
    assert "compiling kernels" in text and "2/2" in text


@pytest.mark.compile
def test_a_terminal_shows_that_a_command_works():
    """However short it is: the spinner is told to have no patience."""
    code = """if True:
        from balance.app.cli import main, progress
        progress.SPINNER_PATIENCE = 0.0
        main.main(["report", "three_rsr"])"""
    text = on_terminal(ROOT, "-c", code, BALANCE_COMPILE="never")
    assert "finding the mass distributions" in text and "0:00:0" in text
    assert "massless: no mass" in text


def test_no_folder_means_no_compiler(small, tmp_path):
    folder, environment = small
    (tmp_path / "file").write_text("")
    environment["NUMBA_CACHE_DIR"] = str(tmp_path / "file" / "below")
    out, told = run(folder, COMMAND, **environment)
    assert out == ["20.0", "20.0", "False"]
    assert len(told) == 1 and "NUMBA_CACHE_DIR" in told[0]


def test_a_wrong_choice_is_usage():
    done = subprocess.run(
        [sys.executable, "-m", "balance", "models"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env=clean() | {"BALANCE_COMPILE": "later"},
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(
        r"balance: BALANCE_COMPILE='later': choose from .*\nbalance models --help .*\n",
        done.stderr,
    )


# Requests, each before and after the model.
REQUESTS = (
    ("report",),
    ("report", "--balance", "force"),
    ("report", "--spatial"),
    ("design",),
    ("verify", "--trajectories", "1"),
    ("motion",),
)
# Linkages of many kinds, to which all requests are made; others get one, in turn.
KINDS = ("four_bar_kite_balanced", "three_rsr", "hprs", "slider_crank", "bennett", "rusr")
# What the commands do; the kernels that are compiled after a warm-up.
ALL_COMMANDS = """
import contextlib, io, json, sys
import balance, kinematics
kinematics.compile()
from numba.core import event
late = []
class Listener(event.Listener):
    def on_start(self, event):
        late.append(str(event.data["dispatcher"].py_func))
    def on_end(self, event):
        pass
event.register("numba:compile", Listener())
from balance.app.cli.main import main
codes = set()
for words in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()):
        codes.add(main(words))
print(json.dumps([sorted(codes), late]))
"""


@pytest.mark.compile
def test_a_warm_up_compiles_all_that_commands_call():
    """In a process of its own, which has loaded nothing before.

    All requests are made to all models with ``ALL_CASES=1``.
    """
    words = [
        [verb, model, *more]
        for turn, model in enumerate(gallery())
        for k, (verb, *more) in enumerate(REQUESTS)
        if ALL_CASES or model in KINDS or k == turn % len(REQUESTS)
    ]
    done = subprocess.run(
        [sys.executable, "-c", ALL_COMMANDS, json.dumps(words)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    codes, late = json.loads(done.stdout)
    assert set(codes) <= {0, 1, 3, 4} and late == []


def test_a_kernel_for_other_values_than_integers_is_refused():
    """Numba would pickle them into its index: each process would compile such a kernel anew."""

    def of_degree(degree):
        return kernel(lambda x: x**degree)

    assert of_degree(2)(3.0) == 9.0
    with pytest.raises(TypeError, match="close over integers"):
        of_degree(2.5)


# Names of the kernels with machine code, before and after those inside others get theirs.
INSIDE = """
from kinematics.above import outer
from kinematics.below import inner
from kinematics.numerics.compiled import numba_compiler

outer(1.0)
names = lambda: ",".join(name.split(".")[-1] for name in numba_compiler.compiled_kernels())
print(names())
list(numba_compiler.compile_inner_kernels())
print(names())
print(outer(1.0), inner(1.0), list(numba_compiler.compile_inner_kernels()))
"""


@pytest.mark.compile
def test_kernels_inside_others_get_machine_code_for_calls_by_python_alone(small):
    """A warm-up compiles them for these calls, once."""
    folder, environment = small
    said, _ = run(folder, INSIDE, **environment)
    assert said[0] == "outer()" and set(said[1].split(",")) == {"outer()", "inner()"}
    assert said[-3:] == ["20.0", "2.0", "[]"]

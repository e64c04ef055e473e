# SPDX-License-Identifier: Apache-2.0
"""
Runs tests on mutants: a process for each, forked from one pytest session that has collected the tests.

The loops of the package that is mutated run as the Python that they are, without numba: a mutant then needs
no compilation. A change inside of a function is put into that function. For any other package and tests are
imported anew in the forked process, and nothing at all is compiled.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest
from numba.core.event import Listener, register

from scripts.mutation.python.fork import Outcome, allow_seconds, forked
from scripts.mutation.python.mutants import Mutant, mutated
from scripts.mutation.python.patch import caches_of, forget_imports, function_body, patch

OWN = ("quadshade", "tests", "conftest")
"""What is imported anew."""

OPTIONS = ("-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", "--hypothesis-seed=1")


def interpret_loops(prefixes: tuple[str, ...]) -> None:
    """Let numba's decorators leave functions of modules as they are whose names begin so."""
    import numba

    # Kept on the module, so that calling this again wraps the real one.
    compiler = vars(numba).setdefault("_compiling_njit", numba.njit)

    def njit(*functions: Callable[..., Any], **options: Any) -> Any:
        def decorate(function: Callable[..., Any]) -> Any:
            return function if function.__module__.startswith(prefixes) else compiler(**options)(function)

        return decorate(functions[0]) if functions else decorate

    numba.njit = njit


def copy_package(root: Path, folder: Path) -> Path:
    """A copy of the package, with its compiled loops, in which one file at a time is changed."""
    package = folder / "quadshade"
    for path in (root / "model" / "quadshade").rglob("*"):
        target = package / path.relative_to(root / "model" / "quadshade")
        if path.is_file() and path.suffix != ".pyc":
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists() or target.stat().st_mtime != path.stat().st_mtime:
                shutil.copy2(path, target)
    return package


def use_copy(root: Path, package: Path) -> None:
    """The copy comes first on the path, in this process and in those that it starts."""
    os.chdir(root)
    paths = [str(package.parent), str(root)]
    sys.path[:] = paths + [path for path in sys.path if path not in ("", *paths)]
    os.environ |= {"PYTHONPATH": os.pathsep.join(paths), "QUADSHADE_SEED": "1"}
    forget_imports(OWN)


class Session:
    """
    A pytest plugin: collects tests, times them without a change, and then forks for each mutant.

    Parameters
    ----------
    package : Path
      The copy.
    slow, spare : float
      Seconds of processor time: a test that takes longer without a change is left out; so much longer than
      usual may a mutant take.
    work : callable
      Is called with this session when it is ready, and calls :meth:`run`.
    """

    def __init__(self, package: Path, slow: float, spare: float, work: Callable[[Session], None]) -> None:
        self.package, self.slow, self.spare, self.work = package, slow, spare, work
        self.items: list[pytest.Item] = []
        self.compiler = _Compiler()
        self.seconds: dict[str, float] = {}
        self.reached: dict[str, set[tuple[str, str]]] = {}
        self.at_import: set[tuple[str, str]] = set()
        self.failed = ""
        self.problem = ""

    def pytest_sessionstart(self) -> None:
        _hurry()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_collection(self) -> Iterator[None]:
        with self._functions() as self.at_import:
            yield

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        if session.testsfailed:
            self.problem = "tests cannot be collected"
            return True
        for item in session.items:
            self.seconds[item.nodeid] = self._timed(item)
            if self.failed:
                self.problem = f"{self.failed} fails without a change"
                return True
        self.items = [item for item in session.items if self.seconds[item.nodeid] <= self.slow]
        self.items.sort(key=lambda item: self.seconds[item.nodeid])
        self.caches = caches_of(OWN)
        for item in self.items:
            for cache in self.caches:
                cache.cache_clear()
            with self._functions() as self.reached[item.nodeid]:
                self._run_item(item)
        self.work(self)
        return True

    @contextlib.contextmanager
    def _functions(self) -> Iterator[set[tuple[str, str]]]:
        """The functions of the package, by file and qualified name, that are called while this is open."""
        called: set[CodeType] = set()
        functions: set[tuple[str, str]] = set()

        def profile(frame: FrameType, event: str, argument: object) -> None:
            if event == "call":
                called.add(frame.f_code)

        threading.setprofile(profile)
        sys.setprofile(profile)
        try:
            yield functions
        finally:
            sys.setprofile(None)
            threading.setprofile(None)  # type: ignore[arg-type]
            # A function within a function is a part of it.
            functions |= {
                (code.co_filename, code.co_qualname.split(".<")[0])
                for code in called
                if code.co_filename.startswith(str(self.package))
            }

    def _timed(self, item: pytest.Item) -> float:
        """Seconds of processor time of a test without numba's compiler; infinite if it is ended as slow."""
        start = self.compiler.seconds_beside()
        with _interrupted_after(self.slow, self.compiler) as interrupted:
            self._run_item(item)
        if interrupted.is_set():
            self.failed = ""
            return math.inf
        return self.compiler.seconds_beside() - start

    def _run_item(self, item: pytest.Item) -> None:
        # The same item again and again: nothing that stays set up for a next one.
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.failed:
            self.failed = report.nodeid

    @property
    def total(self) -> float:
        """Seconds of processor time of all tests that are run on a mutant."""
        return sum(self.seconds[item.nodeid] for item in self.items)

    def run(self, mutant: Mutant) -> Outcome:
        """
        Run the tests on a mutant until one fails, the shortest first.

        Of a function, those tests are run that call it; where none does, it survives. Where it is called
        while something is imported, or the change is outside of functions, package and tests are imported
        anew, and all tests are run.

        Parameters
        ----------
        mutant : Mutant

        Returns
        -------
        Outcome
        """
        target = self.package / mutant.path
        source = target.read_text()
        text = mutated(mutant, source)
        stamp = target.stat()
        place = (str(target), function_body(source, mutant))
        reaching = [item for item in self.items if place in self.reached[item.nodeid]]
        if place[1] and not reaching and place not in self.at_import:
            return Outcome("survived", "", 0.0)
        # Imported anew, tests of loops that were compiled take longer.
        anew = self.spare + 3 * self.total
        in_place = self.spare / 2 + 2 * sum(self.seconds[item.nodeid] for item in reaching)

        def tests() -> str:
            # What is compiled of a changed file must not be found by the next mutant.
            sys.dont_write_bytecode = True
            os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
            if place[1] and place not in self.at_import and patch(mutant, place[1], text, self.caches):
                allow_seconds(min(in_place, anew))
                return self._first_failure(reaching)
            return _import_anew([item.nodeid for item in self.items])

        try:
            # The compiled file goes too: its stamp counts in whole seconds.
            for stale in (target.parent / "__pycache__").glob(f"{target.stem}.*.pyc"):
                stale.unlink()
            target.write_text(text)
            return forked(tests, limit=anew, patience=30 * (4 + self.total))
        finally:
            target.write_text(source)
            os.utime(target, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))

    def _first_failure(self, items: Sequence[pytest.Item]) -> str:
        for item in items:
            self._run_item(item)
            if self.failed:
                return self.failed
        return ""


class _Compiler(Listener):
    """Tells the processor time of numba's compiler from that of tests, which are not slow for it."""

    def __init__(self) -> None:
        self.depth, self.begin, self.seconds = 0, 0.0, 0.0
        register("numba:compile", self)

    def on_start(self, event: object) -> None:
        if not self.depth:
            self.begin = time.process_time()
        self.depth += 1

    def on_end(self, event: object) -> None:
        self.depth -= 1
        if not self.depth:
            self.seconds += time.process_time() - self.begin

    def seconds_beside(self) -> float:
        """Of this process, up to now."""
        return (self.begin if self.depth else time.process_time()) - self.seconds


def _in_numba(frame: FrameType | None) -> bool:
    """Whether numba works: it registers what it can compile only once, and would miss that ever after."""
    while frame is not None:
        if frame.f_globals.get("__name__", "").startswith(("numba.", "importlib.")):
            return True
        frame = frame.f_back
    return False


@contextlib.contextmanager
def _interrupted_after(seconds: float, compiler: _Compiler) -> Iterator[threading.Event]:
    """A test that takes more processor time fails, and this says so: its end is not waited for."""
    interrupted = threading.Event()
    end = compiler.seconds_beside() + seconds

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal end
        if not compiler.depth and not _in_numba(frame) and compiler.seconds_beside() > end:
            interrupted.set()
            # Not again while pytest reports it, only where the test went on all the same.
            end += 2.0
            pytest.fail("takes too long")

    former = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.1)
    try:
        yield interrupted
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, former)


def _hurry() -> None:
    """Hypothesis tries fewer examples, does not shrink what it finds, nor keep it."""
    from hypothesis import Phase, settings

    phases = (Phase.explicit, Phase.generate)
    settings.register_profile("mutation", settings.default, database=None, phases=phases, max_examples=25)
    settings.load_profile("mutation")


class _FirstFailure:
    """Remembers the first test that fails, and runs tests in the order of a list."""

    def __init__(self, order: Sequence[str]) -> None:
        self.order = {name: place for place, name in enumerate(order)}
        self.failed = ""

    def pytest_sessionstart(self) -> None:
        _hurry()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.order), key=lambda item: self.order[item.nodeid]
        )

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.failed:
            self.failed = report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed and not self.failed:
            self.failed = f"{report.nodeid} (import)"


def _import_anew(order: Sequence[str]) -> str:
    """Run tests in a session of their own, package and tests imported anew; the first that fails."""
    interpret_loops(("",))
    forget_imports(OWN)
    files = list(dict.fromkeys(name.split("::")[0] for name in order))
    plugin = _FirstFailure(order)
    code = pytest.main([*OPTIONS, "-x", *files], plugins=[plugin])
    return plugin.failed or (f"pytest ended with {code}" if code else "")


def run_session(
    root: Path,
    folder: Path,
    interpreted: tuple[str, ...],
    tests: Sequence[str],
    slow: float,
    work: Callable[[Session], None],
    spare: float = 8.0,
) -> str:
    """
    Collect tests on a copy of the package, and do some work with them.

    Parameters
    ----------
    root, folder : Path
      The repository, and where the copy lies.
    interpreted : tuple of str
      Modules whose names begin so run without numba.
    tests : sequence of str
      Files.
    slow : float
      Seconds of processor time above which a test is left out.
    work : callable
      Is called with the session.
    spare : float
      As for :class:`Session`.

    Returns
    -------
    str
      Why the tests could not be run; empty if they could.
    """
    interpret_loops(interpreted)
    package = copy_package(root, folder)
    use_copy(root, package)
    importlib.invalidate_caches()
    session = Session(package, slow, spare, work)
    code = pytest.main([*OPTIONS, *tests], plugins=[session])
    return session.problem or ("" if code in (0, 1) else f"pytest ended with {code}")

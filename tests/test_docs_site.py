# SPDX-License-Identifier: Apache-2.0
"""The documentation's site in headless Chromium, and that its generated pages say what their sources say."""

from __future__ import annotations

import contextlib
import functools
import http.server
import os
import re
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from urllib.parse import unquote, urldefrag, urljoin

import pytest
from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

from cocotb_tests.support.simulation import module_of
from quadshade.cli.main import COMMANDS
from quadshade.contract.formats import GENERIC_HELP, Formats
from quadshade.engine.build_cache import build_once
from quadshade.golden.core.edge_dda import EdgeDda
from scripts.docs import drawings
from scripts.docs.command_line import command_line_page
from scripts.docs.entity import ROOT, units
from scripts.docs.simulate_unit import ports_per_clock
from scripts.docs.site import build_site
from scripts.docs.timing_diagram import diagram, windows
from tests.support.chromium import open_chromium

DRAWN = ("edge_dda", "load_adder")
"""Units with their diagram here; `make docs` simulates all of them."""

WIDTHS = (400, 1400)
ALIKE = ("reference/units/", "reference/python/")
"""Folders of pages that one template writes: one of :data:`EVERY` is opened, which ones the seed says."""
EVERY = 12
WIDE = "return document.documentElement.scrollWidth"


class Page(HTMLParser):
    """Links to pages, scripts, styles and pictures of a page, and its anchors."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Note what a tag refers to."""
        values = dict(attributes)
        self.anchors |= {values[key] for key in ("id", "name") if values.get(key)}
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in ("script", "img") and values.get("src"):
            self.loaded.append(values["src"])
        if tag == "link" and values.get("rel") != "canonical":
            self.loaded.append(values["href"])


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole site, once for all of pytest's processes; most units without their diagram, for time."""
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root

    def make(folder: Path) -> None:
        build_site(folder / "site", lambda unit: diagram(unit) if unit.name in DRAWN else "")

    return build_once(root, "docs", make) / "site"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[str, Page]:
    """Every page by its place."""
    return {str(path.relative_to(site)): Page(path.read_text()) for path in sorted(site.rglob("*.html"))}


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files and says nothing."""

    def log_message(self, *arguments: object) -> None:
        """Nothing."""


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """The site on a loopback port."""
    handler = functools.partial(QuietHandler, directory=str(site))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    with open_chromium() as opened:
        yield opened


def test_no_link_is_dead(pages: dict[str, Page]) -> None:
    dead = []
    for name, page in pages.items():
        # The page for what is not found is served from anywhere.
        for link in [] if name == "404.html" else page.links:
            target, anchor = urldefrag(urljoin(name, unquote(link)))
            if "://" in target or target.startswith("mailto:"):
                continue
            target = f"{target}index.html" if target.endswith("/") or not target else target
            if target not in pages or (anchor and anchor not in pages[target].anchors):
                dead.append(f"{name}: {link}")
    assert not dead, "\n" + "\n".join(dead)


def test_nothing_is_loaded_from_elsewhere(site: Path, pages: dict[str, Page]) -> None:
    for name, page in pages.items():
        for source in page.loaded:
            assert "://" not in source, (name, source)
            assert name == "404.html" or (site / urljoin(name, unquote(source))).is_file(), (name, source)


def test_every_page_of_the_documentation_is_in_the_navigation(pages: dict[str, Page], site: Path) -> None:
    text = (site / "index.html").read_text()
    listed = {urljoin("index.html", unquote(link)) for link in Page(text).links}
    for path in (ROOT / "docs").rglob("*.md"):
        place = path.relative_to(ROOT / "docs").with_suffix(".html")
        place = place.with_name("index.html") if path.name == "README.md" else place
        assert str(place) in listed | {"index.html"}, f"{path} is in no menu"


def test_pages_are_readable(browser: webdriver.Chrome, address: str, pages: dict[str, Page]) -> None:
    """No page is wider than its window, none has an error on the console."""
    faults = []
    seed = int(os.environ.get("QUADSHADE_SEED", "1"))
    for number, name in enumerate(pages):
        if name == "404.html" or name.startswith("source/"):
            continue
        if name.startswith(ALIKE) and (number + seed) % EVERY:
            continue
        browser.get(address + name)
        # What fits into the narrow window is rarely too wide for the other: one of EVERY is shown in both.
        for width in WIDTHS[: 1 + (number % EVERY == 0)]:
            metrics = {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
            # The menus take a moment to fold.
            with contextlib.suppress(TimeoutException):
                WebDriverWait(browser, 3, poll_frequency=0.05).until(
                    lambda opened, most=width: opened.execute_script(WIDE) <= most
                )
                continue
            faults.append(f"{name}: {browser.execute_script(WIDE)} pixels wide in a window of {width}")
        for entry in browser.get_log("browser"):
            if "favicon.ico" not in entry["message"]:
                faults.append(f"{name}: {entry['message']}")
    assert not faults, "\n" + "\n".join(faults)


def test_search_finds_a_unit(browser: webdriver.Chrome, address: str) -> None:
    metrics = {"width": 1400, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.get(address + "reference/cli.html")
    field = browser.find_element(By.CSS_SELECTOR, "input.md-search__input")
    field.click()
    field.send_keys("edge_dda")
    links = WebDriverWait(browser, 20).until(
        lambda opened: opened.find_elements(By.CSS_SELECTOR, "a.md-search-result__link")
    )
    assert "/reference/units/edge_dda.html" in links[0].get_attribute("href")


def test_command_line_page_has_every_command(site: Path) -> None:
    text = (site / "reference" / "cli.html").read_text()
    for name in COMMANDS:
        assert f'id="quadshade-{name}"' in text


def test_a_line_may_end_between_the_choices_of_an_option() -> None:
    """One code for all of them is wider than the page, because identifiers in tables stay whole."""
    page = command_line_page()
    assert "| `--shading` | `flat`, `gouraud`, `quadratic`, " in page
    assert all(len(value) < 40 for value in re.findall(r"^\| .* \| `([^`]*)`", page, re.MULTILINE))


def test_unit_pages_have_every_port(site: Path) -> None:
    """Each name that stands before a colon in the entity."""
    for name, unit in units().items():
        text = (site / "reference" / "units" / f"{name}.html").read_text()
        (entity,) = re.findall(rf"^entity {name} is\n(.*?)^end entity", unit.text, re.MULTILINE | re.DOTALL)
        code = re.sub(r"--.*", "", entity)
        names = [
            each.split()[-1] for group in re.findall(r"([\w, \n]+) : ", code) for each in group.split(",")
        ]
        assert {"clk", "aclk"} & set(names) or name in ("load_adder", "output_clamp")
        for each in names:
            assert f"<code>{each}</code>" in text, (name, each)


def test_unit_pages_say_what_generics_mean_and_keep_powers(site: Path) -> None:
    page = (site / "reference" / "units" / "raster_core.html").read_text()
    assert GENERIC_HELP["span_depth"] in page
    clamp = (site / "reference" / "units" / "output_clamp.html").read_text()
    assert "2**frac_bits" in clamp and "2**value_bits" in clamp


def test_python_pages_show_names_without_their_roles(site: Path) -> None:
    pages = list((site / "reference" / "python").glob("*.html"))
    assert pages
    for page in pages:
        assert not re.search(r":(func|class|meth|data|attr|mod):", page.read_text()), page.name


def test_diagrams_name_what_there_is() -> None:
    """A window's ports, test and settings exist in the unit and in its tests."""
    all_units = units()
    for name, window in windows().items():
        ports = {port.name for port in all_units[name].ports}
        assert set(window.ports) | ({window.start} if window.start else set()) <= ports, name
        assert window.simulated > window.clocks
        module = import_module(module_of(name))
        module.Config(**window.config)


def test_a_diagram_shows_what_the_model_says() -> None:
    """The simulated ports of ``edge_dda`` are those of its model, clock by clock."""
    window = windows()["edge_dda"]
    values = ports_per_clock(units()["edge_dda"], window.config, window.test, 60)
    formats = Formats(**window.config)
    model, compared = None, 0
    columns: list[int | None] = [None, None]
    for clock in range(len(values["clk"])):
        assert columns[0] is None or int(values["column"][clock], 2) == columns[0]
        compared += columns[0] is not None
        if values["enable"][clock] == "1":
            if values["load"][clock] == "1":
                fields = ("column", "error", "step", "increment", "decrement")
                words = {f"major_{field}": int(values[f"load_{field}"][clock], 2) for field in fields}
                model = EdgeDda(words, "major", formats)
            columns = [columns[1], model.column if model else None]
            if model:
                model.step()
    assert compared > 40


def test_drawings_are_as_their_description_says() -> None:
    assert not drawings.outdated(), "run `python -m scripts.docs.drawings`"


@pytest.mark.parametrize("stage", ["core", "shade", "screen", "link"])
def test_a_drawing_has_every_unit_of_its_folder(stage: str) -> None:
    """But those that only a unit of the same folder instantiates as an operator of its own."""
    given = drawings.descriptions()[stage]
    names = {name.strip() for name, *_ in given["boxes"]} | {
        title.split(":")[0] for title, *_ in given["groups"]
    }
    members = {unit.name for unit in units().values() if unit.stage == stage}
    assert members - names <= {"raster_core", "render_core", "load_adder", "vertex_alu"}

# SPDX-License-Identifier: Apache-2.0
"""The report in headless Chromium: it loads, its controls work, every number in it is that of the data."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

import pytest
from click.testing import CliRunner
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.select import Select

from quadshade.errors import QuadshadeError
from quadshade.trade import pareto_front
from quadshade.trade.grid import DEFAULT_SHADINGS, SUBDIVISIONS, USUAL_SHADINGS
from quadshade.trade.page import __main__ as report
from quadshade.trade.page import build_page
from quadshade.trade.page.papers import BARRERA, SETUPS
from tests.support.chromium import open_chromium

SCENES = ("sphere:168", "torus:288")
ARGUMENTS = ("--size", "48", "--jobs", "1", "--no-area", "--fraction", "8", "--fraction", "22")
PER_FRACTION = len(USUAL_SHADINGS) * len(SUBDIVISIONS) + len(DEFAULT_SHADINGS) - len(USUAL_SHADINGS)
"""Points of a sweep: adaptive ones choose the division themselves."""

VALUE = """
return [...document.querySelectorAll('[data-path]')].map(
  (e) => [e.dataset.file, e.dataset.path, e.textContent])
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small report."""
    output = tmp_path_factory.mktemp("report")
    scenes = [part for scene in SCENES for part in ("--scene", scene)]
    run = CliRunner().invoke(report.main, [*ARGUMENTS, *scenes, "--output", str(output)])
    assert run.exit_code == 0, run.output
    # Cells are not counted here; numbers in their place show that their column is the data's.
    for path in output.glob("data/*/trade.json"):
        content = json.loads(path.read_text())
        content |= {"device": "somewhere", "notice": ""}
        for index, point in enumerate(content["points"]):
            point["lut4"] = 1000 + 37 * index
        path.write_text(json.dumps(content))
    names = [scene.replace(":", "-") for scene in SCENES]
    build_page(output, report.ROOT / "docs" / "reports", report.ROOT / "synth" / "resources.json", names)
    return output


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    with open_chromium() as opened:
        opened.set_window_size(1200, 2000)
        yield opened


@pytest.fixture
def page(browser: webdriver.Chrome, folder: Path) -> webdriver.Chrome:
    """The page, loaded afresh from disk."""
    browser.get((folder / "index.html").as_uri())
    yield browser
    errors = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    assert not errors, errors


def one(page: webdriver.Chrome, selector: str):
    return page.find_element(By.CSS_SELECTOR, selector)


def all_of(page: webdriver.Chrome, selector: str) -> list:
    return page.find_elements(By.CSS_SELECTOR, selector)


def click(page: webdriver.Chrome, selector: str) -> None:
    page.execute_script("arguments[0].click()", one(page, selector))


def source(page: webdriver.Chrome, selector: str) -> str:
    return page.execute_script("return arguments[0].getAttribute('src')", one(page, selector))


def shows(text: str, value) -> bool:
    """Whether a text is a value, numbers rounded to the digits that the text has."""
    if isinstance(value, bool):
        return text == ("yes" if value else "no")
    if isinstance(value, str):
        return text == value
    plain = text.replace("\u2009", "")
    if isinstance(value, int) and "." not in plain and "e" not in plain:
        return plain == str(value)
    shown = Decimal(plain)
    unit = Decimal(1).scaleb(shown.as_tuple().exponent)
    return abs(Decimal(value) - shown) <= unit / 2 * (1 + Decimal("1e-9"))


def wrong_values(page: webdriver.Chrome, folder: Path) -> tuple[int, list]:
    """How many values the page shows, and those that are not what stands in their files."""
    wrong, shown = [], page.execute_script(VALUE)
    files = {file: json.loads((folder / file).read_text()) for file in {file for file, _, _ in shown}}
    for file, path, text in shown:
        value = files[file]
        for key in json.loads(path):
            value = value[key]
        if not shows(text, value):
            wrong.append((file, path, text, value))
    return len(shown), wrong


def test_values_are_compared() -> None:
    assert shows("12.3", 12.34)
    assert not shows("12.4", 12.34)
    assert shows("176\u2009064", 176064)
    assert not shows("176\u2009065", 176064)
    assert shows("1.20e+7", 12001234.5)
    assert not shows("flat", "gouraud")
    assert shows("yes", True)
    assert not shows("yes", False)


def test_every_number_is_the_datas(page: webdriver.Chrome, folder: Path) -> None:
    for button in range(len(SCENES)):
        page.execute_script(f"document.querySelectorAll('#scenes button')[{button}].click()")
        count, wrong = wrong_values(page, folder)
        assert count > 500
        assert not wrong, wrong[:10]
        # Cells of tables without a mark hold no digit.
        cells = page.execute_script(
            "return [...document.querySelectorAll('td')].map((e) => "
            "{ const c = e.cloneNode(true); c.querySelectorAll('[data-path]').forEach((x) => x.remove());"
            " return c.textContent; })"
        )
        assert not [text for text in cells if re.search("[0-9]", text)]


def test_a_changed_number_is_found(page: webdriver.Chrome, folder: Path) -> None:
    page.execute_script("const e = document.querySelector('#steps-table [data-path]'); e.textContent += '1';")
    assert len(wrong_values(page, folder)[1]) == 1


def test_scenes(page: webdriver.Chrome, folder: Path) -> None:
    before = one(page, "#steps-table").text
    click(page, "#scenes button:nth-child(2)")
    assert one(page, "#scenes button:nth-child(2)").get_attribute("aria-pressed") == "true"
    assert one(page, "#steps-table").text != before
    assert source(page, "#picture-left").startswith("data/torus-288/points/")
    assert (folder / source(page, "#picture-left")).is_file()


def test_wipe(page: webdriver.Chrome) -> None:
    def clip() -> str:
        return page.execute_script("return document.getElementById('picture-left').style.clipPath")

    assert "64%" in clip()
    page.execute_script(
        "const w = document.getElementById('wipe'); w.value = 80; w.dispatchEvent(new Event('input'));"
    )
    assert "20%" in clip()
    click(page, "#flip")
    assert "0%" in clip()
    assert "20%" not in clip()
    click(page, "#flip")
    stage = one(page, "#stage")
    actions = webdriver.ActionChains(page)
    actions.move_to_element(stage).click_and_hold().move_by_offset(-int(stage.rect["width"] / 4), 0).release()
    actions.perform()
    wipe = float(page.execute_script("return state.wipe"))
    assert 24 < wipe < 26


def test_methods(page: webdriver.Chrome, folder: Path) -> None:
    left, right = source(page, "#picture-left"), source(page, "#picture-right")
    assert "gouraud-22-none" in left
    assert "quadratic-22-none" in right
    click(page, "#swap")
    assert (source(page, "#picture-left"), source(page, "#picture-right")) == (right, left)
    click(page, "#errors")
    assert source(page, "#picture-left") == right.replace("picture.png", "error.png")
    click(page, "#errors")
    for place, value, part in (
        (0, "flat", "flat-22-none"),
        (1, "all:1", "flat-22-all1"),
        (2, "8", "flat-8-all1"),
    ):
        Select(all_of(page, "#right-side select")[place]).select_by_value(value)
        assert part in source(page, "#picture-right")
        assert (folder / source(page, "#picture-right")).is_file()
        assert not wrong_values(page, folder)[1]
    Select(all_of(page, "#right-side select")[0]).select_by_value("phong")
    assert source(page, "#picture-right").endswith("phong-all1.png")
    Select(all_of(page, "#right-side select")[0]).select_by_value("adaptive:1")
    assert "adaptive1-8-none" in source(page, "#picture-right")
    Select(all_of(page, "#right-side select")[1]).select_by_value("all:1")
    assert "adaptive1-8-none" in source(page, "#picture-right")
    Select(all_of(page, "#right-side select")[0]).select_by_value("phong")
    assert "reference" in one(page, "#right-side p").text


def test_pictures_are_there(page: webdriver.Chrome, folder: Path) -> None:
    names = page.execute_script("return [...document.images].map((i) => i.getAttribute('src'))")
    assert len(names) > 15
    assert not [name for name in names if not (folder / name).is_file()]
    sizes = page.execute_script(
        "return ['left', 'right'].map((s) => document.getElementById('picture-' + s).naturalWidth)"
    )
    assert sizes == [48, 48]


def test_maps(page: webdriver.Chrome, folder: Path) -> None:
    records = json.loads((folder / "data" / "sphere-168" / "trade.json").read_text())["points"]
    finest = [record for record in records if record["fraction"] == 22]
    before = page.execute_script("return [...document.querySelectorAll('#map-grid img')].map((i) => i.src)")
    assert len(before) == len(finest) == PER_FRACTION
    Select(one(page, "#map-fraction")).select_by_value("8")
    after = page.execute_script("return [...document.querySelectorAll('#map-grid img')].map((i) => i.src)")
    assert len(after) == len(records) - len(finest) == PER_FRACTION
    assert not set(before) & set(after)


@pytest.mark.parametrize("x", ["bytes", "clocks", "lut4"])
def test_fronts(page: webdriver.Chrome, folder: Path, x: str) -> None:
    """What is drawn as the front is what the sweep has marked, and filters take dots away."""
    Select(one(page, "#axis-x")).select_by_value(x)
    records = json.loads((folder / "data" / "sphere-168" / "trade.json").read_text())["points"]
    dots = all_of(page, "#plot .dot")
    assert len(dots) == len(records) == 2 * PER_FRACTION
    drawn = page.execute_script(
        "return [...document.querySelectorAll('#plot .on-front')].map((d) => Number(d.dataset.index))"
    )
    front = pareto_front([record[x] for record in records], [record["rms"] for record in records])
    assert sorted(drawn) == [index for index, best in enumerate(front) if best]
    if x != "lut4":
        assert sorted(drawn) == [i for i, record in enumerate(records) if x in record["pareto"]]
    click(page, "[data-filter=shading][value=flat]")
    rest = [record for record in records if record["shading"] != "flat"]
    assert len(all_of(page, "#plot .dot")) == len(rest) == 2 * (PER_FRACTION - len(SUBDIVISIONS))
    click(page, "[data-filter=fraction][value='8']")
    assert len(all_of(page, "#plot .dot")) == PER_FRACTION - len(SUBDIVISIONS)
    click(page, "[data-filter=shading][value=flat]")
    assert len(all_of(page, "#plot .dot")) == PER_FRACTION


def test_axes_and_a_chosen_dot(page: webdriver.Chrome, folder: Path) -> None:
    places = "return [...document.querySelectorAll('#plot .dot')].map((d) => d.getAttribute('d')).join()"
    before = page.execute_script(places)
    for y in ("psnr", "max_error"):
        Select(one(page, "#axis-y")).select_by_value(y)
        assert page.execute_script(places) != before
    index = 29
    page.execute_script(
        f"document.querySelector('.dot[data-index=\"{index}\"]').dispatchEvent(new MouseEvent('click'))"
    )
    record = json.loads((folder / "data" / "sphere-168" / "trade.json").read_text())["points"][index]
    assert one(page, "#chosen b").text == record["name"]
    assert source(page, "#picture-left") == f"data/sphere-168/{record['picture']}"
    assert one(page, ".is-chosen").get_attribute("data-index") == str(index)


def test_missing_reports_name_their_command(page: webdriver.Chrome, folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    build_page(copy, tmp_path / "nowhere", tmp_path / "none.json", ["sphere-168"])
    (copy / "data" / "resources.json").unlink(missing_ok=True)
    page.get((copy / "index.html").as_uri())
    notes = " ".join(note.text for note in all_of(page, ".missing"))
    for command in ("make stability", "make throughput", "make hostspeed"):
        assert command in notes
    assert not wrong_values(page, copy)[1]


def test_plots_are_shown_without_their_numbers(page: webdriver.Chrome, folder: Path, tmp_path: Path) -> None:
    copy, reports = tmp_path / "copy", tmp_path / "reports"
    shutil.copytree(folder, copy)
    reports.mkdir()
    shutil.copyfile(report.ROOT / "docs" / "reports" / "stability.png", reports / "stability.png")
    build_page(copy, reports, tmp_path / "none.json", ["sphere-168"])
    page.get((copy / "index.html").as_uri())
    section = page.find_element("id", "stability")
    assert "make stability" in section.text
    (figure,) = section.find_elements("tag name", "img")
    assert figure.get_attribute("src").endswith("data/stability.png")


def test_papers_are_as_printed(folder: Path) -> None:
    tables = json.loads((folder / "data" / "papers.json").read_text())
    assert [row["paper_seconds"] for row in tables["barrera"]] == [40.6, 42.0, 49.4, 40.3, 12.7]
    speed = json.loads((folder / "data" / "hostspeed.json").read_text())["setups"]
    for row, (_, _, ours) in zip(tables["barrera"], BARRERA, strict=True):
        assert row["our_seconds"] == (None if ours is None else SETUPS / speed[ours])
    assert tables["abbas"][0]["frames_per_second"] == 20


def test_a_missing_sweep_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(QuadshadeError, match="there is no .*trade.json; run `quadshade trade`"):
        build_page(tmp_path, tmp_path, tmp_path / "none.json", ["sphere-168"])


def test_screenshot(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = [part for scene in SCENES for part in ("--scene", scene)]
    monkeypatch.setenv("CHROMIUM", "/nowhere/chromium")
    arguments = [*ARGUMENTS, *scenes, "--output", str(tmp_path), "--screenshot", str(tmp_path / "page.png")]
    shutil.copytree(folder / "data", tmp_path / "data")
    run = CliRunner().invoke(report.main, arguments)
    assert run.exit_code == 2
    points = 2 * PER_FRACTION
    assert f"{points} points, {points} from before" in run.output
    assert run.output.splitlines()[-1] == "report: error: chromium is not installed; run `make setup`"
    assert not os.path.exists(tmp_path / "page.png")

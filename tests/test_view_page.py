# SPDX-License-Identifier: Apache-2.0
"""The page of ``quadshade view`` in headless Chromium, with real mouse and key events."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

from quadshade.view import Viewed, ViewState
from tests.support.chromium import open_chromium
from tests.support.served_view import SMALL, Served, orange_torus


@pytest.fixture(scope="module")
def viewed() -> Viewed:
    return orange_torus()


@pytest.fixture(scope="module")
def served(viewed: Viewed) -> Iterator[Served]:
    running = Served(viewed)
    yield running
    running.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    with open_chromium() as opened:
        yield opened


def settled(browser: webdriver.Chrome) -> ViewState:
    """The state that is drawn and measured, when nothing moves any more."""
    asked = "return JSON.stringify(state)"

    def done(_: webdriver.Chrome) -> bool:
        drawn = browser.execute_script("return document.body.dataset.drawn")
        measured = browser.execute_script("return document.body.dataset.measured")
        return measured == "true" and json.loads(drawn) == json.loads(browser.execute_script(asked))

    WebDriverWait(browser, 60, 0.1).until(done)
    return ViewState.read(json.loads(browser.execute_script(asked)))


def canvas(browser: webdriver.Chrome) -> np.ndarray:
    """(height, width, 3) pixels that the page shows."""
    script = """const c = document.getElementById("picture");
      const d = c.getContext("2d").getImageData(0, 0, c.width, c.height);
      return [c.width, c.height, Array.from(d.data)];"""
    width, height, data = browser.execute_script(script)
    return np.array(data, dtype=np.uint8).reshape(height, width, 4)[..., :3]


def test_the_page_shows_what_the_hand_does(served: Served, browser: webdriver.Chrome, viewed: Viewed) -> None:
    browser.set_window_size(1400, 900)
    browser.get(served.server.link)
    start = settled(browser)
    assert start == ViewState.read(SMALL)
    picture, ball = browser.find_element(By.ID, "picture"), browser.find_element(By.ID, "ball")

    def expect(**changed: Any) -> ViewState:
        """The state is as it should be, and the pixels are those of the state."""
        state = settled(browser)
        for name, value in changed.items():
            assert getattr(state, name) == pytest.approx(value, abs=1e-6), name
        shown = viewed.show(state, True)
        assert (canvas(browser) == shown.image).all()
        for name in ("triangles", "bytes", "line_bytes", "clocks", "largest_error"):
            figure = browser.find_element(By.ID, f"figure-{name}").text.replace(",", "")
            assert figure == str(shown.figures[name]), name
        assert browser.find_element(By.ID, "command").get_attribute("value") == shown.figures["command"]
        return state

    expect()
    ActionChains(browser).click_and_hold(picture).move_by_offset(60, -20).release().perform()
    turned = expect(yaw=start.yaw - 30, pitch=start.pitch - 10)
    ActionChains(browser).scroll_from_origin(
        webdriver.common.actions.wheel_input.ScrollOrigin.from_element(picture), 0, -120
    ).perform()
    expect(yaw=turned.yaw, zoom=1.1)
    ActionChains(browser).key_down(Keys.SHIFT).click_and_hold(picture).move_by_offset(25, 0).release().key_up(
        Keys.SHIFT
    ).perform()
    side = picture.size["width"] / 2 / 1.1
    expect(across=25 / side, along=0)
    ActionChains(browser).move_to_element(ball).move_by_offset(15, -10).click().perform()
    lit = expect(light=True)
    assert lit.light_x > 0.2 and lit.light_y > 0.1
    browser.execute_script("arguments[0].focus()", picture)
    ActionChains(browser).send_keys(Keys.ARROW_LEFT, Keys.ARROW_UP, "-").perform()
    expect(yaw=turned.yaw + 5, pitch=turned.pitch - 5, zoom=1)
    browser.execute_script("arguments[0].focus()", ball)
    ActionChains(browser).send_keys(Keys.ARROW_RIGHT).perform()
    expect(light_y=lit.light_y)
    Select(browser.find_element(By.ID, "shading")).select_by_value("gouraud")
    assert not browser.find_element(By.ID, "fit").is_enabled()
    expect(shading="gouraud")
    Select(browser.find_element(By.ID, "shading")).select_by_value("quadratic")
    browser.find_element(By.ID, "lod").send_keys(Keys.ARROW_LEFT * 4)
    expect(lod=len(viewed.mesh) // 2)
    assert browser.find_element(By.CSS_SELECTOR, "#lod + output").text == str(len(viewed.mesh) // 2)
    browser.find_element(By.ID, "lod").send_keys(Keys.END)
    expect(lod=0)
    frame_ms = browser.find_element(By.ID, "frame_ms")
    frame_ms.send_keys(Keys.ARROW_RIGHT * 3)
    shown = viewed.show(expect(frame_ms=30), False)
    assert browser.find_element(By.ID, "figure-levers").text == shown.figures["levers"]
    frame_ms.send_keys(Keys.HOME)
    expect(frame_ms=0)
    browser.find_element(By.ID, "max_error").send_keys(Keys.ARROW_RIGHT * 8)
    expect(max_error=4)
    Select(browser.find_element(By.ID, "map")).select_by_value("orders")
    orders = expect(map="orders")
    assert "linear" in browser.find_element(By.ID, "legend").text
    link = browser.current_url
    browser.get("about:blank")
    browser.get(link)
    assert settled(browser) == orders
    browser.find_element(By.ID, "reset").click()
    expect(**start.content() | {"map": "picture"})
    # Chromium advises this test, which reads the canvas often; the page does not.
    assert [entry for entry in browser.get_log("browser") if entry["source"] != "rendering"] == []


def test_the_page_fits_a_phone(served: Served, browser: webdriver.Chrome) -> None:
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": False},
    )
    browser.get(served.server.link)
    settled(browser)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= 400
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_page_says_that_the_server_has_ended(viewed: Viewed, browser: webdriver.Chrome) -> None:
    other = Served(viewed)
    browser.get(other.server.link)
    settled(browser)
    other.close()
    WebDriverWait(browser, 20, 0.1).until(lambda _: "has ended" in browser.find_element(By.ID, "status").text)

# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium for pages, which keeps what its console says."""

from __future__ import annotations

import shutil

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from quadshade.trade.page.screenshot import find_chromium


def open_chromium() -> webdriver.Chrome:
    """A browser, to be closed after use."""
    options = webdriver.ChromeOptions()
    options.binary_location = find_chromium()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = shutil.which("chromedriver")
    assert driver, "chromedriver is not installed: run `make setup`"
    return webdriver.Chrome(options, Service(driver))

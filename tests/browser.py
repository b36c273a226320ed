"""A browser without a screen, for the tests that look at pages."""

import shutil

import pytest

__all__ = ["driven"]


def driven(arguments):
    """Yield a Chromium that selenium drives, and end it; tests that need one skip where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver")
    names = ("chromium", "chromium-browser", "google-chrome")
    program, driver = next(filter(None, map(shutil.which, names)), None), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no Chromium that can be driven: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in arguments.split():
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = pytest.importorskip("selenium.webdriver.chrome.service").Service(driver)
    found = webdriver.Chrome(options=options, service=service)
    yield found
    found.quit()

"""A browser that is waited for: until something is so, and never for a time that a busy machine does not keep."""

import time

# Only what hangs takes so long.
TIMEOUT_S = 600


def launched(playwright, chromium, *more):
    """The browser, without a window."""
    arguments = ["--no-sandbox", *more]
    return playwright.chromium.launch(
        executable_path=chromium, args=arguments, timeout=TIMEOUT_S * 1000
    )


def new_page(browser, **options):
    page = browser.new_page(**options)
    page.set_default_timeout(TIMEOUT_S * 1000)
    return page


def settled(page, condition):
    """Waits for a condition, which the page's policy lets only the browser itself evaluate."""
    end = time.monotonic() + TIMEOUT_S
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"not within {TIMEOUT_S} s: {condition}"
        page.wait_for_timeout(20)

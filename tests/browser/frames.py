"""Measures how smoothly a report moves, in a browser without a window.

Usage: frames.py CHROMIUM REPORT

Prints, a line each, how long the report took to open, and of a run that is played: the time that the
report's script takes for a frame, and the time from frame to frame.
"""

import statistics
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

from waiting import launched, new_page

CHROMIUM, REPORT = sys.argv[1], Path(sys.argv[2]).resolve()
N_FRAMES = 120
# Before the report's own script: what it does in each frame is timed.
TIMED = """
window.frames_ms = { script: [], between: [] };
const request = window.requestAnimationFrame.bind(window);
let last_ms = null;
window.requestAnimationFrame = (draw) => request((now_ms) => {
    const begin_ms = performance.now();
    draw(now_ms);
    window.frames_ms.script.push(performance.now() - begin_ms);
    if (last_ms !== null) window.frames_ms.between.push(now_ms - last_ms);
    last_ms = now_ms;
});
"""


def played(browser):
    """The times of the frames of the first run, in milliseconds."""
    page = new_page(browser, viewport={"width": 1280, "height": 900})
    page.add_init_script(TIMED)
    page.goto(REPORT.as_uri())
    run = page.locator("#run-0")
    run.scroll_into_view_if_needed()
    page.locator("#run-0-player canvas").scroll_into_view_if_needed()
    # The replay of a cell, which plays by itself, is out of sight by now.
    page.evaluate("document.activeElement.blur()")
    page.locator("#run-0-player .time").focus()
    # In the middle of the run every trail has its whole length.
    page.eval_on_selector(
        "#run-0-player .time",
        "slider => { slider.value = slider.max / 2; slider.dispatchEvent(new Event('input')); }",
    )
    # So slow that the run does not end before enough frames are drawn, however busy the machine.
    page.locator("#run-0-player .speed").select_option("1")
    page.locator("#run-0-player .play").click()
    page.evaluate("window.frames_ms.script.length = window.frames_ms.between.length = 0")
    while (n_frames := page.evaluate("window.frames_ms.script.length")) < N_FRAMES:
        is_playing = page.locator("#run-0-player .play").inner_text() == "Pause"
        assert is_playing, f"the run ended after {n_frames} frames"
        page.wait_for_timeout(100)
    return page.evaluate("window.frames_ms")


def opened_ms(browser):
    page = new_page(browser)
    page.goto(REPORT.as_uri())
    page.wait_for_selector("#cell-player canvas")
    return page.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd")


def in_words(times_ms):
    centiles = statistics.quantiles(times_ms, n=100)
    return "median %.2f ms, 95 %% %.2f ms" % (statistics.median(times_ms), centiles[94])


def main():
    with sync_playwright() as playwright:
        browser = launched(playwright, CHROMIUM)
        print("opened in %d ms" % opened_ms(browser))
        times_ms = played(browser)
        browser.close()
    print("script per frame:", in_words(times_ms["script"]))
    print("from frame to frame:", in_words(times_ms["between"]))
    print("all is well")


main()

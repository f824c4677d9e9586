"""Reads a report as a person does, in a browser without a window.

Usage: report.py CHROMIUM REPORT SCREENSHOTS

Prints what was found, a line each; any failure ends it with a message.
"""

import sys
from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

from waiting import launched, new_page, settled

CHROMIUM, REPORT, SCREENSHOTS = sys.argv[1], Path(sys.argv[2]).resolve(), Path(sys.argv[3])
WIDTHS = {400: 800, 1280: 900, 3840: 2160}


def opened(browser, width, theme, motion):
    """The report on a screen, and what its console printed."""
    viewport = {"width": width, "height": WIDTHS[width]}
    page = new_page(browser, viewport=viewport, color_scheme=theme, reduced_motion=motion)
    printed, asked = [], []
    page.on("console", lambda message: printed.append(message.text))
    page.on("pageerror", lambda error: printed.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(REPORT.as_uri())
    page.wait_for_selector("#cell-player canvas")
    return page, printed, asked


def pixels(page, selector):
    return page.eval_on_selector(selector, "canvas => canvas.toDataURL()")


def time_of(page, player):
    return float(page.eval_on_selector(f"{player} .time", "slider => slider.value"))


def check_looks(page, width, theme):
    """Nothing wider than the screen, nothing that an accessibility checker finds."""
    over = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    assert over <= 0, f"{over} px too wide at {width} px"
    page.evaluate("document.querySelectorAll('details').forEach(it => it.open = true)")
    found = Axe().run(page)
    assert found.violations_count == 0, f"{width} px, {theme}:\n{found.generate_report()}"
    page.evaluate("document.querySelectorAll('details').forEach(it => it.open = false)")
    ink, paper = page.evaluate(
        "(style => [style.color, style.backgroundColor])(getComputedStyle(document.body))"
    )
    is_dark = sum(map(int, paper.removeprefix("rgb(").removesuffix(")").split(","))) < 300
    assert is_dark == (theme == "dark"), f"{theme}: {ink} on {paper}"


def check_cells(page):
    """Pointing at a cell, tapping it and going to it by keys show its facts."""
    cells = page.locator("[role=gridcell]")
    n_cells = cells.count()
    assert n_cells == page.locator(".facts").count(), "each cell has its facts"
    shown = "document.querySelector('.facts:not([hidden])').id"
    for index in range(0, n_cells, 5):
        name = cells.nth(index).get_attribute("data-cell")
        cells.nth(index).hover()
        settled(page, f"{shown} === 'cell-{name}'")
    cells.first.click()
    settled(page, f"{shown} === 'cell-{cells.first.get_attribute('data-cell')}'")
    cells.first.focus()
    before = page.evaluate(shown)
    page.keyboard.press("ArrowRight")
    settled(page, f"{shown} !== '{before}'")
    page.keyboard.press("ArrowLeft")
    settled(page, f"{shown} === '{before}'")
    page.keyboard.press("ArrowDown")
    settled(page, f"{shown} !== '{before}'")
    assert page.locator("[role=gridcell][tabindex='0']").count() == 1
    assert page.locator("[role=gridcell][aria-selected=true]").count() == 1
    return n_cells


def check_player(page, player):
    """It plays by its button and by keys, and follows its slider and its speed."""
    page.locator(player.removesuffix("-player")).scroll_into_view_if_needed()
    settled(page, f"document.querySelector('{player} .time').max > 1")
    if page.locator(f"{player} .play").inner_text() == "Pause":
        page.locator(f"{player} .play").click()
    slider = page.locator(f"{player} .time")
    slider.focus()
    page.keyboard.press("Home")
    before = pixels(page, f"{player} canvas")
    page.locator(f"{player} .play").focus()
    page.keyboard.press("k")
    settled(page, f"document.querySelector('{player} .time').value > 1")
    page.keyboard.press("k")
    assert page.locator(f"{player} .play").inner_text() == "Play"
    assert pixels(page, f"{player} canvas") != before, f"{player} does not move"
    at = time_of(page, player)
    page.wait_for_timeout(200)
    assert time_of(page, player) == at, f"{player} does not pause"
    slider.focus()
    page.keyboard.press("Home")
    at_start = pixels(page, f"{player} canvas")
    assert time_of(page, player) == 0
    page.keyboard.press("l")
    assert abs(time_of(page, player) - 5) < 0.01 and pixels(page, f"{player} canvas") != at_start
    page.keyboard.press("j")
    assert pixels(page, f"{player} canvas") == at_start, "the same time is the same picture"
    page.locator(f"{player} .speed").select_option("50")
    page.locator(f"{player} .play").focus()
    page.keyboard.press("Space")
    settled(page, f"document.querySelector('{player} .time').value > 10")
    page.keyboard.press("Space")
    # A run may have come to its end before the key was pressed, and begun again.
    settled(page, f"document.querySelector('{player} .play').textContent === 'Play'")


def check_loop(page):
    """The replay of a cell begins again at its end, that of a run stops there."""
    player = "#cell-player"
    page.locator(f"{player} .time").focus()
    page.keyboard.press("End")
    end = time_of(page, player)
    page.keyboard.press("k")
    settled(page, f"document.querySelector('{player} .time').value < {end} - 1")
    page.keyboard.press("k")
    run = "#run-0-player"
    page.locator(f"{run} .time").focus()
    page.keyboard.press("End")
    page.keyboard.press("j")
    page.keyboard.press("k")
    settled(page, f"document.querySelector('{run} .play').textContent === 'Play'")
    assert abs(time_of(page, run) - float(page.locator(f"{run} .time").get_attribute("max"))) < 0.01


def check_simulator(page):
    """A cell opens in the simulator that lies in the report, under the conditions of the sweep."""
    button = page.locator(".facts:not([hidden]) .simulate")
    with page.expect_popup() as opening:
        button.click()
    simulator, printed = opening.value, []
    simulator.on("console", lambda message: printed.append(message.text))
    settled(simulator, "window.loaded_ms !== undefined")
    address = button.get_attribute("data-address")
    described = simulator.evaluate("simulated.describe()")
    for key, value in (part.split("=") for part in address.split("&")):
        assert key == "replicate" or described["values"][key] == float(value), address
    settled(simulator, "simulated.n_steps() > 10")
    assert printed == [] and not simulator.locator("#refusal").is_visible(), printed
    print("simulated:", address, described["digest"])
    simulator.close()


def frame_times_ms(page):
    return page.evaluate(
        """() => new Promise(done => {
            const times = [];
            let last = performance.now();
            requestAnimationFrame(function next(now) {
                times.push(now - last);
                last = now;
                if (times.length < 60) requestAnimationFrame(next);
                else done(times);
            });
        })"""
    )


def check_print(page):
    page.emulate_media(media="print", color_scheme="dark")
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == "rgb(255, 255, 255)", paper
    assert page.locator(".still").first.is_visible() and not page.locator(".controls").first.is_visible()
    pdf = page.pdf(format="A4", print_background=True)
    (SCREENSHOTS / "report.pdf").write_bytes(pdf)
    page.emulate_media(media="screen", color_scheme="light")
    return pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ")


def main():
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = launched(playwright, CHROMIUM)
        for width in WIDTHS:
            for theme in ["light", "dark"]:
                is_used = (width, theme) == (1280, "light")
                motion = "no-preference" if is_used else "reduce"
                page, printed, asked = opened(browser, width, theme, motion)
                check_looks(page, width, theme)
                page.screenshot(path=SCREENSHOTS / f"{width}_{theme}.png", full_page=width != 3840)
                if not is_used:
                    page.locator("[role=gridcell]").last.click()
                else:
                    print("cells:", check_cells(page))
                    for player in ["#cell-player", "#run-0-player"]:
                        check_player(page, player)
                    check_loop(page)
                    check_simulator(page)
                    times_ms = sorted(frame_times_ms(page))
                    print("median frame: %.0f ms" % times_ms[len(times_ms) // 2])
                    print("pages:", check_print(page))
                assert printed == [], printed
                assert asked == [REPORT.as_uri()], asked
                page.close()
        without = new_page(browser, java_script_enabled=False)
        without.goto(REPORT.as_uri())
        assert without.locator(".still").first.is_visible()
        assert not without.locator(".player").first.is_visible()
        loaded = new_page(browser)
        loaded.goto(REPORT.as_uri())
        print("loaded in %d ms" % loaded.evaluate(
            "performance.getEntriesByType('navigation')[0].loadEventEnd"))
        browser.close()
    print("all is well")


main()

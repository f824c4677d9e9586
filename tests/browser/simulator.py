"""Uses the page that simulates as a person does, in a browser without a window.

Usage: simulator.py CHROMIUM PAGE SCREENSHOTS FOLDER

Leaves the sweep file that the page copies in FOLDER, as `copied.yaml` with the replicates of the page's own
diagram, and what the page has counted there as `counts.csv`.
Prints what was found, a line each; any failure ends it with a message.
"""

import base64
import gzip
import json
import re
import statistics
import sys
from pathlib import Path

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

from waiting import launched, new_page, settled

CHROMIUM, PAGE = sys.argv[1], Path(sys.argv[2]).absolute()
SCREENSHOTS, FOLDER = Path(sys.argv[3]), Path(sys.argv[4])
WIDTHS = {400: 800, 1280: 900, 3840: 2160}
HTML = PAGE.read_text()


def inlined(name):
    return re.search(f'id="{name}">(.*?)</script>', HTML, re.DOTALL)[1]


# Before the page's own script: what it does in each frame is timed.
TIMED = """
window.frames_ms = [];
const request = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => request((now_ms) => {
    const begin_ms = performance.now();
    draw(now_ms);
    window.frames_ms.push(performance.now() - begin_ms);
});
"""
FACTS = json.loads(inlined("facts"))


def opened(browser, width=1280, theme="light", address="", calm=False):
    """The page on a screen, what its console printed, and what it asked for."""
    page = new_page(
        browser,
        viewport={"width": width, "height": WIDTHS[width]},
        color_scheme=theme,
        reduced_motion="reduce" if calm else "no-preference",
    )
    printed, asked = [], []
    page.on("console", lambda message: printed.append(message.text))
    page.on("pageerror", lambda error: printed.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(PAGE.as_uri() + address)
    settled(page, "window.loaded_ms !== undefined")
    return page, printed, asked


def least_loading_ms(browser):
    """Other programs make it longer, and nothing makes it shorter."""
    times_ms = []
    for _ in range(3):
        page, _, _ = opened(browser)
        times_ms.append(page.evaluate("window.loaded_ms"))
        page.close()
    return min(times_ms)


def frame_ms(browser):
    """What the page's script takes for a frame of many robots."""
    page = new_page(browser, viewport={"width": 1280, "height": 900})
    page.add_init_script(TIMED)
    cell = "speed_m_s=0.15&turn_rate_rad_s=0.75&robots=300&placement_radius_m=4.763"
    page.goto(f"{PAGE.as_uri()}#{cell}")
    settled(page, "window.frames_ms.length > 150")
    times_ms = page.evaluate("window.frames_ms.slice(-120)")
    page.close()
    return statistics.median(times_ms)


def said(page):
    return page.locator("#refusal").inner_text() if page.locator("#refusal").is_visible() else ""


def check_states(page):
    """The bits of the program, after as many steps as a run of 300 s has."""
    for state in FACTS["states"]:
        asked = f"{json.dumps(state['cell'])}, {state['replicate']}, {state['n_steps']}"
        digest = page.evaluate(f"simulated.state({asked})")
        assert digest == state["digest"], f"{state}: {digest}"
        print("state as in the program:", digest)


def check_looks(page, width, theme):
    """Nothing wider than the screen, nothing that an accessibility checker finds."""
    page.evaluate("document.querySelectorAll('details').forEach(it => it.open = true)")
    over = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    assert over <= 0, f"{over} px too wide at {width} px"
    found = Axe().run(page)
    assert found.violations_count == 0, f"{width} px, {theme}:\n{found.generate_report()}"
    page.evaluate("document.querySelectorAll('details').forEach(it => it.open = false)")
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    is_dark = sum(map(int, paper.removeprefix("rgb(").removesuffix(")").split(","))) < 300
    assert is_dark == (theme == "dark"), f"{theme}: {paper}"


def check_keys(page):
    """The space bar pauses, cells and sliders are reached by keys."""
    page.locator("body").click(position={"x": 5, "y": 5})
    page.keyboard.press("Space")
    assert page.locator("#play").inner_text() == "Play"
    n_steps = page.evaluate("simulated.n_steps()")
    page.wait_for_timeout(200)
    assert page.evaluate("simulated.n_steps()") == n_steps, "it does not pause"
    page.keyboard.press("k")
    settled(page, f"simulated.n_steps() > {n_steps}")

    page.locator("#speed_m_s").focus()
    page.keyboard.press("ArrowRight")
    values = page.evaluate("simulated.describe().values")
    assert abs(values["speed_m_s"] - 0.155) < 1e-9, values
    settled(page, "location.hash.includes('speed_m_s=0.155')")
    page.keyboard.press("ArrowLeft")

    chosen = "[role=gridcell][aria-selected=true]"
    page.locator(chosen).focus()
    before = page.locator(chosen).get_attribute("data-at")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    assert page.locator(chosen).get_attribute("data-at") != before
    values = page.evaluate("simulated.describe().values")
    assert (values["speed_m_s"], values["turn_rate_rad_s"]) == (0.175, 1), values
    assert page.locator("[role=gridcell][tabindex='0']").count() == 1


def check_copies(page):
    """What cannot be simulated is not in the sweep file, which is shown while it is open."""
    page.locator("summary", has_text="The sweep file").click()
    settled(page, "document.getElementById('sweep').textContent.includes('axes:')")
    page.locator("#across").select_option("placement_radius_m")
    page.locator("#up").select_option("robots")
    settled(page, "document.getElementById('sweep').textContent.includes('cells: [{')")
    text = page.evaluate("document.getElementById('sweep').textContent")
    assert "{placement_radius_m: 0.4, robots: 2}" in text, text
    assert "{placement_radius_m: 0.4, robots: 22}" not in text, text
    page.locator("#copy-sweep").click()
    settled(page, "document.getElementById('copied').textContent !== ''")


def check_refusals(page):
    """What cannot be is refused in words, and the page goes on."""
    page.locator("#turn_rate_rad_s + input").fill("9")
    page.keyboard.press("Enter")
    assert "beyond the robots' limits" in said(page), said(page)
    page.locator("#turn_rate_rad_s + input").fill("0.75")
    page.keyboard.press("Enter")
    assert said(page) == ""
    page.locator("#robots + input").fill("")
    page.keyboard.press("Enter")
    assert page.locator("#robots + input").input_value() == "9" and said(page) == ""
    page.locator("#range_m + input").select_text()
    page.keyboard.type("0,8")
    page.keyboard.press("Enter")
    assert page.locator("#range_m + input").input_value() == "0.8", "a comma is lost"
    for number in ["0", "1000000000"]:
        page.locator("#robots + input").fill(number)
        page.keyboard.press("Enter")
        assert said(page).startswith(f"Number of robots is {number}, expected"), said(page)
        assert page.locator("[aria-invalid]").get_attribute("aria-label") == "number of robots"
    page.locator("#robots + input").fill("1200")
    page.keyboard.press("Enter")
    assert page.evaluate("simulated.describe().values.arena_m") == 25, "they have no room"
    page.locator("#robots + input").fill("300")
    page.keyboard.press("Enter")
    assert page.evaluate("simulated.describe().values.arena_m") == 15, "it is larger than it was"
    assert said(page) == "" and page.locator("#fill").is_visible()
    page.locator("#reset").click()
    settled(page, "simulated.describe().robots === 9")


def bold(page):
    """The settings that are marked as changed, closed groups included."""
    return page.evaluate("[...document.querySelectorAll('.changed label')].map(it => it.htmlFor)")


def shown(page, key):
    return page.locator(f"#{key}").input_value(), page.locator(f"#{key} + input").input_value()


def clicked(page, speed, turn):
    """The cell of the first diagram that has these commands, and is clicked."""
    page.locator(f"[role=gridcell][aria-label^='speed {speed} m/s, turning rate {turn} rad/s']").click()


def check_one_truth(page):
    """What is refused changes nothing but its own field; what follows is not marked; another axis restarts
    nothing."""
    assert bold(page) == [], bold(page)
    digest = page.evaluate("simulated.describe().digest")
    page.locator("#speed_m_s + input").fill("0.5")
    page.keyboard.press("Enter")
    assert "still the one from before" in said(page), said(page)
    assert "profile" not in said(page), said(page)
    assert shown(page, "speed_m_s") == ("0.3", "0.5"), shown(page, "speed_m_s")
    assert page.evaluate("simulated.describe().digest") == digest
    n_steps = page.evaluate("simulated.n_steps()")
    settled(page, f"simulated.n_steps() > {n_steps}")
    page.locator("#speed_m_s + input").fill("")
    page.keyboard.press("Enter")
    assert shown(page, "speed_m_s") == ("0.15", "0.15") and said(page) == "", said(page)

    page.locator("#robots + input").fill("20")
    page.keyboard.press("Enter")
    page.locator("#robots-are").select_option("as_measured")
    assert bold(page) == ["robots", "robots-are"], bold(page)
    page.locator("#yaw_lag_s + input").evaluate("it => { it.value = 0.5; it.dispatchEvent(new Event('change')) }")
    summary = page.locator("summary", has_text="Noise, differences")
    assert summary.evaluate("it => getComputedStyle(it).fontWeight") == "700"

    page.locator("#reset").click()
    page.locator("#across").select_option("placement_radius_m")
    page.locator("#start").select_option("box_facing_any_way")
    assert said(page) == "" and bold(page) == ["placement_radius_m", "start"], (said(page), bold(page))

    page.locator("#reset").click()
    page.evaluate("document.getElementById('pace').value = 50")
    settled(page, "simulated.n_steps() > 100")
    page.locator("#up").select_option("range_m")
    assert page.evaluate("simulated.n_steps()") > 100, "another axis restarts the swarm"
    page.locator("#reset").click()


def check_first_minute(page):
    """Nothing is judged before a minute, in words or in the table."""
    page.locator("#again").click()
    page.evaluate("document.getElementById('pace').value = 20")
    settled(page, "simulated.n_steps() > 150")
    settled(page, "document.querySelector('#order td').textContent !== '–'")
    found = page.evaluate("[phase.textContent, order.textContent, Number.parseInt(clock.textContent)]")
    assert found[2] >= 60 or (found[0] == "Not judged yet:" and not set("✓✗") & set(found[1])), found
    settled(page, "Number.parseInt(clock.textContent) > 75")
    settled(page, "/[✓✗]/.test(order.textContent)")


def check_diagram(page):
    """A cell can be undone, what is no cell is marked, the words are of the cell that has the focus, and a
    large diagram can be stopped."""
    clicked(page, 0.2, 0.5)
    settled(page, "location.hash.includes('speed_m_s=0.2&')")
    clicked(page, 0.1, 1)
    settled(page, "location.hash.includes('speed_m_s=0.1&')")
    page.evaluate("history.back()")
    settled(page, "simulated.describe().values.speed_m_s === 0.2")
    page.evaluate("history.back()")
    settled(page, "simulated.describe().values.speed_m_s === 0.15")
    found = page.locator("[aria-selected=true]").count(), page.locator("#between").evaluate("it => it.outerHTML")
    assert found[0] == 1 and "hidden" in found[1], found

    page.locator("#speed_m_s + input").fill("0.16")
    page.keyboard.press("Enter")
    mark, low, high = page.evaluate("""[document.getElementById('between'),
        ...[37, 38].map(at => document.querySelector(`[data-at='${at - 11}']`))].map(it => {
            const box = it.getBoundingClientRect();
            return box.x + box.width / 2;
        })""")
    assert page.locator("#between").is_visible() and low < mark < high, (low, mark, high)
    assert "is no cell" in page.locator("#pointed").inner_text()
    page.mouse.move(5, 5)
    page.locator("[role=gridcell][tabindex='0']").focus()
    assert page.locator("#pointed").inner_text().startswith("speed 0.05 m/s")
    page.locator("#reset").focus()
    assert "is no cell" in page.locator("#pointed").inner_text()

    page.locator("#robots + input").fill("300")
    page.keyboard.press("Enter")
    page.locator("#fill", has_text="Simulate it").click()
    settled(page, "document.getElementById('progress').value > 0")
    page.locator("#fill", has_text="Stop").click()
    assert page.locator("#runs").inner_text().startswith("Stopped after ")
    n_done = page.evaluate("document.getElementById('progress').value")
    page.wait_for_timeout(1500)
    assert page.evaluate("document.getElementById('progress').value") == n_done, "it goes on"
    page.locator("#reset").click()


def check_links(browser):
    """A link's settings are marked, may be left for the page's own and come back to; robots have room."""
    page, printed, _ = opened(browser, address="#speed_m_s=0.2&turn_rate_rad_s=0.75&range_m=1")
    assert bold(page) == ["speed_m_s", "range_m"], bold(page)
    page.locator("#reset").click()
    assert bold(page) == [] and page.evaluate("simulated.describe().values.speed_m_s") == 0.15
    page.locator("#relink").click()
    assert page.evaluate("simulated.describe().values.range_m") == 1
    page.close()
    page, printed, _ = opened(browser, address="#robots=300", calm=True)
    assert said(page) == "" and page.evaluate("simulated.describe().robots") == 300, said(page)
    assert page.locator("#relink").is_visible() and printed == [], printed
    page.close()
    page, printed, _ = opened(browser, address="#speed_m_s=0.5", calm=True)
    assert "cannot be simulated" in said(page) and shown(page, "speed_m_s") == ("0.15", "0.15")
    assert printed == [], printed
    page.close()


def check_room(browser):
    """Sliders are long enough to be moved, controls are in view, and so is the swarm of a cell that is clicked."""
    page, _, _ = opened(browser, 400)
    for width, height in [(400, 800), (900, 800), (1280, 800), (1500, 900), (2560, 1440)]:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("scrollTo(0, 0)")
        page.wait_for_timeout(200)
        length = page.locator("#speed_m_s").evaluate("it => it.clientWidth")
        assert length >= 190, f"{length} px at {width}"
        bottom = page.locator("#play").evaluate("it => it.getBoundingClientRect().bottom")
        assert width == 400 or bottom <= height, f"{bottom} px at {width}"
        clicked(page, 0.2, 0.5)
        seen = page.locator("#floor").evaluate(
            "it => [it.getBoundingClientRect().top, innerHeight - it.getBoundingClientRect().bottom]")
        assert min(seen) >= 0, f"{seen} at {width}"
    page.close()


def check_end(page):
    """The judge of the watched swarm is that of a sweep: one phase at the end of the run."""
    page.locator("#pace").select_option("50")
    settled(page, "simulated.phase_at_end() !== null")
    ended, swept = page.evaluate("[simulated.phase_at_end(), simulated.phase_in_sweep()]")
    assert swept == [ended], (ended, swept)
    print("at the end:", ended)


def check_sweep_file(page):
    """The diagram fills in, and its sweep file is left for the program."""
    settled(page, "simulated.is_full()")
    text = page.evaluate("simulated.sweep_file()")
    assert "\n  replicates: 100\n" in text, text
    (FOLDER / "copied.yaml").write_text(text.replace("replicates: 100", "replicates: 20"))
    counts, axes, phases = page.evaluate(
        "[simulated.counts(), simulated.describe().axes, simulated.describe().phases]"
    )
    (_, across), (_, up) = axes
    lines = []
    for column, x in enumerate(across):
        for row, y in enumerate(up):
            cell = counts[row * len(across) + column]
            numbers = [x, y, 20] + [cell.get(phase, 0) for phase in phases]
            lines.append(",".join(f"{number:g}" for number in numbers))
    (FOLDER / "counts.csv").write_text("\n".join(lines))
    print(f"diagram of {len(lines)} cells in {page.evaluate('simulated.took_s()'):.1f} s")


def check_address(browser):
    """An address is a cell of any sweep, and one that is none is refused in words."""
    source = json.loads(FACTS["source"])
    source["profile"]["name"] = "another one"
    source["profile"]["sensing"]["cone"] = {"half_angle_rad": 0.25, "range_m": 1.1}
    address = f"#speed_m_s=0.1&turn_rate_rad_s=0.5&replicate=3&source={json.dumps(source)}"
    page, printed, _ = opened(browser, address=address, calm=True)
    described = page.evaluate("simulated.describe()")
    assert described["name"] == "another one" and described["values"]["range_m"] == 1.1
    assert described["values"]["speed_m_s"] == 0.1 and printed == []
    assert page.locator("#play").inner_text() == "Play", "motion is reduced"
    page.close()
    page, printed, _ = opened(browser, address="#speed_m_s=fast&robots=8", calm=True)
    assert "left out: speed_m_s=fast" in said(page) and printed == [], (said(page), printed)
    assert page.evaluate("simulated.describe().robots") == 8
    page.close()
    page, printed, _ = opened(browser, address="#source={}")
    assert "sweep" in said(page) and printed == [], (said(page), printed)
    page.close()


def check_module():
    """The page is one small file, and its module names nothing of the machine that built it."""
    assert len(HTML.encode()) < 1_500_000
    module = gzip.decompress(base64.b64decode(inlined("wasm")))
    for folder in ["home", "root", "Users", "tmp", "work"]:
        assert f"/{folder}/".encode() not in module, folder
    print(f"page of {len(HTML.encode())} bytes, module of {len(module)}")


def main():
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    check_module()
    with sync_playwright() as playwright:
        browser = launched(playwright, CHROMIUM, "--disable-gpu")
        print("usable after %d ms" % least_loading_ms(browser))
        print("script per frame of 300 robots: median %.2f ms" % frame_ms(browser))
        page, printed, asked = opened(browser)
        check_states(page)
        check_sweep_file(page)
        check_end(page)
        check_keys(page)
        check_refusals(page)
        check_one_truth(page)
        check_first_minute(page)
        check_diagram(page)
        check_copies(page)
        assert printed == [], printed
        assert {url.split("#")[0].split(":")[0] for url in asked} <= {"file", "blob"}, asked
        page.close()
        check_address(browser)
        check_links(browser)
        check_room(browser)
        for width in WIDTHS:
            for theme in ["light", "dark"]:
                page, printed, _ = opened(browser, width, theme)
                check_looks(page, width, theme)
                page.screenshot(path=SCREENSHOTS / f"{width}_{theme}.png")
                assert printed == [], printed
                page.close()
        browser.close()
    print("all is well")


main()

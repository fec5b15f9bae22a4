"""The page in a real browser: what a visitor does, and that the numbers are those of the library."""

import json
import os
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from tests.browser.conftest import started

import electrovib as ev
from electrovib.core.units import parse_quantity

pytestmark = pytest.mark.slow

FORCE = """() => {
  const plot = [...document.querySelectorAll('.js-plotly-plot')].find(
    e => e.offsetParent !== null && e.layout?.title?.text === 'Electrostatic force');
  return plot ? Math.max(...plot.data[0].y) + ' ' + plot.layout.yaxis.title.text : '';
}"""
FRAMEWORK = ("nested-interactive", "Choose a file")
"""Finding of axe in the framework's own element for files, and its name."""
SCREENSHOTS = os.environ.get("ELECTROVIB_SCREENSHOTS")


def shown(page, expected: float):
    """Wait until the largest force of the plot is the expected one [N]."""
    page.wait_for_function(
        "([find, wanted]) => { const text = eval(find)(); if (!text) return false;"
        " const units = {'[N]': 1, '[mN]': 1e-3, '[µN]': 1e-6, '[nN]': 1e-9};"
        " const found = parseFloat(text) * units[text.split(' ').pop()];"
        " return Math.abs(found / wanted - 1) < 2e-3; }",
        arg=[FORCE, expected],
    )


def peak(scenario) -> float:
    return float(ev.simulate(scenario).electrostatic_force.max())


def keep(page, name: str) -> None:
    """Keep a screenshot where they are asked for."""
    if SCREENSHOTS:
        Path(SCREENSHOTS).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=Path(SCREENSHOTS) / f"{name}.png")


def test_a_slider_changes_the_numbers_to_those_of_the_library_and_the_link_gives_them_again(opened, server):
    page = opened()
    base = ev.load("vezzoli_2014/fig6")
    shown(page, peak(base))
    sliders = page.locator(".q-slider__track-container")
    sliders.first.focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    field = page.get_by_label("Drive: high, value")
    page.wait_for_function("field => field.value !== '1 kV'", arg=field.element_handle())
    page.wait_for_timeout(1000)
    text = field.input_value()
    assert text != "1 kV"
    shown(page, peak(base.replace({"drive.high": text})))
    field.fill("500 V")
    field.press("Enter")
    shown(page, peak(base.replace({"drive.high": "500 V"})))
    page.wait_for_url("**drive.high**")
    other = opened("?" + page.url.partition("/?")[2])
    shown(other, peak(base.replace({"drive.high": "500 V"})))
    keep(page, "over_time")
    page.get_by_role("button", name="Reset").click()
    shown(page, peak(base))
    shown(other, peak(base.replace({"drive.high": "500 V"})))  # of another visitor
    loaded = page.evaluate("() => performance.getEntriesByType('resource').map(e => e.name)")
    own = (f"http://127.0.0.1:{server.port}/", "data:", "blob:")
    assert loaded
    assert all(name.startswith(own) for name in loaded)  # no request leaves this machine


KEY = """name => [...document.querySelectorAll('.ev-key-figure')].find(
  e => e.querySelector('dt').textContent === name).querySelector('dd').textContent"""
FAINT = """() => [...document.querySelectorAll('.js-plotly-plot')].find(
  e => e.layout?.title?.text === 'Electrostatic force').data.filter(e => e.opacity).map(e => Math.max(...e.y))"""


def test_key_figures_follow_a_value_and_the_curve_before_it_stays_faintly(opened):
    page = opened("?preset=bau_2010/sine")
    base = ev.load("bau_2010/sine")
    shown(page, peak(base))
    page.wait_for_function(f"() => ({KEY})('Felt?').startsWith('yes')")
    assert page.evaluate(FAINT) == []
    field = page.get_by_label("Drive: amplitude, value")
    field.fill("50 mV")
    field.press("Enter")
    weak = base.replace({"drive.amplitude": "50 mV"})
    shown(page, peak(weak))
    assert parse_quantity(page.evaluate(KEY, "Peak attraction"), "N") == pytest.approx(peak(weak), rel=6e-3)
    page.wait_for_function(f"() => ({KEY})('Felt?').startsWith('no')")
    unit = 1e-6 if "µN" in page.evaluate(FORCE) else 1e-3
    assert unit * page.evaluate(FAINT)[0] == pytest.approx(peak(base), rel=2e-3)


def test_mistakes_are_sentences(opened):
    page = opened("?preset=none&set=drive.high=5")
    page.get_by_text("no scenario is called 'none'").wait_for()
    field = page.get_by_label("Drive: high, value")
    field.fill("five parsecs")
    field.press("Enter")
    page.get_by_text("drive.high = 'five parsecs'").wait_for()
    field.fill("400 V")
    field.press("Enter")
    shown(page, peak(ev.load("vezzoli_2014/fig6").replace({"drive.high": "400 V"})))
    assert page.get_by_role("alert").inner_text() == ""


NAMES = """() => [...document.querySelectorAll('.js-plotly-plot')]
  .find(e => e.layout?.title?.text === 'Electrostatic force').data.filter(e => !e.opacity).map(e => e.name)"""
KEPT = """() => [...document.querySelectorAll('.ev-key-figure')].find(
  e => e.querySelector('dt').textContent === 'Peak attraction').querySelector('.ev-kept')?.textContent"""


def test_a_state_is_kept_compared_in_curves_and_key_figures_swapped_and_dropped(opened):
    page, base = opened("?preset=vezzoli_2014/fig6_gap"), ev.load("vezzoli_2014/fig6_gap")
    shown(page, peak(base))
    strip = page.get_by_role("region", name="Kept as A")
    assert not strip.is_visible()
    page.get_by_role("button", name="Keep as A").click()
    strip.get_by_text("A, dashed: vezzoli_2014/fig6_gap").wait_for()
    field = page.get_by_label("Drive: high, value")
    field.fill("500 V")
    field.press("Enter")
    weak = base.replace({"drive.high": "500 V"})
    shown(page, peak(weak))
    assert page.evaluate(NAMES) == ["attraction", "attraction, A"]
    assert parse_quantity(page.evaluate(KEPT).removeprefix("A: "), "N") == pytest.approx(peak(base), rel=6e-3)
    strip.get_by_role("button", name="Swap").click()
    shown(page, peak(base))
    strip.get_by_text("A, dashed: vezzoli_2014/fig6_gap, drive.high = 500 V").wait_for()
    page.wait_for_function("field => field.value === '1 kV'", arg=field.element_handle())
    assert "drive.high" not in page.url
    assert parse_quantity(page.evaluate(KEPT).removeprefix("A: "), "N") == pytest.approx(peak(weak), rel=6e-3)
    strip.get_by_role("button", name="Drop").click()
    strip.wait_for(state="hidden")
    page.wait_for_function(f"({NAMES})().length === 1")
    assert page.evaluate(KEPT) is None


def test_dry_and_moist_fingers(opened):
    page = opened("?preset=vezzoli_2014/fig6_gap")
    base = ev.load("vezzoli_2014/fig6_gap")
    shown(page, peak(base))
    for words, name in (("dry finger", "dry"), ("moist finger", "wet")):
        page.get_by_label("Skin", exact=True).click()
        page.get_by_role("option", name=words).click()
        shown(page, peak(base.replace({"stack.stratum_corneum.material": f"gabriel_1996/{name}"})))


def _recording() -> bytes:
    scenario = ev.load("vezzoli_2014/fig6").replace({"stack.insulator.thickness": "80 um"})
    trace = ev.simulate(scenario, time=np.linspace(0, 0.27, 400))
    force = trace.electrostatic_force.values + 1e-5 * np.random.default_rng(1).normal(size=400)
    rows = (f"{time:.9g},{value:.6g}" for time, value in zip(trace.time.values, force, strict=True))
    return "\n".join(["time (s),CH1 (N)", *rows]).encode()


def drop(page, name: str, content: bytes) -> None:
    page.get_by_role("tab", name="Recording").click()
    page.set_input_files("input[type=file]", {"name": name, "mimeType": "text/plain", "buffer": content})


def test_a_recording_is_overlaid_and_fitted(opened):
    page = opened()
    drop(page, "scope.csv", _recording())
    page.get_by_text("Which column is which signal?").wait_for()
    page.get_by_label("signal").click()
    page.get_by_role("option", name="electrostatic force").click()
    page.get_by_role("button", name="Compare").click()
    page.get_by_text("recorded", exact=True).wait_for()
    page.get_by_label("parameters to fit").click()
    page.get_by_role("option", name="stack.insulator.thickness").click()
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Fit", exact=True).click()
    page.get_by_text("95 % interval").wait_for()
    row = page.locator("tr", has_text="stack.insulator.thickness").inner_text()
    value = float(row.split("\t")[1].split()[0])
    assert value == pytest.approx(80, abs=0.2)
    keep(page, "fit")


def test_the_example_recording_is_loaded_with_one_click_and_a_fit_finds_what_it_hides(opened):
    page = opened("?preset=bau_2010/sine")
    page.get_by_role("tab", name="Recording").click()
    page.get_by_role("button", name="Load an example recording (simulated)").click()
    page.get_by_text("example (simulated)", exact=True).wait_for()  # legend of the curve
    page.get_by_text("example (simulated: bau_2010/sine with one value changed and noise)").wait_for()
    page.get_by_role("button", name="Fit", exact=True).click()
    page.get_by_text("The example was simulated with stack.gap.thickness = 3.9 µm.").wait_for()
    row = page.locator("tr", has_text="stack.gap.thickness").inner_text()
    assert float(row.split("\t")[1].split()[0]) == pytest.approx(3.9, abs=0.01)
    keep(page, "example")
    drop(page, "scope.csv", _recording())
    page.get_by_text("scope.csv", exact=True).wait_for()


def test_a_scenario_is_dropped(opened):
    page = opened()
    drop(page, "a.toml", b'drive = { model = "Sampled", file = "/etc/passwd" }')
    page.get_by_role("alert").get_by_text("names a file").wait_for()
    scenario = ev.load("bau_2010/sine").replace({"drive.amplitude": "77 V"})
    drop(page, "mine.toml", scenario.to_toml().encode())
    page.get_by_role("tab", name="Over time").click()
    shown(page, peak(scenario))


DOWNLOADS = ("Scenario (TOML)", "Numbers over time (CSV)", "Trace (netCDF)", "Figures (PNG)", "Figures (SVG)")
DOWNLOADS += ("Report (HTML)", "References (BibTeX)")


def test_every_download_has_the_right_content(opened, tmp_path):
    page = opened("?set=drive.high=300 V")
    scenario = ev.load("vezzoli_2014/fig6").replace({"drive.high": "300 V"})
    shown(page, peak(scenario))
    found = {}
    for label in DOWNLOADS:
        page.get_by_role("button", name="Download").click()
        with page.expect_download() as download:
            page.get_by_text(label, exact=True).click()
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        found[path.name] = path
        page.wait_for_timeout(300)
    assert ev.load(found["scenario.toml"]) == scenario
    assert float(ev.open_trace(found["trace.nc"]).electrostatic_force.max()) == pytest.approx(peak(scenario))
    assert "electrostatic_force [N]" in found["trace.csv"].read_text()
    assert found["figures.png"].read_bytes().startswith(b"\x89PNG")
    assert "<svg" in found["figures.svg"].read_text()
    assert "300 V" in found["report.html"].read_text()
    assert "@" in found["references.bib"].read_text()


TABS = {
    "Over time": "Electrostatic force",
    "Why it fades": "A sign stands for",
    "Over frequency": "5 to 95 % of fingers",
    "Force laws": "relative to this law",
    "Felt": "relative to published detection thresholds",
    "Safety": "only hardware that limits the current",
    "Recording": "Drop a recording",
}
"""Tab to words of its content."""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_tab_shows_its_content_without_a_serious_finding_of_accessibility(opened, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    page = opened("?preset=vezzoli_2014/fig6_gap", color_scheme=scheme)
    page.wait_for_timeout(1000)
    page.get_by_role("combobox", name="Drive").focus()  # whose label has another colour then
    for tab, text in TABS.items():
        if tab != "Over time":
            page.get_by_role("tab", name=tab).click()
        page.get_by_text(text).first.wait_for(timeout=90_000)  # compiled code is made at its first use
        page.wait_for_timeout(1000)
        # what is computed stands faintly
        page.locator("[aria-busy=true]").wait_for(state="detached", timeout=90_000)
        keep(page, f"{tab.lower().replace(' ', '_')}_{scheme}")
        no_serious_finding(axe, page, tab)
    for words in ("thickness", "thiknes"):
        page.get_by_label("Search the parameters").fill(words)
        page.wait_for_timeout(1000)
        no_serious_finding(axe, page, words)
    page.get_by_role("button", name="Load an example recording").click()
    page.get_by_text("example (simulated)", exact=True).wait_for()
    page.wait_for_timeout(1000)
    no_serious_finding(axe, page, "example")


def no_serious_finding(axe, page, where):
    found = [
        (each["id"], node["html"][:200])
        for each in axe.Axe().run(page).response["violations"]
        for node in each["nodes"]
        if each["impact"] in ("serious", "critical")
        and not (each["id"] == FRAMEWORK[0] and FRAMEWORK[1] in node["html"])
    ]
    assert found == [], (where, json.dumps(found, indent=1))


def _status(server, **headers):
    request = urllib.request.Request(f"http://127.0.0.1:{server.port}/", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


OPEN = """address => new Promise(resolve => {
  const socket = new WebSocket(address);
  socket.onopen = () => resolve('open');
  socket.onerror = () => resolve('refused');
})"""


def attacking(route):
    route.fulfill(body="<p>attacker</p>", content_type="text/html")


def test_other_sites_cannot_talk_to_the_page(browser, server):
    """Neither by requests nor, from a page of theirs in the same browser, by its websocket."""
    assert _status(server) == 200
    assert _status(server, Host="attacker.example") == 403
    assert _status(server, Origin="http://attacker.example") == 403
    address = f"ws://127.0.0.1:{server.port}/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    for site, answer in (
        (f"http://127.0.0.1:{server.port}/", "open"),
        ("http://attacker.example/", "refused"),
    ):
        with browser.new_context() as context:
            page = context.new_page()
            page.route("http://attacker.example/**", attacking)
            page.goto(site)
            assert page.evaluate(OPEN, address) == answer


WAITING = '''"""A force law that is computed as soon as a file exists."""
import time
from pathlib import Path

from electrovib.physics.force import ForceLaw


class Waiting(ForceLaw):
    """Maxwell stress, late."""

    def pressure(self, E):
        while not Path("release").exists():
            time.sleep(0.01)
        return 4.4e-12 * E**2
'''


def test_a_tab_that_is_being_computed_says_so(opened, tmp_path, tmp_path_factory):
    (tmp_path / "law.py").write_text(WAITING)
    server = started(tmp_path_factory, "slow", "--models", "law.py", place=tmp_path)
    try:
        page = opened("?preset=vezzoli_2014/fig6_gap", port=server.port)
        panel, status = page.locator("[aria-busy]"), page.locator(".ev-status")
        page.locator("[aria-busy=false]").wait_for()
        assert status.inner_text() == ""
        page.get_by_role("tab", name="Force laws").click()
        page.locator("[aria-busy=true]").wait_for()
        status.get_by_text("Computing …").wait_for()
        page.wait_for_timeout(1000)
        assert panel.get_attribute("aria-busy") == "true"
        assert status.inner_text() == "Computing …"
        keep(page, "computing")
        (tmp_path / "release").touch()
        page.locator("[aria-busy=false]").wait_for()
        assert status.inner_text() == ""
        page.context.close()
    finally:
        server.stop()


def test_servers_that_are_started_together_take_a_port_each(tmp_path_factory):
    with ThreadPoolExecutor(3) as pool:
        servers = list(pool.map(lambda name: started(tmp_path_factory, name), ("one", "two", "three")))
    answers, logs = [_status(each) for each in servers], [each.stop() for each in servers]
    assert len({each.port for each in servers}) == 3
    assert (answers, logs) == ([200] * 3, [""] * 3)

"""The stories of the page in a real browser: links, the strip above the results, and what becomes of it when a visitor plays."""

import json
import re
from urllib.parse import parse_qs, urlparse

import pytest
from tests.browser.test_page import FRAMEWORK, keep, peak, shown
from tests.browser.test_use import type_into

import electrovib as ev
from electrovib.apps.explorer.state import STEPS, STORIES, PageState

pytestmark = pytest.mark.slow

SCREEN = "bau_2010/sine"

CURVES = """() => [...document.querySelectorAll('.js-plotly-plot')].find(
  each => each.layout?.title?.text === 'Electrostatic force').data.length"""


def story(page):
    return page.get_by_role("region", name="Story")


def told(page, name: str):
    """Wait until a step is told, and the address is that of its state."""
    step = STEPS[name]
    words = re.escape(step.sentence).replace(r"\ ", r"\s")
    story(page).get_by_text(re.compile(words)).wait_for()
    shown_as = {"preset": step.preset, "tab": step.tab, "story": name}
    query = {key: [value] for key, value in shown_as.items() if value != "Over time"}
    if step.changes:
        query["set"] = [f"{path}={value}" for path, value in step.changes.items()]
    page.wait_for_url(lambda address: parse_qs(urlparse(address).query) == query)
    page.locator(f"[role=tab][aria-selected=true]:has-text('{step.tab}')").wait_for()


def go(page, words: str):
    """Follow a link of the strip with the keyboard."""
    story(page).get_by_role("link", name=words, exact=True).press("Enter")


def test_a_visitor_is_invited_follows_a_story_plays_and_closes_it(opened):
    page = opened()
    invitation = page.get_by_role("region", name="Invitation")
    assert invitation.get_by_role("link").all_inner_texts() == [
        f"A story for a {each.reader}" for each in STORIES
    ]
    assert not story(page).is_visible()
    page.evaluate("window.same = true")
    invitation.get_by_role("link", name="A story for a touchscreen engineer").click()
    told(page, "engineer.1")
    assert not invitation.is_visible()
    shown(page, peak(ev.load(SCREEN)))
    go(page, "Next")
    told(page, "engineer.2")
    shown(page, peak(ev.load(SCREEN).replace(STEPS["engineer.2"].changes)))
    page.wait_for_function(f"({CURVES})() === 2")  # that of the step before stays behind it
    assert page.get_by_label("Layers: insulator, thickness, value").input_value() == "10 µm"
    go(page, "Next")
    told(page, "engineer.3")
    page.get_by_text("5 to 95 % of fingers").first.wait_for(timeout=90_000)
    page.go_back()
    told(page, "engineer.2")
    again = story(page).get_by_role("link", name="Show again")
    assert not again.is_visible()
    type_into(page, "Drive: amplitude, value", "50 V")
    shown(page, peak(ev.load(SCREEN).replace(STEPS["engineer.2"].changes | {"drive.amplitude": 50})))
    assert "engineer.2" in page.url
    again.click()
    told(page, "engineer.2")
    page.get_by_role("button", name="Close the story").click()
    story(page).wait_for(state="hidden")
    page.wait_for_url(lambda address: "story" not in address)
    assert page.evaluate("window.same")  # never loaded again
    other = opened()
    other.get_by_role("button", name="Close the invitation").click()
    other.get_by_role("region", name="Invitation").wait_for(state="hidden")


def test_the_address_is_that_of_the_open_tab_to_which_back_leads(opened):
    page = opened(f"?preset={SCREEN}")
    for tab in ("Safety", "Felt"):
        page.get_by_role("tab", name=tab).click()
        page.wait_for_url(f"**tab={tab}")
    page.get_by_text("relative to published detection thresholds").first.wait_for(timeout=90_000)
    other = opened("?" + page.url.partition("?")[2])
    other.get_by_text("relative to published detection thresholds").first.wait_for(timeout=90_000)
    page.go_back()
    page.get_by_text("only hardware that limits the current").first.wait_for()
    page.go_back()
    shown(page, peak(ev.load(SCREEN)))
    mistaken = opened(f"?preset={SCREEN}&tab=Felled")
    mistaken.get_by_role("alert").get_by_text("no tab is called 'Felled'. Did you mean 'Felt'?").wait_for()


RESULTS = {"Why it fades": ".ev-pulse-curve", "Safety": ".ev-table tbody tr"}
"""Where the result of a tab is seen; of any other the area of its first plot."""


@pytest.mark.parametrize("size", [(390, 844), (1440, 900)])
def test_what_a_step_asks_to_change_and_where_its_result_shows_are_on_the_first_screen(opened, size):
    width, height = size
    page = opened(viewport={"width": width, "height": height})
    for name, step in STEPS.items():
        page.goto(page.url.partition("?")[0] + f"?{PageState.of_step(step).to_query()}")
        result = page.locator(RESULTS.get(step.tab, ".js-plotly-plot .nsewdrag")).first
        result.wait_for()
        page.wait_for_function("document.querySelectorAll('.ev-stale').length === 0")
        page.wait_for_timeout(300)
        asked = story(page).get_by_role("textbox")
        assert asked.count() == 1, name
        for place in (asked, story(page).get_by_role("slider"), page.locator(".ev-key dd").first, result):
            box = place.bounding_box()
            assert 0 <= box["x"] < box["x"] + box["width"] <= width, name
            assert 0 < box["y"] < box["y"] + box["height"] <= height, f"{name}: {box}"


def test_what_a_story_asks_for_moves_back_to_the_others_when_it_is_closed(opened):
    page = opened(f"?{PageState.of_step(STEPS['engineer.2']).to_query()}")
    film, gap = "Layers: insulator, thickness, value", "Layers: gap, thickness, value"
    assert story(page).get_by_label(film).input_value() == "10 µm"
    type_into(page, film, "5 µm")
    shown(page, peak(ev.load(SCREEN).replace({"stack.insulator.thickness": "5 um"})))
    go(page, "Next")
    told(page, "engineer.3")
    story(page).get_by_label(gap).wait_for()
    assert page.get_by_label(film).count() == page.get_by_label(gap).count() == 1
    page.get_by_role("button", name="Close the story").click()
    story(page).wait_for(state="hidden")
    page.get_by_label(gap).wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_stories_are_links_on_a_phone_without_a_serious_finding_of_accessibility(opened, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    query = PageState.of_step(STEPS["student.1"]).to_query()
    page = opened(f"?{query}", color_scheme=scheme, viewport={"width": 390, "height": 844})
    page.evaluate("window.scrollTo(0, 600)")
    page.wait_for_timeout(1000)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    top = page.locator(".q-header").bounding_box()["height"]
    assert story(page).bounding_box()["y"] == pytest.approx(top, abs=1)  # which stays in sight
    serious(axe, page)
    page.get_by_role("button", name="Stories").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("link").last.wait_for()
    page.wait_for_timeout(1000)
    found = [link.get_attribute("href") for link in dialog.get_by_role("link").all()]
    assert found == [f"/?{PageState.of_step(each).to_query()}" for each in STEPS.values()]
    keep(page, f"stories_{scheme}")
    serious(axe, page)
    dialog.get_by_role("link").nth(14).click()
    told(page, "researcher.5")
    dialog.wait_for(state="detached")


def serious(axe, page):
    """Fail for a serious finding other than that of the framework's own element."""
    found = [
        (each["id"], node["html"][:200])
        for each in axe.Axe().run(page).response["violations"]
        for node in each["nodes"]
        if each["impact"] in ("serious", "critical")
        and not (each["id"] == FRAMEWORK[0] and FRAMEWORK[1] in node["html"])
    ]
    assert found == [], json.dumps(found, indent=1)

"""The page in a real browser, as visitors use it: choices, fields, keyboard, history, narrow screens."""

from urllib.parse import quote_plus

import pytest
from tests.browser.test_page import drop, keep, peak, shown

import electrovib as ev
from electrovib.apps.explorer.computed import TABS
from electrovib.apps.explorer.page.knobs import MOST_IMPORTANT
from electrovib.physics.perception import ElasticSkin

pytestmark = pytest.mark.slow

SINE, GAP = "bau_2010/sine", "vezzoli_2014/fig6_gap"


def type_into(page, label: str, text: str):
    field = page.get_by_label(label, exact=True)
    field.fill(text)
    field.press("Enter")
    return field


def choose(page, label: str, option: str):
    page.get_by_role("combobox", name=label, exact=True).first.click()
    page.get_by_role("option", name=option, exact=True).click()
    page.wait_for_function("() => document.querySelectorAll('.q-menu').length === 0")


def test_another_drive_keeps_amplitude_and_frequency_and_back_takes_it_back(opened):
    page = opened(f"?preset={SINE}")
    base = ev.load(SINE)
    shown(page, peak(base))
    type_into(page, "Drive: amplitude, value", "150 V")
    sine = base.replace({"drive.amplitude": "150 V"})
    shown(page, peak(sine))
    choose(page, "Drive", "Square")
    frequency = base.drive.frequency
    square = base.replace({"drive": {"model": "Square", "high": 150, "low": -150, "frequency": frequency}})
    shown(page, peak(square))
    assert page.get_by_label("Drive: high, value").input_value() == "150 V"
    page.go_back()
    shown(page, peak(sine))
    page.go_back()
    shown(page, peak(base))
    page.go_forward()
    shown(page, peak(sine))
    page.reload()
    shown(page, peak(sine))


ENTER_AND_TYPE = """([first, value, next, typed, entered]) => {
  const field = name => document.querySelector(`[aria-label="${name}"]`);
  const type = (name, text) => {
    field(name).focus();
    field(name).value = text;
    field(name).dispatchEvent(new Event('input', {bubbles: true}));
  };
  const enter = name => field(name).dispatchEvent(new KeyboardEvent('keydown', {key: 'Enter', bubbles: true}));
  window.seen = new Set();
  const look = () => { window.seen.add(field(next).value); requestAnimationFrame(look); };
  type(first, value);
  setTimeout(() => {
    enter(first);
    type(next, typed);  // in one task, as in a busy browser, which sends that the first field was left only afterwards
    look();
    if (entered) setTimeout(() => enter(next), 50);
  });
}"""


FILM = "Layers: insulator, thickness, value"
THIN = {"stack.insulator.thickness": "60 um"}


@pytest.mark.parametrize("is_entered", [False, True])
def test_what_is_typed_outlasts_the_answer_to_an_earlier_change(opened, is_entered):
    page, base = opened(f"?preset={GAP}"), ev.load(GAP)
    page.evaluate(ENTER_AND_TYPE, ["Drive: high, value", "700 V", FILM, "60 um", is_entered])
    if not is_entered:
        shown(page, peak(base.replace({"drive.high": 700})))
        page.wait_for_timeout(500)
        page.get_by_label(FILM).press("Enter")
    shown(page, peak(base.replace({"drive.high": 700} | THIN)))
    page.wait_for_function("() => window.seen.has('60 µm')")
    assert set(page.evaluate("[...window.seen]")) == {"60 um", "60 µm"}


def test_what_is_typed_outlasts_a_field_that_is_emptied_or_taken_back(opened):
    page, base = opened(f"?preset={GAP}&set=drive.high=700 V"), ev.load(GAP)
    page.evaluate(ENTER_AND_TYPE, ["Drive: high, value", "", FILM, "60 um", True])
    shown(page, peak(base.replace(THIN)))
    page = opened(f"?preset={GAP}")
    original = page.get_by_label(FILM).input_value()
    page.evaluate(ENTER_AND_TYPE, [FILM, "60 um", FILM, original, True])  # before it is computed
    shown(page, peak(base))
    page.wait_for_url(f"**{quote_plus(original)}")


def test_fields_take_units_refuse_others_and_give_values_back(opened):
    page = opened(f"?preset={SINE}")
    shown_amplitude = "document.querySelector('[aria-label=\"Drive: amplitude, value\"]').value"
    field = type_into(page, "Drive: amplitude, value", "12 mm")
    page.get_by_text("drive.amplitude = '12 mm'").wait_for()
    field.fill("55")
    field.press("Escape")
    page.wait_for_function(f"() => {shown_amplitude} === '100 V'")
    page.wait_for_function("() => document.activeElement.ariaLabel === 'Drive: amplitude, value'")
    page.wait_for_function("() => document.querySelector('[role=alert]').innerText === ''")
    type_into(page, "Drive: frequency, value", "100 Hz")  # of which the refused amplitude is no part
    shown(page, peak(ev.load(SINE).replace({"drive.frequency": 100})))
    type_into(page, "Drive: amplitude, value", "0.2 kV")
    shown(page, peak(ev.load(SINE).replace({"drive.amplitude": 200, "drive.frequency": 100})))
    type_into(page, "Drive: amplitude, value", "12 mm")
    page.get_by_text("drive.amplitude = '12 mm'").wait_for()
    field.press("Escape")
    page.wait_for_url("**drive.amplitude%3D0.2*")
    type_into(page, "Drive: frequency, value", "")
    shown(page, peak(ev.load(SINE).replace({"drive.amplitude": 200})))
    type_into(page, "Drive: amplitude, value", "")
    shown(page, peak(ev.load(SINE)))
    page.wait_for_function("field => field.value === '100 V'", arg=field.element_handle())
    page.get_by_role("button", name='Expand "Limits"').click()
    type_into(page, "Limits: voltage, value", "80 V")  # which had no value, so no slider
    page.get_by_role("tab", name="Safety").click()
    page.locator("tr", has_text="limits.voltage of the scenario").get_by_text("fail").wait_for()
    assert page.get_by_label("Limits: voltage", exact=True).count() >= 1


def test_what_is_being_typed_is_not_replaced_by_a_result(opened):
    page = opened(f"?preset={GAP}")
    page.get_by_role("tab", name="Force laws").click()  # whose results arrive one after the other
    field = page.get_by_label("Drive: high, value")
    field.click()
    field.press_sequentially("6", delay=100)
    page.get_by_text("Vezzoli2014Causal").first.wait_for()
    page.wait_for_timeout(800)
    assert field.input_value() in ("61 kV", "1 kV6", "16 kV", "1 6kV", "1 k6V")  # wherever the pointer was


def test_a_field_that_is_being_typed_stays_when_another_parameter_gets_its_slider(opened):
    page = opened(f"?preset={SINE}")
    page.get_by_role("button", name='Expand "Limits"').click()
    type_into(page, "Limits: voltage, value", "80 V")
    current = page.get_by_label("Limits: current, value")
    current.click()
    current.press_sequentially("10 ", delay=50)
    page.get_by_role("slider", name="Limits: voltage").wait_for()
    current.press_sequentially("uA")
    page.keyboard.press("Enter")
    page.get_by_role("slider", name="Limits: current").wait_for()
    assert current.input_value() == "10 µA"
    type_into(page, "Limits: voltage, value", "")
    page.get_by_role("slider", name="Limits: voltage").wait_for(state="detached")
    assert page.get_by_label("Limits: voltage, value").input_value() == ""
    assert page.get_by_role("slider", name="Limits: current").is_visible()


def test_the_keyboard_reaches_the_results_past_the_parameters(opened):
    page = opened(f"?preset={SINE}")
    skip = page.get_by_role("button", name="Skip to the results")
    page.keyboard.press("Tab")
    page.wait_for_function("button => button.getBoundingClientRect().top >= 0", arg=skip.element_handle())
    page.keyboard.press("Enter")
    assert focused(page)[:2] == ["tab", "Over time"]
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Play").wait_for()
    assert skip.bounding_box()["y"] < 0


def test_pointer_and_keyboard(opened):
    page = opened(f"?preset={GAP}")
    slider = page.locator(".q-slider__track-container").first
    slider.hover()
    tip = page.locator(".q-tooltip")
    tip.wait_for()
    for words in (
        "voltage of the hold",
        "allowed from -100 kV to 100 kV",
        "slider from",
        "Source: Vezzoli 2014",
    ):
        assert words in tip.inner_text()
    slider.focus()
    page.keyboard.press("PageUp")
    field = page.get_by_label("Drive: high, value")
    page.wait_for_function("field => field.value === '1.062 kV'", arg=field.element_handle())
    page.keyboard.press("Shift+Tab")
    ring = "() => getComputedStyle(document.activeElement).boxShadow"
    assert "0px 0px 0px 2px" in page.evaluate(ring)
    page.get_by_role("button", name="Download").press("Enter")
    page.get_by_text("Report (HTML)").wait_for()
    page.keyboard.press("Escape")
    page.get_by_text("Report (HTML)").wait_for(state="hidden")


ROWS = "[...document.querySelectorAll('.ev-row')].filter(e => e.offsetParent !== null).map(e => e.innerText.split('\\n')[0])"


def test_words_find_parameters_of_all_sections_with_their_present_values(opened):
    page = opened(f"?preset={GAP}&set=limits.voltage=900 V")
    search = page.get_by_label("Search the parameters")
    assert 6 <= len(page.evaluate(ROWS)) <= MOST_IMPORTANT
    page.get_by_role("button", name='Expand "Limits (1 changed)"').wait_for()
    type_into(page, "Drive: high, value", "700 V")
    search.fill("HIGH drive")
    page.get_by_text("2 of 43 parameters").wait_for()  # of which one was folded
    assert page.get_by_label("Drive: high, value").input_value() == "700 V"
    hold = type_into(page, "Drive: hold, value", "50 ms")
    shown(page, peak(ev.load(GAP).replace({"drive.high": 700, "drive.hold": 0.05})))
    hold.press("Shift+Tab")
    search.fill("voltage limits largest plate")
    field = page.get_by_label("Limits: voltage, value")
    field.wait_for()
    assert field.input_value() == "900 V"
    assert not page.get_by_label("Drive: high, value").is_visible()
    keep(page, "search")
    search.fill("thiknes")
    page.get_by_role("status").get_by_text("Did you mean 'thickness'?").wait_for()
    assert page.evaluate(ROWS) == []
    search.press("Escape")
    page.get_by_label("Drive: high, value").wait_for()
    page.get_by_role("button", name='Expand "Drive (1 changed)"').click()
    hold.wait_for()
    assert hold.input_value() == "50 ms"
    page.get_by_role("button", name="Reset").click()
    page.get_by_role("button", name='Collapse "Drive"', exact=True).wait_for()
    assert page.locator(".ev-changed").count() == 0


def test_a_phone_shows_the_plots_first_and_the_parameters_on_demand(opened):
    page = opened(f"?preset={GAP}", viewport={"width": 390, "height": 844})
    field = page.get_by_label("Drive: high, value")
    assert not field.is_visible()
    page.get_by_role("button", name="Show or hide the parameters").click()
    field.wait_for()
    keep(page, "phone")
    page.keyboard.press("Escape")
    page.mouse.click(385, 600)  # beside the parameters, which closes them
    for tab in TABS:
        page.get_by_role("tab", name=tab).click()
        page.wait_for_timeout(500)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, tab
        page.wait_for_timeout(500)  # in which the list of tabs moves
        names = page.locator(".q-tabs__content").bounding_box()
        for arrow in page.locator(".q-tabs__arrow:visible").all():  # none of which covers a name
            edges = arrow.bounding_box()
            left, right = edges["x"], edges["x"] + edges["width"]
            assert left >= names["x"] + names["width"] - 1 or right <= names["x"] + 1, tab


def test_columns_are_proposed_by_unit_and_name_with_a_field_for_the_scale_and_compared(opened):
    rows = [f"{0.001 * at:.3f},{0.1 * at:.2f},{at},{0.5 + 0.01 * at:.2f}" for at in range(40)]
    page = opened()
    drop(page, "rig.csv", "\n".join(["time,force,voltage,F_N (V)", *rows]).encode())
    page.get_by_text("Which column is which signal?").wait_for()
    for name, signal in (("force", "lateral force"), ("voltage", "drive voltage"), ("F_N", "normal force")):
        assert page.get_by_label(f"signal of {name}").input_value() == signal
    compare = page.get_by_role("button", name="Compare")
    compare.click()
    page.get_by_text("it is in 'V', but a force is needed").wait_for()
    page.get_by_label("scale of F_N").fill("2 N/V")
    choose(page, "signal of F_N", "lateral force")
    compare.click()
    page.get_by_text("Two columns are chosen as lateral force").wait_for()
    choose(page, "signal of F_N", "electrostatic force")
    compare.click()
    page.wait_for_function("() => document.querySelectorAll('.js-plotly-plot .main-svg').length >= 6")
    titles = "() => [...document.querySelectorAll('.js-plotly-plot')].map(e => e.layout.title.text)"
    assert set(page.evaluate(titles)) == {"lateral force", "electrostatic force", "drive voltage"}


def focused(page) -> list[str]:
    """Return role and name of the focused element as the browser hands them to a screen reader, and its value text."""
    devtools = page.context.new_cdp_session(page)
    nodes = devtools.send("Accessibility.getFullAXTree")["nodes"]
    (found,) = [
        each
        for each in nodes
        if {"name": "focused", "value": {"type": "booleanOrUndefined", "value": True}}
        in each.get("properties", [])
        and each["role"]["value"] != "RootWebArea"
    ]
    text = page.evaluate("document.activeElement.ariaValueText")  # which Chromium's tools do not report
    return [found["role"]["value"], found.get("name", {}).get("value"), text]


RECORD = """() => {
  window.states = [];
  const target = document.activeElement;
  const note = () => window.states.push(
    [target.getAttribute('aria-valuenow'), target.getAttribute('aria-valuetext')].join(' '));
  new MutationObserver(note).observe(target, {attributes: true});
  note();
}"""


def test_a_screen_reader_is_given_name_and_value_with_unit_of_a_slider(opened):
    page = opened(f"?preset={GAP}")
    slider = page.get_by_role("slider", name="Drive: high", exact=True)
    slider.focus()
    assert focused(page) == ["slider", "Drive: high", "1 kV"]
    field = page.get_by_label("Drive: high, value")
    page.evaluate(RECORD)
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    page.wait_for_function("field => field.value === '1.074 kV'", arg=field.element_handle())
    page.wait_for_timeout(500)
    assert focused(page) == ["slider", "Drive: high", "1.074 kV"]
    states = page.evaluate("window.states")
    assert len(states) > 1
    for state in states:  # the text is never that of another position
        position, volt, unit = state.split(" ")
        assert int(position) == round((float(volt) * {"V": 1, "kV": 1e3}[unit] + 3000) / 6)
    page.keyboard.press("End")
    page.wait_for_function("field => field.value === '3 kV'", arg=field.element_handle())
    assert slider.get_attribute("aria-valuetext") == "3 kV"
    page.keyboard.press("Home")
    page.wait_for_function("field => field.value === '-3 kV'", arg=field.element_handle())
    type_into(page, "Drive: high, value", "1.0003 kV")
    page.wait_for_function("slider => slider.ariaValueText === '1 kV'", arg=slider.element_handle())
    type_into(page, "Layers: gap, thickness, value", "2 um")
    gap = page.get_by_role("slider", name="Layers: gap, thickness", exact=True)
    page.wait_for_function("slider => slider.ariaValueText === '2 µm'", arg=gap.element_handle())
    thumb = gap.locator(".q-slider__thumb").evaluate("thumb => parseFloat(thumb.style.left)")
    assert thumb == float(gap.get_attribute("aria-valuenow")) / 10 > 50
    assert page.locator("[role=slider]").count() == page.locator("[role=slider][aria-valuetext]").count() > 10


def test_a_detection_threshold_is_chosen_on_the_page(opened):
    page = opened(f"?preset={SINE}")
    page.get_by_role("tab", name="Felt").click()
    page.get_by_text(
        "assumed from publications: a detection threshold and a compliance of the skin"
    ).wait_for()
    choose(page, "Compliance of the skin (perception)", "ElasticSkin, begins with example values")
    page.get_by_text("assumed from publications: a detection threshold;").wait_for()
    page.get_by_role("button", name='Expand "Perception"').click()
    field = type_into(page, "Perception: threshold, value", "1 um")
    page.get_by_text("have to be given together").wait_for()
    field.fill("")  # which takes it back
    field.press("Enter")
    page.wait_for_function("() => document.querySelector('[role=alert]').innerText === ''")
    type_into(page, "Perception: threshold, value", "1 um")
    type_into(page, "Perception: threshold uncertainty, value", "3")
    table = {"compliance": ElasticSkin.example | {"model": "ElasticSkin"}}
    wanted = ev.load(SINE).replace({"perception": table | {"threshold": "1 um", "threshold_uncertainty": 3}})
    words = f"{ev.perceive(wanted).sensation:+.1f} dB ("
    page.get_by_text(words).wait_for()
    keep(page, "felt_calibrated")
    page.get_by_role("slider", name="Perception: compliance, stiffness").wait_for()

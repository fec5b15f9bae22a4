"""The animation of one pulse in a real browser: it plays, pauses and is moved by hand, and each moment is that of the numbers."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.units import parse_quantity

pytestmark = pytest.mark.slow

GAP, SINE = "vezzoli_2014/fig6_gap", "bau_2010/sine"


def animated(opened, preset, **options):
    page = opened(f"?preset={preset}", **options)
    page.locator("[aria-busy=false]").wait_for()
    page.get_by_role("tab", name="Why it fades").click()
    page.get_by_role("button", name="Play").wait_for()
    return page, page.get_by_role("slider", name="Time")


def place(slider):
    return int(slider.input_value())


def seconds(slider):
    return parse_quantity(slider.get_attribute("aria-valuetext").replace("µ", "u"), "s")


def test_a_pulse_plays_pauses_and_is_moved_with_the_keyboard(opened):
    page, slider = animated(opened, GAP)
    page.wait_for_timeout(500)
    assert place(slider) == 0  # nothing plays unasked
    assert slider.get_attribute("aria-valuetext") == "0 s"
    said = page.locator(".ev-pulse-said")
    assert said.inner_text().startswith("The voltage goes from 0 V to 1 kV")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("slider => Number(slider.value) > 10", arg=slider.element_handle())
    page.get_by_role("button", name="Pause").click()
    stopped = place(slider)
    page.wait_for_timeout(500)
    assert place(slider) == stopped > 10
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert place(slider) == stopped + 1
    page.keyboard.press("End")
    assert said.inner_text().startswith("There is no voltage, and the force is now less than 1 %")
    page.get_by_role("button", name="Play").click()  # from the beginning again
    page.wait_for_function("slider => Number(slider.value) < 100", arg=slider.element_handle())
    page.get_by_role("button", name="Pause").click()


def newtons(page):
    text = page.locator(".ev-pulse svg text", has_text="force").first.text_content()
    return parse_quantity(text.removeprefix("force ").replace("µ", "u"), "N")


def test_each_moment_has_the_numbers_of_the_library_and_stays_while_a_parameter_moves(opened):
    page, slider = animated(opened, GAP)
    slider.focus()
    for _ in range(22):
        page.keyboard.press("ArrowRight")
    now, weaker = seconds(slider), ev.load(GAP).replace({"drive.high": "500 V"})
    trace = ev.simulate(GAP)
    force = float(np.interp(now, trace.time, trace.electrostatic_force))
    assert newtons(page) == pytest.approx(force, rel=0.03)  # the time has three digits
    field = page.get_by_label("Drive: high, value")
    field.fill("500 V")
    field.press("Enter")
    page.get_by_text("The voltage stays at 500 V").first.wait_for()
    assert seconds(slider) == pytest.approx(now, rel=0.05)  # the next moment that is sent
    trace = ev.simulate(weaker)
    force = float(np.interp(seconds(slider), trace.time, trace.electrostatic_force))
    assert newtons(page) == pytest.approx(force, rel=0.03)


def test_on_a_phone_with_less_motion_it_plays_in_steps_and_fits(opened):
    size = {"width": 390, "height": 844}
    page, slider = animated(opened, SINE, viewport=size, reduced_motion="reduce", color_scheme="dark")
    page.get_by_text("The force does not fade before the voltage turns").wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for picture in page.locator(".ev-pulse svg").all():
        box = picture.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
    page.evaluate("""() => {
      window.moments = new Set();
      const slider = document.querySelector('.ev-pulse input');
      new MutationObserver(() => window.moments.add(slider.getAttribute('aria-valuetext')))
        .observe(slider, {attributes: true});
    }""")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("slider => Number(slider.value) > 20", arg=slider.element_handle())
    page.get_by_role("button", name="Pause").click()
    assert page.evaluate("window.moments.size") < place(slider) / 3  # few steps of many moments


def test_a_current_is_no_pulse(opened):
    page = opened("?preset=kim_2015/current")
    page.get_by_role("tab", name="Why it fades").click()
    page.get_by_text("the drive prescribes a current").wait_for()
    assert page.locator(".ev-pulse:visible").count() == 0

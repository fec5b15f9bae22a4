"""A record of one of two electrodes driven in antiphase: what lies between the two, and what cannot be such a record."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.readback import OneOfTwoInAntiphase

TIME = np.arange(400) * 1e-3
ON = (TIME >= 0.1) & (TIME < 0.3)
HIGH = ON & (np.floor(TIME / 0.01 + 1e-6) % 2 == 0)
OFFSET = 2.0
"""Of the read-back [V]."""
ONE = np.where(HIGH, 300.0, 0.0) + OFFSET
LAST = TIME[np.flatnonzero(HIGH)[-1]]


def drive(voltage=ONE, time=TIME, **readback):
    content = {"model": "Sampled", "time_samples": time, "voltage_samples": voltage}
    return read_model(Drive, content | {"readback": {"model": "OneOfTwoInAntiphase"} | readback})


def test_plus_and_minus_the_supply_by_turns_without_pauses():
    driven = drive().voltage(TIME)
    on = (TIME >= 0.1) & (TIME <= LAST)
    np.testing.assert_array_equal(driven[~on], 0)
    # the offset of the read-back drops out: both polarities are equally large
    np.testing.assert_array_equal(driven[on], np.where(HIGH[on], 300.0, -300.0))


def test_a_negative_supply_gives_the_other_signs():
    np.testing.assert_array_equal(drive(-ONE).voltage(TIME), -drive().voltage(TIME))


def test_the_record_halves_the_mean_square_of_what_it_is_one_electrode_of():
    on = (TIME >= 0.1) & (TIME < 0.3)
    without = drive(ONE - OFFSET)
    assert np.mean(without.voltage(TIME)[on][:-10] ** 2) == 300**2
    assert np.mean((ONE - OFFSET)[on] ** 2) == 300**2 / 2


def test_supply_start_and_stop_are_taken_as_given():
    driven = drive(supply="300 V", start="90 ms", stop="299.5 ms").voltage(TIME)
    # a supply that is given keeps the offset of the read-back, twice
    assert driven[89:92] == pytest.approx([0, -296, -296])
    assert driven[100] == pytest.approx(304)
    assert driven[298:301] == pytest.approx([-296, -296, 0])


def test_an_edge_between_two_samples_passes_through_nothing():
    one = ONE.copy()
    one[np.flatnonzero(HIGH)[10] - 1] = 150 + OFFSET
    assert drive(one).voltage(TIME)[np.flatnonzero(HIGH)[10] - 1] == 0


def test_time_counts_from_the_first_sample():
    late = drive(time=TIME + 7)
    np.testing.assert_array_equal(late.voltage(late.time_stamps), drive().voltage(TIME))
    given = drive(time=TIME + 7, start="99.5 ms", stop=float(LAST) + 1e-6)
    np.testing.assert_array_equal(given.voltage(given.time_stamps), drive().voltage(TIME))


def test_a_single_pulse_and_one_that_never_ends():
    pulse = np.where(ON, 300.0, 0.0)
    np.testing.assert_array_equal(drive(pulse).voltage(TIME), pulse)
    np.testing.assert_array_equal(drive(pulse * 0 + 300).voltage(TIME), 300)


@pytest.mark.parametrize(
    ("voltage", "readback", "words"),
    [
        (
            np.where(HIGH, 150.0, -150.0),
            {},
            "the record extends from -150 to 150 V, but the voltage of one of two electrodes",
        ),
        (0 * ONE, {}, "the record is 0 V throughout"),
        (ONE, {"start": "500 ms", "stop": "600 ms"}, "the drive is on at no sample"),
        (ONE, {"start": "200 ms", "stop": "100 ms"}, "start = 0.2 s has to lie before stop = 0.1 s"),
        (ONE, {"supply": 0}, "a supply of 0 V drives nothing"),
    ],
)
def test_what_cannot_be_one_of_two_electrodes_is_refused(voltage, readback, words):
    with pytest.raises(InputError) as caught:
        drive(voltage, **readback)
    assert len(caught.value.problems) == 1
    assert words in str(caught.value)


def test_a_record_that_says_nothing_is_the_whole_voltage():
    plain = read_model(Drive, {"model": "Sampled", "time_samples": TIME, "voltage_samples": ONE})
    np.testing.assert_array_equal(plain.voltage(TIME), ONE)
    assert OneOfTwoInAntiphase().driving(TIME, ONE).min() == -300

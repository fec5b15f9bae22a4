"""``electrovib run``."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import answered, chosen, say, show_answer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.answer import Document
    from electrovib.scenario import Scenario


_ROUNDING: Final = 1e-12
"""Share of the largest force below which the smallest one is printed as 0."""
_FELT: Final = 30.0
"""Computing time that a run may take to say whether it is felt [s]."""
FORCES = ("electrostatic_force", "lateral_force")


def run(
    context: typer.Context,
    *,
    experiment: options.DefaultScenarioOptions,
    over: options.Texts = None,
    quantity: options.Texts = None,
    records: options.Flag = False,
    states: options.Flag = False,
    voltage: options.Text = None,
    report: options.Text = None,
    saved: options.AnswerOptions,
) -> None:
    """Simulate a scenario once, or over values of a parameter.

    Report the forces and whether a finger feels them, by which tactile channel, and by how many decibels; of a measured Trace
    the latter alone. A Trace that carries its scenario is repeated.

    Parameters
    ----------
    quantity : NAME
        Quantity of each case, for instance 'mean electrostatic_force'; repeatable.
    records
        Keep the signals over time of each case of --over too.
    states
        Find every state of gap and attraction, stable or not, instead: of contact.surface and a layer 'gap'.
    voltage : VOLTAGE
        Of --states: voltage that is held, such as '100 V'; by default the largest of the drive behind its amplifier.
    output : FILE|DIR
        Write the result: .nc, .csv or .mat; a figure (.pdf, .svg, .png); or a folder with all figures.
    """
    from electrovib.apps.run import run
    from electrovib.scenario import scenario_of
    from electrovib.studies.perceive import perceive

    if states:
        options.only(context, "scenario set states voltage output all", "--states")
        return _print_states(experiment, voltage, saved)
    if _is_measured(experiment.scenario):
        of = "a measured Trace, of which only what is felt is computed"
        options.only(context, "scenario set all", of)
        return show_answer(perceive(experiment.scenario, set=experiment.asked["set"]), everything=saved.all)
    accepted = "scenario set over quantity records output report all"
    options.only(context, accepted, "a run without --states")
    asked: dict[str, Any] = {"over": over or (), "quantity": quantity or (), "records": records}
    asked |= {"set": experiment.set or (), "output": saved.output, "report": report, "force": saved.force}
    trace = run(experiment.scenario, **asked)
    found = scenario_of(trace)
    felt = [] if "over" in trace.attrs else felt_lines(found, everything=saved.all)
    sources = chosen(found, experiment.scenario, without=trace.dims)
    return say(*summary(trace, saved.output, report, felt=felt, sources=sources))


def _is_measured(source: str) -> bool:
    """Tell whether a file is a Trace without a scenario, which cannot be run again."""
    from electrovib.core.signals import is_trace
    from electrovib.data.traces import open_if_trace

    found = open_if_trace(source)
    return is_trace(found) and not {"scenario", "over"} & set(found.attrs)


def felt_lines(scenario: "Scenario", *, everything: bool) -> list[str]:
    """State whether a finger feels a run that is judged already, by which channel and by how much, or why it is not known.

    Unless `everything` is asked for, it may take `_FELT` seconds of computing time: it solves the periodic state anew.
    """
    from electrovib.apps.progress import tracked
    from electrovib.core.budget import BudgetError, allowed, budget
    from electrovib.core.errors import ElectrovibError
    from electrovib.physics.perception import Perception
    from electrovib.studies.perceive import perceived

    most = allowed().time if everything else min(allowed().time, _FELT)
    try:
        with tracked("perceiving"), budget(time=most):
            found = perceived(scenario, scenario.perception or Perception(), diagnostics=())
    except ElectrovibError as error:
        if isinstance(error, BudgetError) and not everything:
            return [f"felt or not: takes more than {most:g} s to compute (--all takes that time)"]
        return [f"felt or not: not known: {'; '.join(map(str, error.problems))}"]
    if not everything:
        return [f"{found.headline} (--all lists assumptions)"]
    # title and warnings are those of the run
    said = found.document
    return [*said.sentences[1 if found.title else 0 :], *said.remarks]


def _print_states(
    experiment: options.ScenarioOptions, voltage: str | None, saved: options.AnswerOptions
) -> None:
    from electrovib.core.units import number_in
    from electrovib.physics.roughness import PullingSpots
    from electrovib.scenario import read_scenario
    from electrovib.solve.equilibrium import Balance, equilibrium

    scenario = read_scenario(experiment.scenario, changes=experiment.asked["set"])
    held = number_in("V", "--voltage", voltage) if voltage else None

    def balance() -> Balance:
        surface = scenario.contact.surface
        rough = surface is not None and surface.is_rough
        return equilibrium(scenario, voltage=held, spots=PullingSpots() if rough else None)

    answered(Balance, balance, "finding equilibria", {}, saved)
    say(*chosen(scenario, experiment.scenario))


def summary(
    trace: Any,
    output: str | None,
    report: str | None,
    *,
    felt: Sequence[str] = (),
    sources: Sequence[str] = (),
) -> list[str]:
    """Summarise the result in a few lines, among them whether it is `felt`, and what is known of the `sources` of its values."""
    from electrovib.apps.cli.terminal import is_map
    from electrovib.core.diagnostics import diagnostics_of, warning_lines
    from electrovib.view.summary import quantities_of_run

    lines = [trace.attrs["title"]] if trace.attrs["title"] else []
    if "over" in trace.attrs:
        lines += _numbers(trace)
    else:
        ends = quantities_of_run(
            trace, [f"{end} {name}" for name in FORCES for end in ("minimum", "maximum")]
        )
        lines += [f"{name.replace('_', ' ')}: {_range(trace, name, ends)}" for name in FORCES]
    lines += felt
    if trace.attrs.get("reduction_error") and "transfer_error" in trace.attrs:
        name, of = "transfer_error", ""
        if "attraction_error" in trace.attrs:
            name, of = "attraction_error", " of the peak attraction"
        error = 100 * float(trace.attrs[name])
        lines.append(f"error through materials reduced to relaxations: at most {error:.2g} %{of}")
    lines += [*warning_lines(diagnostics_of(trace), brief=is_map(trace)), *sources]
    lines.append(f"solver: {trace.attrs['solver']}")
    if "friction_solver" in trace.attrs:
        lines.append(f"friction: {trace.attrs['friction_solver']}")
    if dropped := trace.attrs["dropped_samples"]:
        words = "1 sample of the drive was" if dropped == 1 else f"{dropped} samples of the drive were"
        lines.append(f"warning: {words} dropped")
    return lines + [_written(path, trace) for path in (output, report) if path]


def _written(path: str, trace: Any) -> str:
    from electrovib.view.files import written

    def document() -> "Document":
        from electrovib.view.report import document_of

        return document_of({"": trace})

    return written(path, document, (".csv",))


def _range(trace: Any, name: str, ends: "Mapping[str, float]") -> str:
    """Return the range of a force over the whole run, where its `ends` are known, and how often it is unknown."""
    from electrovib.core.units import format_quantity
    from electrovib.view.summary import not_known

    if missing := not_known(trace, name):
        if not bool(trace[name].notnull().any()):
            return missing
        missing = f", {missing}"
    found = [ends.get(f"{end} {name}", math.nan) for end in ("minimum", "maximum")]
    if not all(map(math.isfinite, found)):
        found = [float(trace[name].min()), float(trace[name].max())]
        missing = missing or " at the output times"
    least, most = found
    if abs(least) < _ROUNDING * abs(most):
        least = 0.0
    low, high = (format_quantity(edge, "N", digits=4) for edge in (least, most))
    if low == high and most > least:
        high += f" (a change of {format_quantity(most - least, 'N', digits=4)})"
    return f"{low} to {high}{missing}"


def _numbers(trace: Any) -> list[str]:
    """Return the range of each quantity of a sweep, and where its ends are."""
    from electrovib.apps.cli.terminal import is_map
    from electrovib.view.summary import quantity_ranges

    over = ", ".join(
        f"{path} ({trace.sizes[path]} values)" for path in trace.sizes if path in trace.attrs["over"]
    )
    ranges = quantity_ranges(trace, plain=True, named=not is_map(trace))
    lines = [f"over {over}; numbers of {trace.attrs['taken_over']}"] if over else []
    return lines + [f"{name}: {text}" for name, text in ranges.items()]

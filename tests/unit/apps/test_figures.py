"""Figures from every command, by the suffix of -o."""

import pytest

SHORT = "vezzoli_2014/fig6 --set time.samples=21"
LIMITED = "--set limits.voltage='1 kV' --set limits.current='250 uA'"
LINES = [
    "run vezzoli_2014/fig6 --set time.samples=21",
    "check vezzoli_2014/fig6",
    "fit vezzoli_2014/fig6 t.nc --free friction.coefficient --noise 'lateral_force=5 mN'",
    f"drive-for-force {SHORT} --target 'sine 50 Hz 1 mN' --method carrier --carrier '3 kHz' {LIMITED}",
    "plan-plate bau_2010/sine --over stack.insulator.thickness=1um:20um:2log --materials silica",
    'texture-drive vezzoli_2014/fig6 --texture \'{ model = "Grating", period = "2 mm", amplitude = "1 mN" }\' --path \'30 mm/s\''
    f" --carrier '3 kHz' {LIMITED}",
]
LONGER = [
    "run vezzoli_2014/fig6 --over drive.high=100V:1kV:3",
    "compare vezzoli_2014/fig6 --models Vezzoli2014Causal,MaxwellStressInInsulator",
    "compare bau_2010/sine --materials silica,pet",
    "report t.nc",
    "times t.nc --quantity drive_voltage",
    "study vezzoli_2014/fig6 --space fingers -n 20 --seed 1 -o s.zarr",
    "study vezzoli_2014/fig6 --space fingers -n 8 --seed 1 --sensitivity --quantity 'peak electrostatic_force'",
    "evidence vezzoli -n 4",
    f"find-value {SHORT} --want 'peak electrostatic_force = 1 mN' --free drive.high",
    "value-for-share bau_2010/sine --want 'mean electrostatic_force = 1 mN' --free drive.amplitude --space fingers --share 0.9"
    " --seed 1 -n 20",
]
"""Commands whose figures take longer to compute or to draw."""


@pytest.mark.parametrize("line", [*LINES, *(pytest.param(line, marks=pytest.mark.slow) for line in LONGER)])
def test_every_command_writes_its_figure_for_a_journal(line, here, cli):
    if " t.nc" in line:
        assert cli("run vezzoli_2014/fig6 --set time.samples=101 -o t.nc")[0] == 0
    code, out, err = cli(f"{line} -o x.pdf --style journal")
    assert code in {0, 1, 3, 5}, err
    assert "written: x.pdf" in out
    content = (here / "x.pdf").read_bytes()
    assert b"/MediaBox [ 0 0 240.94" in content
    assert b"/FontFile2" in content


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("run vezzoli_2014/fig6 -o x.nc --style journal", "--style = journal: belongs to a figure"),
        ("check vezzoli_2014/fig6 --style journal", "--style = journal: belongs to a figure"),
        ("check vezzoli_2014/fig6 -o x.pdf --style poster", "--style = poster: expected journal"),
        ("check vezzoli_2014/fig6 -o gone/x.pdf", "the folder 'gone' does not exist"),
        ("init vezzoli_2014/fig6 -o x.pdf", ".toml"),
    ],
)
def test_a_style_without_a_figure_and_a_figure_of_nothing_are_refused(line, words, refused):
    assert words in refused(line)


def test_a_record_of_a_bench_is_no_picture(refused):
    err = refused("bench run vezzoli_2014/fig6 --simulate -o x.pdf", silent=False)
    assert "x.pdf: a Trace is saved as .nc, .csv, .mat, not as '.pdf'." in err

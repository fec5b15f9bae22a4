"""A file of ours is known by the checksum in it, and by nothing else."""

import pytest

from electrovib.core.errors import InputError
from electrovib.data.atomic import check_writable, write_text, writing
from electrovib.data.marks import Form, is_ours, sign, unsigned

FORMS = list(Form)


def marked(form: Form, *, more: str = "") -> str:
    return f"first\n# {unsigned(form)}\n{more}last\n"


@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_in_a_form_is_ours_in_this_form_only(tmp_path, form):
    path = tmp_path / "x"
    write_text(path, marked(form), form)
    assert [other for other in FORMS if is_ours(path, other)] == [form]
    assert unsigned(form) not in path.read_text()
    assert path.read_text().startswith(f"first\n# electrovib {form}, checksum ")


def test_one_changed_sign_makes_it_the_users(tmp_path):
    path = tmp_path / "x"
    write_text(path, marked(Form.PAGE), Form.PAGE)
    whole = path.read_bytes()
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 1
        path.write_bytes(changed)
        assert not is_ours(path, Form.PAGE)


def test_added_and_cut_content_makes_it_the_users(tmp_path):
    path = tmp_path / "x"
    write_text(path, marked(Form.PAGE), Form.PAGE)
    content = path.read_bytes()
    for changed in (content + b"\n", content[:-1], content[1:], b""):
        path.write_bytes(changed)
        assert not is_ours(path, Form.PAGE)


@pytest.mark.parametrize("size", [0, 10, 1 << 20, (1 << 20) + 200])
def test_content_of_any_length_counts(tmp_path, size):
    path = tmp_path / "x"
    write_text(path, marked(Form.CSV, more="7" * size), Form.CSV)
    assert is_ours(path, Form.CSV)
    path.write_text(path.read_text().replace("last", "lost"))
    assert not is_ours(path, Form.CSV)


def test_a_mark_without_its_checksum_is_nobodys(tmp_path):
    path = tmp_path / "x"
    path.write_text(marked(Form.PAGE))
    assert not is_ours(path, Form.PAGE)
    assert not is_ours(tmp_path / "none", Form.PAGE)
    assert not is_ours(tmp_path, Form.PAGE)
    path.write_text("no mark")
    sign(path, Form.PAGE)
    assert path.read_text() == "no mark"


def test_a_file_that_is_not_ours_is_kept(tmp_path):
    path = tmp_path / "x"
    path.write_text("older")
    words = r"x: exists already and is no HTML page that electrovib wrote.*another name.*--force"
    with pytest.raises(InputError, match=words):
        check_writable({path: Form.PAGE})
    with pytest.raises(InputError, match=words):
        write_text(path, marked(Form.PAGE), Form.PAGE)
    with pytest.raises(InputError, match="somebody else's"), writing({path: None}):
        pytest.fail("must not start")
    assert path.read_text() == "older"
    write_text(path, marked(Form.PAGE), Form.PAGE, force=True)
    assert is_ours(path, Form.PAGE)
    write_text(path, marked(Form.PAGE, more="newer"), Form.PAGE)
    assert "newer" in path.read_text()
    with pytest.raises(InputError, match="is no netlist that"):
        check_writable({path: Form.NETLIST})


def test_an_input_is_never_replaced(tmp_path):
    path, link, hard = (tmp_path / name for name in ("x", "link", "hard"))
    write_text(path, marked(Form.PAGE), Form.PAGE)
    link.symlink_to(path)
    hard.hardlink_to(path)
    for output in (path, link, hard, tmp_path / "sub" / ".." / "x"):
        (tmp_path / "sub").mkdir(exist_ok=True)
        with pytest.raises(InputError, match=r"is an input, read as .*another name"):
            check_writable({output: Form.PAGE}, inputs=[tmp_path / "gone", path], force=True)
    check_writable({path: Form.PAGE}, inputs=[tmp_path / "gone"])


def test_two_outputs_are_two_files(tmp_path):
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(InputError, match="is the same file as the output"):
        check_writable({tmp_path / "a": None, tmp_path / "b": None})

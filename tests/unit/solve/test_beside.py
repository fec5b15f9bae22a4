"""What is done beside a run of very many times."""

import importlib
import threading

import pytest

provenance = importlib.import_module("electrovib.solve.simulate")


def test_a_long_run_has_its_record_written_in_another_thread():
    with provenance.beside(provenance._MANY, lambda: {"by": threading.get_ident()}) as stated:
        assert stated()["by"] != threading.get_ident()
    with provenance.beside(provenance._MANY - 1, lambda: {"by": threading.get_ident()}) as stated:
        assert stated()["by"] == threading.get_ident()


def test_what_fails_there_fails_here():
    def fail():
        raise KeyError("scenario")

    with pytest.raises(KeyError, match="scenario"), provenance.beside(provenance._MANY, fail) as stated:
        stated()

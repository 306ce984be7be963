"""Pages of a server: several, each with a name of its own."""

from __future__ import annotations

import re

import pytest

from amorsim.core.errors import AmorsimError
from amorsim.ui.serve.pages import KINDS, WEB, Pages
from tests.ui.stub import StubSession


def test_sessions_have_names_of_their_own_that_need_no_quoting() -> None:
    pages = Pages()
    names = ["demo", "demo", "my room (2)", "../../etc", "ü", "", "a/b"]
    added = [pages.add("run", name, StubSession()) for name in names]
    assert [page.name for page in added[:4]] == ["demo", "demo-2", "my-room-2", "etc"]
    assert len({page.path for page in added}) == len(names)
    for page in added:
        assert re.fullmatch(r"/run/[A-Za-z0-9_][A-Za-z0-9_.-]*", page.path)
        assert pages.find("run", page.name) is page
    assert list(pages) == added
    assert pages.find("run", "nothing") is None


def test_a_page_is_of_a_kind_that_there_is() -> None:
    with pytest.raises(AmorsimError, match="expected a kind of page, 'run', 'edit', 'faults'; got 'fly'"):
        Pages().add("fly", "demo", StubSession())
    for kind, (start, styles) in KINDS.items():
        assert Pages().add(kind, "demo", StubSession()).kind == kind
        for name in (start, *styles):
            assert (WEB / name).is_file()


def test_a_page_that_is_removed_is_gone_and_its_name_free_again() -> None:
    pages = Pages()
    edit, run = pages.add("edit", "demo", StubSession()), pages.add("run", "demo", StubSession())
    pages.remove(run)
    assert pages.find("run", "demo") is None
    assert pages.first is edit
    assert pages.add("run", "demo", StubSession()).path == "/run/demo"


def test_a_pages_session_can_be_replaced_and_another_page_be_the_first() -> None:
    pages = Pages()
    assert pages.first is None
    faults = pages.add("faults", "demo", StubSession())
    run = pages.add("run", "demo", StubSession())
    assert pages.first is faults
    session = StubSession()
    new = pages.replace(faults, session)
    assert (new.path, new.session) == ("/faults/demo", session)
    assert pages.find("faults", "demo") is pages.first is new
    pages.first = run
    assert pages.replace(run, session) is pages.first
    assert list(pages) == [new, pages.first]

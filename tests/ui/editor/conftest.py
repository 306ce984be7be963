"""One reading process for all tests of the Editor's session."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from amorsim.ui.editor.reader import Reader
from tests.ui.editor.talking import READERS


@pytest.fixture(scope="session", autouse=True)
def reader() -> Iterator[Reader]:
    """It starts with the first session that needs it."""
    READERS.append(Reader())
    yield READERS[0]
    READERS.pop().close()

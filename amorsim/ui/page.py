"""The page that the browser loads: NiceGUI's, with one component of ours in it, whose inside is plain JavaScript."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui
from nicegui.element import Element

__all__ = ["WEB", "WEB_PATH"]

WEB = Path(__file__).parent / "web"
WEB_PATH = "/amorsim/web"


class Window(Element, component="web/amorsim_window.js"):  # type: ignore[call-arg, unused-ignore]
    """What `simulator.js` fills; the Editor's page has the same component with another entry."""

    def __init__(self, entry: str) -> None:
        super().__init__()
        self._props["entry"] = f"{WEB_PATH}/{entry}"


@ui.page("/", title="amorsim", language="en-US")
def simulator_page() -> None:
    """The Simulator. It knows no session: the window's WebSocket does."""
    for sheet in ("look.css", "simulator.css"):
        ui.add_head_html(f'<link rel="stylesheet" href="{WEB_PATH}/{sheet}">')
    Window("simulator.js")

"""A live simulation in a notebook: `am.widget`."""

from __future__ import annotations

import base64
import functools
import gzip
import importlib.util
from pathlib import Path
from typing import Any

from amorsim.core.arguments import checked
from amorsim.core.errors import AmorsimError
from amorsim.simulation.simulation import Simulation
from amorsim.ui.serve.html_page import closed_document
from amorsim.ui.simulator.in_process import Live

__all__ = ["REFUSED", "widget"]

REFUSED = {
    "reload": "run the cell again that made this widget",
    "restart": "run the cell again that made this widget",
    "page": "am.run_page makes a page of a run that am.run has recorded",
    "save_run": "runs are recorded by am.run; this simulation belongs to the notebook, which may have changed it",
    "replica": "this is one replica; make another simulation for another one",
}
_SCRIPT = Path(__file__).parents[1] / "web" / "notebook" / "widget.js"


@checked
def widget(simulation: Simulation, *, height: int = 560) -> Any:
    """The Simulator's window in a notebook, for a simulation of the notebook's own.

    Play, pause, step and go back in time, drive by keys and set errors by sliders; what the next cell sees is the
    simulation as it stands on the screen. While a cell runs, the window waits. If a cell moves the simulation, the
    window's time line begins there. Where there is no kernel, as in a notebook on a website, it is a picture.

    Parameters
    ----------
    simulation
        Of one replica; at its start, or wherever it is.
    height
        Of the window [pixels]; its lower edge can be drawn.

    Returns
    -------
    anywidget.AnyWidget
        For the last line of a cell, or for `IPython.display.display`.

    Raises
    ------
    AmorsimError
        If anywidget is missing (extra ``notebook``), or the simulation has several replicas.
    """
    if importlib.util.find_spec("anywidget") is None:
        raise AmorsimError('a widget needs the extra "notebook": python -m pip install "amorsim[notebook]"')
    return _widget_class()(simulation, height)


@functools.cache
def _page() -> str:
    """The window's page, gzipped, in base64."""
    page = closed_document("simulator/notebook.js")
    return base64.b64encode(gzip.compress(page.encode(), 9, mtime=0)).decode()


@functools.cache
def _widget_class() -> Any:
    import anywidget
    import traitlets

    class SimulatorWidget(anywidget.AnyWidget):
        """The view of a simulation, for notebooks."""

        _esm = _SCRIPT.read_text(encoding="utf-8")
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(560).tag(sync=True)

        def __init__(self, simulation: Simulation, height: int) -> None:
            self.simulation = simulation
            self._live = Live(simulation, self._send_frame, REFUSED)
            super().__init__(page=_page(), height=height)
            self.on_msg(self._heard)

        def _send_frame(self, frame: bytes) -> None:
            self.send({"frame": True}, buffers=[frame])

        def _heard(self, _: Any, message: Any, __: Any) -> None:
            """Handle a window's message: it opened, closed, received a frame, or asks something."""
            if not isinstance(message, dict) or not isinstance(window := message.get("window"), str):
                return
            if message.get("is") == "open":
                self.send({"window": window})
                self._live.open_window(window)
            elif message.get("is") == "gone":
                self._live.close_window(window)
            elif message.get("is") == "received":
                self._live.received(window)
            elif isinstance(command := message.get("command"), dict):
                number = command.pop("id", None)
                self.send({"window": window, "answer": number, "said": self._live.ask(window, command)})

        def _repr_mimebundle_(self, **options: Any) -> Any:
            """The widget, and beside it the picture of the simulation for where there is no kernel."""
            shown = super()._repr_mimebundle_(**options)
            data, metadata = shown if isinstance(shown, tuple) else (shown or {}, {})
            return {**self.simulation._repr_mimebundle_(), **data}, metadata

        def __repr__(self) -> str:
            return f"<widget of {self.simulation!r}>"

    return SimulatorWidget

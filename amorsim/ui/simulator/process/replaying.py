"""The child's commands for a recorded run."""

from __future__ import annotations

from collections.abc import Callable

from amorsim.ui.scene.wire import Scene
from amorsim.ui.simulator.frames.protocol import State
from amorsim.ui.simulator.process.watching import Answer, Table, Watching
from amorsim.ui.simulator.sources.recording import Recording

__all__ = ["Replaying"]


class Replaying(Watching):
    """Carries out commands on a recorded run; another replica can be chosen."""

    def __init__(self, recording: Recording, is_ending: Callable[[], bool] = lambda: False) -> None:
        super().__init__(recording, is_ending)
        self._recording = recording
        self._does["replica"] = self._replica

    @property
    def scene(self) -> Scene:
        """Everything that does not change while the replica is played."""
        return self._recording.scene

    def picture(self, name: str) -> bytes:
        """The PNG that a map's shape names; raises as `MapShapes.picture`."""
        return self._recording.picture(name)

    def state(self) -> State:
        """Its state, and what is wrong with the files."""
        damage = self._recording.damage
        return {**super().state(), "damage": damage} if damage else super().state()

    def _refusal(self, name: str) -> str:
        """The answer to a command that would change something."""
        return f"{name}: this is a recorded run, which cannot be changed; amorsim view simulates"

    def _replica(self, command: Table) -> Answer:
        self._recording.choose(self._whole(command, "number"))
        return {"scene": self.scene}

"""The inputs and results of each stage of a sensor's noise chain, kept in memory, so that each can be recomputed."""

from __future__ import annotations

import collections
from collections.abc import Iterator, Mapping
from types import TracebackType

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State
from amorsim.core.arguments import check_kind, checked, whole
from amorsim.core.errors import AmorsimError
from amorsim.core.rows import take
from amorsim.core.unknown_names import no_such
from amorsim.simulation.fleet.group import Group
from amorsim.simulation.simulation import Simulation
from amorsim.simulation.state.snapshot import copy_state

__all__ = ["KeptStages", "Stage", "keep_stages"]


@attrs.frozen(kw_only=True, eq=False)
class Stage:
    """One element of a chain at work on one reading of one robot.

    Attributes
    ----------
    element
        Its name in the chain.
    noise
        The element, with its parameters as arrays of one row.
    tick
        The tick of the reading.
    values, result
        Its input and its output `(k,)`; for an element of one column, that column's.
    side
        What it used of the sensor's further quantities, by name `(k,)`.
    elapsed
        Time [s] since the previous sample.
    """

    element: str
    noise: Noise
    tick: int
    values: Array
    result: Array
    side: Mapping[str, Array]
    elapsed: float
    _state: State = attrs.field(alias="state")  # before the stage, of one row
    _draws: Draws = attrs.field(alias="draws")  # at their position then, of one row

    def recompute(self) -> Array:
        """The element's output `(k,)` for the same inputs, recomputed; equal to `result`, bit for bit."""
        side = {name: array[None].copy() for name, array in self.side.items()}
        elapsed = np.array([[self.elapsed]])
        state = copy_state(self.element, self._state)
        first = np.zeros(1, dtype=np.intp)
        made = self.noise.corrupt(self.values[None].copy(), side, elapsed, state, self._draws.still(first))
        return np.asarray(made[0])


@attrs.frozen(kw_only=True, eq=False)
class _Sample:
    """A stage over all rows of a group."""

    noise: Noise
    counter: npt.NDArray[np.uint32]  # (N, 3) replica, episode, tick
    values: Array
    result: Array
    side: Mapping[str, Array]
    elapsed: Array
    state: State
    draws: Draws

    def of(self, row: int, name: str) -> Stage:
        which = np.array([row], dtype=np.intp)
        return Stage(
            element=name,
            noise=take(self.noise, which),
            tick=int(self.counter[row, 2]),
            values=self.values[row],
            result=self.result[row],
            side={key: array[row] for key, array in self.side.items()},
            elapsed=float(self.elapsed[row, 0]),
            state={key: array[which] for key, array in self.state.items()},
            draws=self.draws.still(which),
        )


class _Asked(Mapping[str, Array]):
    """A sensor's further quantities, which records those that were read."""

    def __init__(self, side: Mapping[str, Array]) -> None:
        self._side = side
        self.answers: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        self.answers[name] = self._side[name]
        return self.answers[name]

    def __contains__(self, name: object) -> bool:
        return name in self._side

    def __iter__(self) -> Iterator[str]:
        return iter(self._side)

    def __len__(self) -> int:
        return len(self._side)


class _Watch:
    """Calls the elements of one chain, and keeps their inputs and outputs."""

    def __init__(self, most: int) -> None:
        self.kept: dict[int, collections.deque[_Sample]] = {}
        self._most = most

    def __call__(
        self,
        index: int,
        noise: Noise,
        values: Array,
        side: Mapping[str, Array],
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Array:
        asked, before, given = _Asked(side), copy_state("an element", state), values.copy()
        still = draws.still(np.arange(len(values)))
        result = noise.corrupt(values, asked, elapsed, state, draws)
        self.kept.setdefault(index, collections.deque(maxlen=self._most)).append(
            _Sample(
                noise=noise,
                counter=still.counter,
                values=given,
                result=result.copy(),
                side={name: array.copy() for name, array in asked.answers.items()},
                elapsed=elapsed.copy(),
                state=before,
                draws=still,
            )
        )
        return result


@checked
class KeptStages:
    """The stages of all sensors of a simulation since `keep_stages`; as a context manager it stops at its end."""

    def __init__(self, simulation: Simulation, samples: int) -> None:
        self._simulation = simulation
        self._watches: dict[tuple[int, str], _Watch] = {}
        self._groups: list[Group] = list(simulation._fleet.groups)
        for group in self._groups:
            for name, unit in group.sensors.items():
                unit.chain.watch = self._watches[id(group), name] = _Watch(samples)
            group.set_parameters()  # sensors that are read together have no separate stages

    @checked
    def stages(self, robot: str, sensor: str, *, replica: int | None = None) -> list[Stage]:
        """The stages of the reading that a robot holds now, in the order of the chain.

        Only elements that change values have a stage, not those that bend beams or delay arrivals. The input of the
        first is what the device sensed, the output of the last is what the robot received.

        Raises
        ------
        AmorsimError
            If there is no such sensor, the reading was taken before stages were kept, or too long ago.
        """
        handle = self._simulation.robot(robot, replica)
        group, row = handle._group, handle._row
        if sensor not in group.sensors:
            raise AmorsimError(no_such("sensor", sensor, group.sensors, whose=f"robot {robot!r}"))
        unit = group.sensors[sensor]
        watch = self._watches.get((id(group), sensor))
        moment = group.row_clock.counter[row, 0], group.row_clock.counter[row, 1], int(unit.stamp[row, 0])
        found = []
        for index in unit.chain.corrupts:
            samples = watch.kept.get(index, ()) if watch is not None else ()
            sample = next((s for s in reversed(samples) if tuple(s.counter[row].tolist()) == moment), None)
            if sample is None:
                raise AmorsimError(
                    f"robot {robot!r}, sensor {sensor!r}: the stages of its reading of tick {moment[2]} were not kept; "
                    "keep_stages(sim, samples=N) keeps those of the newest N samples from then on"
                )
            found.append(sample.of(row, unit.chain.names[index]))
        return found

    @checked
    def last_stage(self, robot: str, sensor: str, *, replica: int | None = None) -> Stage:
        """The stage that gave the robot its reading; raises as `stages`, and if no element changes values."""
        found = self.stages(robot, sensor, replica=replica)
        if not found:
            raise AmorsimError(
                f"robot {robot!r}, sensor {sensor!r}: no element of its chain changes values: what it measured is what "
                "the device saw"
            )
        return found[-1]

    def close(self) -> None:
        """Stop keeping stages; those kept so far stay."""
        for group in self._groups:
            for name, unit in group.sensors.items():
                if unit.chain.watch is self._watches[id(group), name]:
                    unit.chain.watch = None
            group.set_parameters()

    def __enter__(self) -> KeptStages:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def keep_stages(simulation: Simulation, *, samples: int = 1000) -> KeptStages:
    """Keep in memory, from now on, the input and output of every stage of every sensor's chain.

    ::

        kept = am.keep_stages(simulation)
        simulation.run(1.0)
        stage = kept.last_stage("rover", "laser")
        assert (stage.recompute() == simulation.robot("rover").readings["laser"].measured).all()

    The simulation's results stay the same, bit for bit; steps take longer. A new seed (`Simulation.reset`) ends it.

    Parameters
    ----------
    samples
        The number of latest samples to keep of each sensor.
    """
    check_kind(simulation, Simulation, "simulation", "a Simulation, as am.Simulation(am.load('demo'))")
    return KeptStages(simulation, whole(samples, "samples", "a whole number > 0", least=1))

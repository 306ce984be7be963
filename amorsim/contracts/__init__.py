"""The contracts for plugin authors: the kinds of component, their inputs and their outputs.

A component is an ``attrs.frozen(kw_only=True)`` class whose fields are its parameters (`parameter`). It is written
once, over **rows**: a row is one robot in one replica of the scenario. In the engine its fields hold arrays: a number
is `(N, 1)`, so that ``values * self.scale`` broadcasts over `(N, k)`; see `amorsim.core.rows.stack`. Static fields
(`parameter(static=True)`), texts and flags stay plain, because they are equal in all rows of a group.

A component stores nothing on itself. What changes from step to step lives in ``state``, the dict of row-first arrays
that `start` returned: write into its arrays, or replace them by arrays of the same shape and dtype. The engine owns
the state, copies it for a snapshot, and resets single rows of it.

Results must not depend on the number of rows, to the bit: use elementwise NumPy, `amorsim.core.poses`, or a kernel,
never ``@``, ``dot`` or a sum over the rows. `amorsim.testing.check_component` tests all of this.
"""

from __future__ import annotations

from amorsim.contracts.binding import ControllerBinding, DriveBinding, EstimatorBinding, SensorBinding
from amorsim.contracts.controller import Controller
from amorsim.contracts.estimator import Estimator
from amorsim.contracts.map_loader import MapLoader
from amorsim.contracts.metric import Episode, Metric
from amorsim.contracts.motion import Motion
from amorsim.contracts.noise import Noise
from amorsim.contracts.planner import Plan, Planner
from amorsim.contracts.recorder import Frame, ObstacleFrame, Recorder, RunInfo
from amorsim.contracts.robot import Context, Drive, Joint, Part, RobotModel, Sensor, SensorModel
from amorsim.contracts.scenario_loader import ScenarioDocument, ScenarioLoader
from amorsim.contracts.side import Side
from amorsim.contracts.task import Observable, StepOutcome, Task, TrueState
from amorsim.contracts.values import Aim, Beliefs, Clock, Estimate, LazyBeliefs, Measurement, State
from amorsim.contracts.view import (
    BodyStates,
    Directions,
    Emission,
    Emissions,
    FloorPoints,
    Lights,
    Neighbours,
    Sightings,
    View,
)
from amorsim.contracts.world_generator import WorldGenerator
from amorsim.core.draws import Draws
from amorsim.core.noise_steps import NoiseStep
from amorsim.core.parameters import parameter
from amorsim.core.poses import Mount

__all__ = [
    "Aim",
    "Beliefs",
    "BodyStates",
    "Clock",
    "Context",
    "Controller",
    "ControllerBinding",
    "Directions",
    "Draws",
    "Drive",
    "DriveBinding",
    "Emission",
    "Emissions",
    "Episode",
    "Estimate",
    "Estimator",
    "EstimatorBinding",
    "FloorPoints",
    "Frame",
    "Joint",
    "LazyBeliefs",
    "Lights",
    "MapLoader",
    "Measurement",
    "Metric",
    "Motion",
    "Mount",
    "Neighbours",
    "Noise",
    "NoiseStep",
    "Observable",
    "ObstacleFrame",
    "Part",
    "Plan",
    "Planner",
    "Recorder",
    "RobotModel",
    "RunInfo",
    "ScenarioDocument",
    "ScenarioLoader",
    "Sensor",
    "SensorBinding",
    "SensorModel",
    "Side",
    "Sightings",
    "State",
    "StepOutcome",
    "Task",
    "TrueState",
    "View",
    "WorldGenerator",
    "parameter",
]

"""amorsim: mobile robots in the plane, where every quantity is true, measured and estimated.

Everything that a user or a plugin author needs is here; the names are looked up when first used, so that importing
the package costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from amorsim.core.display import show_by

if TYPE_CHECKING:
    from amorsim import (
        algorithms,
        analysis,
        controllers,
        drives,
        estimators,
        metrics,
        motions,
        noise,
        planners,
        sensors,
        tasks,
        testing,
        worlds,
    )
    from amorsim.contracts import (
        Aim,
        Beliefs,
        Clock,
        Context,
        Controller,
        Draws,
        Drive,
        Emission,
        Episode,
        Estimate,
        Estimator,
        FloorPoints,
        Frame,
        Joint,
        Lights,
        MapLoader,
        Measurement,
        Metric,
        Motion,
        Mount,
        Noise,
        NoiseStep,
        Observable,
        ObstacleFrame,
        Part,
        Plan,
        Planner,
        Recorder,
        RobotModel,
        RunInfo,
        ScenarioDocument,
        ScenarioLoader,
        Sensor,
        SensorModel,
        Sightings,
        State,
        StepOutcome,
        Task,
        TrueState,
        View,
        WorldGenerator,
        parameter,
    )
    from amorsim.controllers.user import Twist, WheelSpeeds
    from amorsim.core.errors import (
        AmorsimError,
        AnalysisError,
        ComponentError,
        ContactError,
        ControllerError,
        DocumentError,
        Fault,
        GraphError,
        MapError,
        PlanError,
        PluginError,
        RunError,
        ScenarioError,
        ShapeError,
        SnapshotError,
        StudyError,
    )
    from amorsim.core.estimated_map import estimated_map
    from amorsim.core.map import Map
    from amorsim.core.parameters import ParameterError
    from amorsim.core.poses import compose, exponential, logarithm, relative, wrap_angle
    from amorsim.core.rows import stack
    from amorsim.core.shapes import Shape
    from amorsim.plugins.hooks import hookimpl
    from amorsim.plugins.registry import Registry
    from amorsim.render.plan_picture import draw_plan
    from amorsim.reports.report import report
    from amorsim.runs.drawing import draw
    from amorsim.runs.reproduce import reproduce
    from amorsim.runs.run import run
    from amorsim.runs.session import RunSession, RunSummary, record
    from amorsim.scenario.documents.document import Document, open_document
    from amorsim.scenario.documents.origins import Origin
    from amorsim.scenario.files.devices import load_device
    from amorsim.scenario.files.maps import load_map, save_map
    from amorsim.scenario.files.model_files import save_device, save_robot
    from amorsim.scenario.knowledge import Knowledge
    from amorsim.scenario.programs.code_check import check_code
    from amorsim.scenario.random_start import RandomStart
    from amorsim.scenario.reading.partial import Outline, Partial
    from amorsim.scenario.reading.read import load
    from amorsim.scenario.reading.robots import load_robot
    from amorsim.scenario.spec import (
        Deviation,
        Distribution,
        Drop,
        Floor,
        InitialBelief,
        Kidnapping,
        Landmark,
        Light,
        Marking,
        MountedSensor,
        NoiseElement,
        Obstacle,
        Pose,
        Recording,
        Robot,
        Scenario,
        Zone,
    )
    from amorsim.simulation.estimator_runner import EstimatorRunner
    from amorsim.simulation.events import Event
    from amorsim.simulation.noise_stages import KeptStages, Stage, keep_stages
    from amorsim.simulation.schedule import PHASES
    from amorsim.simulation.simulation import Simulation
    from amorsim.sweeps.sweep import sweep
    from amorsim.sweeps.table import Study, read_study
    from amorsim.ui.notebook.widget import widget
    from amorsim.ui.run_page.document import run_page
    from amorsim.ui.view import view

_MODULES = {
    "amorsim.contracts": (
        "Aim Beliefs Clock Context Controller Drive Draws Emission Episode Estimate Estimator FloorPoints Frame Joint "
        "Lights MapLoader Measurement Metric Motion Mount Noise NoiseStep Observable ObstacleFrame Part Plan Planner "
        "Recorder RobotModel RunInfo ScenarioDocument ScenarioLoader Sensor SensorModel Sightings State StepOutcome "
        "Task TrueState View WorldGenerator parameter"
    ),
    "amorsim.controllers.user": "Twist WheelSpeeds",
    "amorsim.core.errors": (
        "AmorsimError AnalysisError ComponentError ContactError ControllerError DocumentError Fault GraphError "
        "MapError PlanError PluginError RunError ScenarioError ShapeError SnapshotError StudyError"
    ),
    "amorsim.core.estimated_map": "estimated_map",
    "amorsim.core.map": "Map",
    "amorsim.core.parameters": "ParameterError",
    "amorsim.core.poses": "compose exponential logarithm relative wrap_angle",
    "amorsim.core.shapes": "Shape",
    "amorsim.core.rows": "stack",
    "amorsim.plugins.hooks": "hookimpl",
    "amorsim.plugins.registry": "Registry",
    "amorsim.scenario.programs.code_check": "check_code",
    "amorsim.scenario.knowledge": "Knowledge",
    "amorsim.scenario.files.maps": "load_map save_map",
    "amorsim.scenario.files.model_files": "save_device save_robot",
    "amorsim.scenario.documents.origins": "Origin",
    "amorsim.scenario.reading.partial": "Outline Partial",
    "amorsim.scenario.files.devices": "load_device",
    "amorsim.scenario.documents.document": "Document open_document",
    "amorsim.scenario.reading.robots": "load_robot",
    "amorsim.scenario.random_start": "RandomStart",
    "amorsim.scenario.reading.read": "load",
    "amorsim.scenario.spec": (
        "Deviation Distribution Drop Floor InitialBelief Kidnapping Landmark Light Marking MountedSensor NoiseElement "
        "Obstacle Pose Recording Robot Scenario Zone"
    ),
    "amorsim.simulation.estimator_runner": "EstimatorRunner",
    "amorsim.simulation.events": "Event",
    "amorsim.render.plan_picture": "draw_plan",
    "amorsim.reports.report": "report",
    "amorsim.runs.drawing": "draw",
    "amorsim.runs.reproduce": "reproduce",
    "amorsim.runs.run": "run",
    "amorsim.runs.session": "RunSession RunSummary record",
    "amorsim.simulation.schedule": "PHASES",
    "amorsim.simulation.simulation": "Simulation",
    "amorsim.simulation.noise_stages": "KeptStages Stage keep_stages",
    "amorsim.sweeps.sweep": "sweep",
    "amorsim.sweeps.table": "Study read_study",
    "amorsim.ui.notebook.widget": "widget",
    "amorsim.ui.run_page.document": "run_page",
    "amorsim.ui.view": "view",
}
_PACKAGES = (
    *("algorithms", "analysis", "controllers", "drives", "estimators", "metrics", "motions", "noise", "planners"),
    *("sensors", "tasks", "testing", "worlds"),
)
show_by(lambda value: importlib.import_module("amorsim.reports.notebook").bundle(value))

_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}

__all__ = [
    "PHASES",
    "Aim",
    "AmorsimError",
    "AnalysisError",
    "Beliefs",
    "Clock",
    "ComponentError",
    "ContactError",
    "Context",
    "Controller",
    "ControllerError",
    "Deviation",
    "Distribution",
    "Document",
    "DocumentError",
    "Draws",
    "Drive",
    "Drop",
    "Emission",
    "Episode",
    "Estimate",
    "Estimator",
    "EstimatorRunner",
    "Event",
    "Fault",
    "Floor",
    "FloorPoints",
    "Frame",
    "GraphError",
    "InitialBelief",
    "Joint",
    "KeptStages",
    "Kidnapping",
    "Knowledge",
    "Landmark",
    "Light",
    "Lights",
    "Map",
    "MapError",
    "MapLoader",
    "Marking",
    "Measurement",
    "Metric",
    "Motion",
    "Mount",
    "MountedSensor",
    "Noise",
    "NoiseElement",
    "NoiseStep",
    "Observable",
    "Obstacle",
    "ObstacleFrame",
    "Origin",
    "Outline",
    "ParameterError",
    "Part",
    "Partial",
    "Plan",
    "PlanError",
    "Planner",
    "PluginError",
    "Pose",
    "RandomStart",
    "Recorder",
    "Recording",
    "Registry",
    "Robot",
    "RobotModel",
    "RunError",
    "RunInfo",
    "RunSession",
    "RunSummary",
    "Scenario",
    "ScenarioDocument",
    "ScenarioError",
    "ScenarioLoader",
    "Sensor",
    "SensorModel",
    "Shape",
    "ShapeError",
    "Sightings",
    "Simulation",
    "SnapshotError",
    "Stage",
    "State",
    "StepOutcome",
    "Study",
    "StudyError",
    "Task",
    "TrueState",
    "Twist",
    "View",
    "WheelSpeeds",
    "WorldGenerator",
    "Zone",
    "algorithms",
    "analysis",
    "check_code",
    "compose",
    "controllers",
    "draw",
    "draw_plan",
    "drives",
    "estimated_map",
    "estimators",
    "exponential",
    "hookimpl",
    "keep_stages",
    "load",
    "load_device",
    "load_map",
    "load_robot",
    "logarithm",
    "metrics",
    "motions",
    "noise",
    "open_document",
    "parameter",
    "planners",
    "read_study",
    "record",
    "relative",
    "report",
    "reproduce",
    "run",
    "run_page",
    "save_device",
    "save_map",
    "save_robot",
    "sensors",
    "stack",
    "sweep",
    "tasks",
    "testing",
    "view",
    "widget",
    "worlds",
    "wrap_angle",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(_HOME[name]), name)
    elif name in _PACKAGES:
        value = importlib.import_module(f"amorsim.{name}")
    elif name == "__version__":
        value = importlib.import_module("amorsim.core.version").version()
    else:
        raise AttributeError(f"module 'amorsim' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

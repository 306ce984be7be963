"""Environments for learners: scenarios and tasks as Gymnasium has them. It needs the extra ``learn``.

Importing this package registers the tasks with Gymnasium: ``gymnasium.make_vec("amorsim/PointGoal-v0", num_envs=64)``.
"""

from __future__ import annotations

import importlib.util

from amorsim.core.errors import AmorsimError

if importlib.util.find_spec("gymnasium") is None:
    raise AmorsimError('environments for learners need the extra "learn": python -m pip install "amorsim[learn]"')

from amorsim.learning.evaluation import Evaluation, evaluate
from amorsim.learning.many_worlds import SimulationParallelVectorEnv
from amorsim.learning.registration import (
    TASKS,
    load_environment,
    make,
    make_parallel,
    make_parallel_vec,
    make_vec,
    register_all,
)
from amorsim.learning.single import SimulationEnv
from amorsim.learning.vector import SimulationVectorEnv

__all__ = [
    "TASKS",
    "Evaluation",
    "SimulationEnv",
    "SimulationParallelVectorEnv",
    "SimulationVectorEnv",
    "evaluate",
    "load_environment",
    "make",
    "make_parallel",
    "make_parallel_vec",
    "make_vec",
]

register_all()

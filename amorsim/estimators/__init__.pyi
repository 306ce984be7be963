from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.estimators.ekf import Ekf
from amorsim.estimators.graph_slam import GraphSlam
from amorsim.estimators.grid_mapping import GridMapping
from amorsim.estimators.grid_slam import GridSlam
from amorsim.estimators.monte_carlo import MonteCarlo
from amorsim.estimators.scan_matching import ScanMatching
from amorsim.estimators.ukf import Ukf

__all__ = ["DeadReckoning", "Ekf", "GraphSlam", "GridMapping", "GridSlam", "MonteCarlo", "ScanMatching", "Ukf"]

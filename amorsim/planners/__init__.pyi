from amorsim.planners.a_star import AStar
from amorsim.planners.curve_planner import Dubins, ReedsShepp
from amorsim.planners.d_star_lite import DStarLite
from amorsim.planners.dijkstra import Dijkstra
from amorsim.planners.hybrid_a_star import HybridAStar
from amorsim.planners.jump_point import JumpPoint
from amorsim.planners.potential_field import PotentialField
from amorsim.planners.prm import Prm
from amorsim.planners.theta_star import ThetaStar
from amorsim.planners.trees import Rrt, RrtConnect, RrtStar
from amorsim.planners.voronoi import Voronoi
from amorsim.planners.wavefront import Wavefront

__all__ = [
    "AStar",
    "DStarLite",
    "Dijkstra",
    "Dubins",
    "HybridAStar",
    "JumpPoint",
    "PotentialField",
    "Prm",
    "ReedsShepp",
    "Rrt",
    "RrtConnect",
    "RrtStar",
    "ThetaStar",
    "Voronoi",
    "Wavefront",
]

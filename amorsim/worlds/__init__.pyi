from amorsim.worlds.barn_fields import Barn
from amorsim.worlds.caves import Cave
from amorsim.worlds.crossings import Crossing
from amorsim.worlds.forests import Forest
from amorsim.worlds.functions import barn, cave, crossing, forest, maze, office, warehouse
from amorsim.worlds.mazes import Maze
from amorsim.worlds.offices import Office
from amorsim.worlds.warehouses import Warehouse

__all__ = [
    "Barn",
    "Cave",
    "Crossing",
    "Forest",
    "Maze",
    "Office",
    "Warehouse",
    "barn",
    "cave",
    "crossing",
    "forest",
    "maze",
    "office",
    "warehouse",
]

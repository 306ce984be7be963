from amorsim.drives.ackermann import Ackermann
from amorsim.drives.differential import Differential
from amorsim.drives.mecanum import Mecanum
from amorsim.drives.motors import Motors
from amorsim.drives.synchro import Synchro
from amorsim.drives.tractor import Tractor
from amorsim.drives.tricycle import Tricycle

__all__ = ["Ackermann", "Differential", "Mecanum", "Motors", "Synchro", "Tractor", "Tricycle"]

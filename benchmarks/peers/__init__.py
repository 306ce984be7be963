"""The peers: each in a file of its own, behind `benchmarks.peers.base.Peer`."""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["PEERS", "installed"]

PEERS = {
    "irsim": "benchmarks.peers.irsim:IrSim",
    "navground": "benchmarks.peers.navground:Navground",
    "vmas": "benchmarks.peers.vmas:Vmas",
}
"""Where each peer that moves robots is found, by its short name; raycast2D only casts rays."""


def installed(names: tuple[str, ...] = tuple(PEERS)) -> tuple[list[Any], list[str]]:
    """The classes of the peers that are installed, and a line about each that is not."""
    there, missing = [], []
    for name in names:
        module, _, cls = PEERS[name].partition(":")
        peer = getattr(importlib.import_module(module), cls)
        try:
            peer.prepare()
            there.append(peer)
        except ImportError as error:
            missing.append(f"{peer.name}: not installed ({error})")
    return there, missing

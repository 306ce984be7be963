"""Files with some of their bytes wrong."""

from __future__ import annotations

from random import Random

__all__ = ["damaged"]


def damaged(data: bytes, rng: Random, most: int = 6) -> bytes:
    """Bytes with some of them changed, left out, put in, doubled or cut off."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, most)):
        at = rng.randrange(len(changed) + 1)
        what = rng.random()
        if what < 0.35 and at < len(changed):
            changed[at] = rng.randrange(256)
        elif what < 0.55:
            del changed[at : at + rng.choice((1, 1, 2, 10))]
        elif what < 0.75:
            changed[at:at] = rng.choice(
                (b"9", b"e9", b"-", b".", b"\0", b"\n", b"[", b'"', b"0" * 20, b"\xff", b"nan ")
            )
        elif what < 0.9:
            changed[at:at] = changed[at : at + rng.randint(1, 60)]
        elif what < 0.93:
            del changed[at:]
    return bytes(changed)

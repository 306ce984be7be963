"""Videos: frames as an MP4 that every player and presentation shows, by ffmpeg."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable
from pathlib import Path

from PIL import Image

from amorsim.core.errors import RunError
from amorsim.core.files.atomic_files import replacing

__all__ = ["check_video", "write_video"]

_QUALITY = 7  # of 10
_PLAIN = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart"]  # no date or versions in the file


def check_video() -> None:
    """Raise `RunError` if videos cannot be made here."""
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise RunError(
            'a video needs imageio-ffmpeg: python -m pip install "amorsim[video]"; a GIF (--gif) needs nothing more'
        )


def write_video(path: Path, frames: Iterable[Image.Image], rate: float) -> None:
    """Write frames of one size as an MP4 (H.264), `rate` of them a second.

    One frame is in memory at a time. A side with an odd number of pixels gets one white pixel more, which H.264 needs.

    Raises
    ------
    RunError
        If ffmpeg is missing or fails, or the file cannot be written.
    """
    check_video()
    import imageio_ffmpeg

    with replacing(path) as new:
        writer = None
        try:
            for frame in frames:
                size = frame.width + frame.width % 2, frame.height + frame.height % 2
                if writer is None:
                    writer = imageio_ffmpeg.write_frames(
                        str(new),
                        size,
                        fps=rate,
                        quality=_QUALITY,
                        macro_block_size=2,
                        ffmpeg_log_level="error",
                        output_params=list(_PLAIN),
                    )
                    writer.send(None)  # it begins
                even = Image.new("RGB", size, "white")
                even.paste(frame)
                writer.send(even.tobytes())
        except RuntimeError as error:  # there is no ffmpeg
            raise RunError(f"{path}: cannot be made ({error})") from None
        finally:
            if writer is not None:
                writer.close()

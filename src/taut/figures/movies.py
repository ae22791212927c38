"""Frames into GIF (Pillow) and MP4 (ffmpeg)."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.distance import cdist

from taut.errors import OutputError
from taut.figures.style import Colour

Frame: TypeAlias = NDArray[np.uint8]  # (height, width, 4): red, green, blue, opaque


class Palette:
    """255 colours and the nearest of them to any colour; index 255 is left free: "as in the frame before".

    Parameters
    ----------
    frames : pictures that show what colours to expect.
    exact : colours that must be in the palette as they are.
    """

    def __init__(self, frames: Sequence[Frame], exact: Sequence[Colour]) -> None:
        fixed = list(dict.fromkeys(tuple(round(255 * c) for c in to_rgb(colour)) for colour in exact))
        codes, counts = np.unique(np.concatenate([_codes(frame).ravel() for frame in frames]), return_counts=True)
        # large plain areas must not use up the palette: rare shades count for more than their number
        often = np.repeat(codes, np.ceil(np.sqrt(counts)).astype(np.int64))
        fitted = Image.fromarray(_colours(often)[None]).quantize(255 - len(fixed), method=Image.Quantize.MEDIANCUT)
        rest = np.array(fitted.getpalette(), dtype=np.int64).reshape(-1, 3)
        self.table = np.concatenate([np.array(fixed, dtype=np.int64).reshape(-1, 3), rest])[:255]
        self._nearest = np.full(1 << 24, 255, dtype=np.uint8)

    def image(self, frame: Frame) -> Image.Image:
        """Return the frame in these colours, without dither: what does not move stays the same to the last bit."""
        codes = _codes(frame)
        indices = self._nearest[codes]
        new = np.unique(codes[indices == 255])
        if new.size:
            # Pillow's own search is only near enough: it turns white into a near white
            self._nearest[new] = np.argmin(cdist(_colours(new), self.table, "sqeuclidean"), axis=1)
            indices = self._nearest[codes]
        picture = Image.fromarray(indices)
        picture.putpalette(np.vstack([self.table, np.zeros((256 - len(self.table), 3))]).astype(np.uint8).tobytes())
        return picture


def write_gif(path: Path, frames: Iterator[Frame], count: int, fps: float, hold: float, palette: Palette) -> None:
    """Write `count` frames as an endless GIF whose last frame stays `hold` seconds."""
    # GIF times are hundredths of a second, and browsers slow down anything below two of them
    each = max(2, round(100 / fps)) * 10
    images = (palette.image(frame) for frame in frames)
    first = next(images)
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=images,
        duration=[each] * (count - 1) + [each + round(100 * hold) * 10],
        loop=0,
        disposal=1,
        optimize=True,
        transparency=255,
    )


def write_mp4(path: Path, frames: Iterator[Frame], fps: float, hold: float, encoder: str) -> None:
    """Write the frames as MP4 through the ffmpeg at `encoder`; the last frame stays `hold` seconds."""
    first = next(frames)
    height, width = first.shape[:2]
    source = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-"]
    sink = ["-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
    command = [encoder, "-y", "-nostdin", "-loglevel", "error", *source, *sink, "-f", "mp4", str(path)]
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said)
        assert process.stdin is not None
        try:
            frame = first
            process.stdin.write(frame.tobytes())
            for frame in frames:
                process.stdin.write(frame.tobytes())
            for _ in range(round(hold * fps)):
                process.stdin.write(frame.tobytes())
            process.stdin.close()
        except BrokenPipeError:
            pass  # it has ended by itself: what it said is the error
        except BaseException:
            process.kill()
            raise
        finally:
            process.wait()
        if process.returncode != 0:
            said.seek(0)
            lines = said.read().decode("utf-8", "replace").strip().splitlines() or ["no reason given"]
            raise OutputError(f"ffmpeg failed: {lines[-1]}")


def find_encoder(path: Path) -> str:
    """Return where ffmpeg is.

    Raises
    ------
    OutputError
        It is not on the PATH.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        raise OutputError(f"{path}: an .mp4 needs ffmpeg, which is not on the PATH: install it or write a .gif")
    return found


def _codes(frame: Frame) -> NDArray[np.uint32]:
    """Return each colour as one number, red in the lowest 8 bits, (height, width)."""
    return np.ascontiguousarray(frame).view("<u4")[..., 0] & np.uint32(0xFFFFFF)


def _colours(codes: NDArray[np.uint32]) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of n such numbers."""
    return np.stack([codes & 255, codes >> 8 & 255, codes >> 16], axis=-1).astype(np.uint8)

# SPDX-License-Identifier: Apache-2.0
"""How much two pictures differ: PSNR, SSIM, the largest error and a map of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quadshade.errors import QuadshadeError

SSIM_WINDOW = 7
"""Pixels; the side of the window that structural similarity is usually taken over."""


@dataclass(frozen=True)
class Comparison:
    """
    Difference of two 8-bit RGB pictures.

    Attributes
    ----------
    psnr : float
      Peak signal-to-noise ratio in dB over all pixels and channels; infinite for identical pictures.
    ssim : float or None
      Mean structural similarity; None where the picture is smaller than its window of 7 pixels.
    largest_error : int
      Grey levels, over all channels.
    largest_at : (int, int)
      x and y of the first pixel that has it.
    differing : int
      Pixels in which any channel differs.
    pixels : int
    """

    psnr: float
    ssim: float | None
    largest_error: int
    largest_at: tuple[int, int]
    differing: int
    pixels: int

    @property
    def rms(self) -> float:
        """Root mean square error in grey levels, over all pixels and channels: 255 / 10**(psnr / 20)."""
        return 255.0 / 10.0 ** (self.psnr / 20.0)


def _check_sizes(one: np.ndarray, other: np.ndarray) -> None:
    """Refuse pictures of different sizes."""
    if one.shape != other.shape:
        sizes = " and ".join(f"{picture.shape[1]}x{picture.shape[0]}" for picture in (one, other))
        raise QuadshadeError(f"the pictures are {sizes}", "compare pictures of one size")


def error_map(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """
    Largest difference over the channels, at every pixel.

    Parameters
    ----------
    one, other : (height, width, 3) uint8

    Returns
    -------
    (height, width) int16
      Grey levels.

    Raises
    ------
    QuadshadeError
      Pictures of different sizes.
    """
    _check_sizes(one, other)
    return np.abs(one.astype(np.int16) - other.astype(np.int16)).max(axis=-1)


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    """
    Peak signal-to-noise ratio of 8-bit pictures in dB, infinite where they are identical.

    Parameters
    ----------
    one, other : (height, width, 3) uint8 or float, 0 .. 255

    Returns
    -------
    float
    """
    error = float(np.mean((one.astype(np.float64) - other.astype(np.float64)) ** 2))
    return float(10 * np.log10(255.0**2 / error)) if error > 0 else float("inf")


def largest_and_rms(one: np.ndarray, other: np.ndarray) -> tuple[int, float]:
    """
    Largest and root mean square difference of two pictures in one compiled pass.

    Parameters
    ----------
    one, other : (height, width, 3) uint8

    Returns
    -------
    int, float
      Grey levels.

    Raises
    ------
    QuadshadeError
      Pictures of different sizes.
    """
    from quadshade.image.visible_loops import differences

    _check_sizes(one, other)
    largest, square = differences(np.ascontiguousarray(one).ravel(), np.ascontiguousarray(other).ravel())
    return int(largest), float(np.sqrt(square / one.size))


def compare(one: np.ndarray, other: np.ndarray) -> Comparison:
    """
    All measures of two pictures.

    Parameters
    ----------
    one, other : (height, width, 3) uint8

    Returns
    -------
    Comparison

    Raises
    ------
    QuadshadeError
      Pictures of different sizes.
    """
    from skimage.metrics import structural_similarity

    errors = error_map(one, other)
    similarity = None
    if min(errors.shape) >= SSIM_WINDOW:
        similarity = float(
            structural_similarity(one, other, win_size=SSIM_WINDOW, channel_axis=-1, data_range=255)
        )
    row, column = np.unravel_index(int(errors.argmax()), errors.shape)
    return Comparison(
        psnr(one, other),
        similarity,
        int(errors.max()),
        (int(column), int(row)),
        int(np.count_nonzero(errors)),
        errors.size,
    )


def write_heatmap(path: Path, one: np.ndarray, other: np.ndarray) -> None:
    """
    Draw the error at every pixel, with a legend in grey levels.

    Parameters
    ----------
    path : Path
      PNG file.
    one, other : (height, width, 3) uint8

    Raises
    ------
    QuadshadeError
      Pictures of different sizes.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    errors = error_map(one, other)
    worst = int(errors.max())
    figure = Figure(figsize=(8, 7), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    shown = axes.imshow(errors, cmap="inferno", vmin=0, vmax=max(worst, 1), interpolation="nearest")
    axes.set_title(f"error: largest {worst}, mean {errors.mean():.3f} grey levels")
    axes.set_xlabel("x (pixels)")
    axes.set_ylabel("y (pixels)")
    legend = figure.colorbar(shown, ax=axes, ticks=MaxNLocator(integer=True))
    legend.set_label("largest error of the channels (grey levels of 255)")
    figure.savefig(path, format="png")

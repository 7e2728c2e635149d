"""What is near some cells of a grid: how far it is to the nearest, and which lie beside them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["cells_away", "with_neighbours"]


def cells_away(from_mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """The distance of each cell's middle to that of the nearest cell in `from_mask`, `(rows, cols)` in cells.

    The last bit of OpenCV's distances differs from one process to the next. Their squares are whole numbers: up to a thousand
    cells rounding finds them, so that one map gives one plan, bit by bit.
    """
    away = cv2.distanceTransform((~from_mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    np.multiply(away, away, out=away)
    np.rint(away, out=away)
    np.sqrt(away, out=away)
    return np.asarray(away, dtype=np.float32)


def with_neighbours(mask: NDArray[np.bool_], reach: int = 1) -> NDArray[np.bool_]:
    """The cells in `mask`, and all that are within `reach` rows and columns of one."""
    around = np.ones((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), around).astype(np.bool_))

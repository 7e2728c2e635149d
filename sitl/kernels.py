"""`@kernel`: numba's `@njit`, cached on disk under a digest of every file that holds a kernel.

numba's own cache looks only at the file of the function itself, so a change in a callee of another room
would go unseen and the stale machine code would fly on. Kernels are bit-reproducible: no BLAS in them,
never fastmath. They divide as numpy does: by zero too, and without asking first.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from numba import config, njit, typeof
from numba.core.caching import FunctionCache
from numpy.typing import NDArray

__all__ = [
    "Components",
    "FloatArray",
    "Quaternion",
    "Triple",
    "inlined_kernel",
    "is_compiled",
    "kernel",
    "prepared",
    "sources_digest",
]

FloatArray = NDArray[np.float64]
Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Components = Sequence[float] | FloatArray
"""What kernels take and give: arrays that they fill, tuples that they return, and either to read from."""

Function = TypeVar("Function", bound=Callable)


_HAS_KERNEL = re.compile(rb"^@(inlined_)?kernel\b", re.MULTILINE)


def sources_digest(folder: Path) -> str:
    """A digest of all Python files below `folder` that hold a kernel."""
    texts = (path.read_bytes() for path in sorted(folder.rglob("*.py")))
    return hashlib.sha256(b"".join(text for text in texts if _HAS_KERNEL.search(text))).hexdigest()


_DIGEST = sources_digest(Path(__file__).parent)


class _Cache(FunctionCache):  # type: ignore[misc]  # numba carries no types: here and below
    def _index_key(self, sig: object, codegen: object) -> tuple:
        return (*super()._index_key(sig, codegen), _DIGEST)


def kernel(function: Function) -> Function:
    """`function`, compiled at its first call."""
    return _compiled(function, inlined=False)


def inlined_kernel(function: Function) -> Function:
    """`function`, put into each kernel that calls it: for what is called often, with tuples, which go through memory."""
    return _compiled(function, inlined=True)


def _compiled(function: Function, *, inlined: bool) -> Function:
    # A wrapper would be for C's callers, whom we do not have.
    compiled = njit(no_cfunc_wrapper=True, error_model="numpy", forceinline=inlined)(function)
    compiled._cache = _Cache(function)
    return compiled  # type: ignore[no-any-return]


def prepared(function: Function, *arguments: object) -> Function:
    """The kernel's machine code for arguments of these types, which the caller vouches for.

    The kernel itself looks at its arguments' types at each call: with arrays of records that takes half a microsecond.
    """
    if config.DISABLE_JIT:
        return function
    return function.compile(tuple(map(typeof, arguments)))  # type: ignore[attr-defined, no-any-return]


def is_compiled(function: Callable) -> bool:
    """Whether the kernel's machine code for this processor is in the cache on disk, or never will be."""
    if config.DISABLE_JIT:
        return True
    magic = function.targetctx.codegen().magic_tuple()  # type: ignore[attr-defined]
    index = function._cache._cache_file._load_index()  # type: ignore[attr-defined]
    return any(key[1] == magic and key[-1] == _DIGEST for key in index)

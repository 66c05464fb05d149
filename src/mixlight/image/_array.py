"""The array type of this folder: NumPy for jaxtyping at run time, any dtype for the type checker."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[Any]
else:
    from numpy import ndarray as Array

__all__ = ["Array"]

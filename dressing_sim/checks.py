"""What comes from outside, checked: numbers, arrays, names and objects.

Nothing is cast that was not meant: no text or truth value becomes a number, no complex number loses
its imaginary part, no masked array its mask.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from math import inf
from numbers import Integral, Real
from typing import Any, Final, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError, one_line

T = TypeVar("T")

#: Nothing here is larger in whatever unit; beyond about 1e77 fourth powers would be infinite.
LARGEST: Final = 1e15

#: Nothing that has a name has a longer one [letters].
LONGEST_NAME: Final = 200


def shown(value: object, most: int = 60) -> str:
    """A value as an error shows it: in one line, cut where it is long."""
    try:
        return one_line(repr(value), most)
    except Exception:  # a repr of somebody else's
        return f"a {type(value).__name__}"


def real_array(
    values: object,
    shape: tuple[int | str, ...] | None,
    name: str,
    unit: str = "",
    *,
    fewest: int = 0,
    finite: bool = True,
) -> NDArray[np.float64]:
    """An array of real numbers of a shape; the same object if it is one already.

    Args:
        values: What was got.
        shape: Of the array; a letter is any length, ``"..."`` in front any further axes. None for
            any shape.
        name: What errors call it, with a verb: ``target has``.
        unit: Of the numbers, for errors.
        fewest: Least length of the first axis.
        finite: Whether the numbers must be finite, and at most `LARGEST`.

    Raises:
        InvalidInputError: It has another shape, masked values, or something else than such numbers.
    """
    valid = _valid(shape, unit, fewest)
    array = _real(values, name, valid)
    if not _has_shape(array.shape, shape) or (array.ndim > 0 and len(array) < fewest):
        turned = array.ndim == 2 and shape is not None and array.shape != array.shape[::-1]
        hint = " (is it transposed?)" if turned and _has_shape(array.shape[::-1], shape) else ""
        told = f"{name} {shown(values)} of" if array.ndim == 0 else name
        raise InvalidInputError(f"{told} shape {array.shape}{hint}, {valid}")
    if finite:
        if not np.isfinite(array).all():
            raise InvalidInputError(f"{name} values that are not finite (NaN or infinite), {valid}")
        largest = float(np.abs(array).max(initial=0.0))
        if largest > LARGEST:
            raise InvalidInputError(f"{name} values as large as {largest:.3g}, {valid}")
    return array


def real_vector(values: object, n: int, name: str, unit: str = "") -> NDArray[np.float64]:
    """A new array (n,) of finite real numbers, see `real_array`."""
    # Most are in order, and checked in every control step; what is no number has no length below.
    if type(values) is np.ndarray and values.dtype == np.float64 and values.shape == (n,):
        array: NDArray[np.float64] = values
        with np.errstate(over="ignore"):
            small = array.dot(array) <= LARGEST**2
        if small:
            return np.array(array)
    return np.array(real_array(values, (n,), name, unit))


def _real(values: object, name: str, valid: str) -> NDArray[np.float64]:
    """Values of any shape as real numbers."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise InvalidInputError(f"{name} masked values, {valid}")
    try:
        array = np.asarray(values)
        kind = array.dtype.kind
        if kind == "O" and all(_is_real(value) for value in array.ravel()):
            kind, array = "f", array.astype(np.float64)  # whole numbers of any size, fractions
    except Exception as error:  # whatever an object of somebody else's does
        raise InvalidInputError(f"{name} {shown(values)}, {valid}") from error
    if kind == "c":
        raise InvalidInputError(f"{name} complex numbers, {valid}")
    if kind not in "iuf":
        raise InvalidInputError(f"{name} {shown(values)} of shape {array.shape}, {valid}")
    return np.asarray(array, dtype=np.float64)


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _has_shape(got: tuple[int, ...], shape: tuple[int | str, ...] | None) -> bool:
    if shape is None:
        return True
    if shape[:1] == ("...",):
        shape = shape[1:]
        got = got[max(len(got) - len(shape), 0) :]
    return len(got) == len(shape) and all(
        isinstance(wanted, str) or wanted == n for wanted, n in zip(shape, got, strict=True)
    )


def _valid(shape: tuple[int | str, ...] | None, unit: str, fewest: int) -> str:
    if shape is None:
        told = "an array"
    else:
        told = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
        told += f" with {shape[0]} of {fewest} or more" if fewest else ""
    return f"valid is {told} of finite real numbers{f' [{unit}]' if unit else ''}"


def real_number(
    value: object, name: str, low: float = -inf, high: float = inf, *, above: bool = False
) -> float:
    """A finite number within bounds; no truth value, text or array is one.

    Args:
        value: What was got.
        name: What errors call it.
        low: The least that is valid.
        high: The most.
        above: Whether it must be above `low`.

    Raises:
        InvalidInputError: It is none.
    """
    if _is_real(value):
        try:
            number = float(value)  # type: ignore[arg-type]
        except OverflowError:
            number = inf
        if abs(number) < inf and low <= number <= high and not (above and number == low):
            return number
    raise InvalidInputError(f"{name} is {shown(value)}, valid is {_range(low, high, above)}")


def _range(low: float, high: float, above: bool) -> str:
    if low == -inf and high == inf:
        return "a finite number"
    if high == inf:
        return f"a finite number {'> ' if above else '>= '}{low:g}"
    return f"a number {'above' if above else 'from'} {low:g} {'up ' if above else ''}to {high:g}"


def whole_number(value: object, name: str, low: int = 0, high: int | None = None) -> int:
    """A whole number within bounds; no truth value is one.

    Raises:
        InvalidInputError: It is none.
    """
    if isinstance(value, Integral) and not isinstance(value, bool):
        number = int(value)
        if low <= number and (high is None or number <= high):
            return number
    bounds = f"{low} or more" if high is None else f"{low} to {high}"
    raise InvalidInputError(f"{name} is {shown(value)}, valid is a whole number, {bounds}")


def one_of(value: object, name: str, valid: Collection[str]) -> None:
    """Raise InvalidInputError unless a value is one of some texts."""
    if not (isinstance(value, str) and value in valid):
        raise InvalidInputError(f"{name} must be one of {', '.join(valid)}, not {shown(value)}")


def truth_value(value: object, name: str) -> None:
    """Raise InvalidInputError unless a value is true or false."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidInputError(f"{name} is {shown(value)}, valid is True or False")


def of_kind(value: object, kind: type[T] | tuple[type[Any], ...], name: str, valid: str) -> T:
    """A value, once it is of a class.

    Raises:
        InvalidInputError: It is not.
    """
    if not isinstance(value, kind):
        raise InvalidInputError(f"{name} is {shown(value)}, valid is {valid}")
    return cast(T, value)


def function_or_none(value: object, name: str) -> None:
    """Raise InvalidInputError unless a value can be called, or is None."""
    if value is not None and (isinstance(value, type) or not callable(value)):
        raise InvalidInputError(f"{name} is {shown(value)}, valid is a function or None")


def listed(values: Iterable[T], name: str, valid: str) -> tuple[T, ...]:
    """The items of anything that has some, but no text.

    Raises:
        InvalidInputError: It has none.
    """
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise InvalidInputError(f"{name} is {shown(values)}, valid is {valid}")
    try:
        return tuple(values)
    except Exception as error:  # whatever an object of somebody else's does
        raise InvalidInputError(f"{name} is {shown(values)}, valid is {valid}") from error


def clean_name(value: object, name: str) -> str:
    """A name that can be printed: some letters, at most `LONGEST_NAME`, no control characters.

    Raises:
        InvalidInputError: It is none.
    """
    short = isinstance(value, str) and 0 < len(value) <= LONGEST_NAME
    if isinstance(value, str) and short and value.strip() and value.isprintable():
        return value
    length = f" ({len(value)} letters)" if isinstance(value, str) and len(value) > 60 else ""
    raise InvalidInputError(
        f"{name} is {shown(value)}{length}, valid is a name that is text of 1 to {LONGEST_NAME} "
        "printable letters"
    )

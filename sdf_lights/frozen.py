# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frozen dataclasses that cost no time at a start.

``dataclasses.dataclass(frozen=True)`` writes and compiles six functions for each class. That takes 0.3 ms, and there
are 150 such classes. Classes under ``frozen`` share these functions. ``dataclasses.fields`` and ``replace`` know them.
"""

from __future__ import annotations

import dataclasses
import reprlib
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform

_Class = TypeVar("_Class", bound=type)


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def frozen(cls: _Class) -> _Class:
    """Decorator: as ``dataclasses.dataclass(frozen=True)``. A class keeps its own ``__init__``, or that of a base.

    Fields may have defaults, factories and metadata, and no other options.
    """
    cls.__doc__ = cls.__doc__ or cls.__name__  # else dataclasses write one, which takes as long as the rest
    dataclasses.dataclass(init=False, repr=False, eq=False)(cls)
    names = tuple(field.name for field in dataclasses.fields(cls))
    cls._frozen_values = _values_of(names)  # type: ignore[attr-defined]
    for name, method in _METHODS.items():
        if getattr(cls, name) is getattr(object, name):
            setattr(cls, name, method)
    return cls


def _values_of(names: tuple[str, ...]) -> staticmethod:
    """A function: the values of an object in a tuple."""
    if len(names) > 1:
        return staticmethod(attrgetter(*names))
    return staticmethod(lambda item: tuple(getattr(item, name) for name in names))


def _init(self, *values, **named) -> None:
    fields = self.__dataclass_fields__
    if len(values) > len(fields):
        raise TypeError(f"{type(self).__name__} takes {len(fields)} values, not {len(values)}")
    given = dict(zip(fields, values))
    if given and not given.keys().isdisjoint(named):
        raise TypeError(f"{type(self).__name__} got two values for {', '.join(given.keys() & named.keys())}")
    given |= named
    own: dict[str, Any] = self.__dict__
    for name, field in fields.items():
        if name in given:
            own[name] = given[name]
        elif field.default is not dataclasses.MISSING:
            own[name] = field.default
        elif field.default_factory is not dataclasses.MISSING:
            own[name] = field.default_factory()
        else:
            raise TypeError(f"{type(self).__name__} needs a value for {name}")
    if not given.keys() <= fields.keys():
        raise TypeError(f"{type(self).__name__} has no field {', '.join(given.keys() - fields.keys())}")
    after = getattr(self, "__post_init__", None)
    if after is not None:
        after()


@reprlib.recursive_repr()
def _repr(self) -> str:
    values = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.__dataclass_fields__)
    return f"{type(self).__qualname__}({values})"


def _eq(self, other) -> bool:
    if other.__class__ is not self.__class__:
        return NotImplemented
    return self._frozen_values(self) == self._frozen_values(other)


def _hash(self) -> int:
    return hash(self._frozen_values(self))


def _setattr(self, name: str, value) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot assign to {name}: {type(self).__name__} is frozen")


def _delattr(self, name: str) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot delete {name}: {type(self).__name__} is frozen")


_METHODS = {
    "__init__": _init,
    "__repr__": _repr,
    "__eq__": _eq,
    "__hash__": _hash,
    "__setattr__": _setattr,
    "__delattr__": _delattr,
}

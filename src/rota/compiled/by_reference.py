# mypy: disallow-untyped-calls=False, disallow-untyped-decorators=False
# mypy: disable-error-code="misc, attr-defined, arg-type, var-annotated, override"
"""Named tuples of many arrays that compiled functions hand on by their address.

numba passes a named tuple as its parts: some 300 numbers for a state of forty arrays, in each function and at each
call. Most of the time that compiling takes goes there. A class under ``@by_reference`` is passed as one address
instead. Compiled code reads its fields, and calls with it, as before; it cannot make one.
"""

from __future__ import annotations

from typing import Any, TypeVar

from numba import types
from numba.core import cgutils
from numba.core.datamodel import register_default
from numba.core.datamodel.models import PointerModel
from numba.core.imputils import impl_ret_borrowed, lower_getattr_generic
from numba.core.pythonapi import NativeValue, unbox
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.core.typing.typeof import typeof, typeof_impl

Class = TypeVar("Class", bound=type)


class Reference(types.Type):
    """The address of a named tuple; ``dtype`` is the tuple's type."""

    def __init__(self, dtype: types.BaseNamedTuple) -> None:
        self.dtype = dtype
        super().__init__(name=f"Reference({dtype})")


register_default(Reference)(PointerModel)


def by_reference(named_tuple: Class) -> Class:
    """Let compiled functions take the class's instances by address; for the rest it stays as it is."""

    @typeof_impl.register(named_tuple)
    def _typeof(value: Any, _: Any) -> Reference:
        return Reference(types.BaseTuple.from_types([typeof(part) for part in value], named_tuple))

    return named_tuple


@infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, reference: Reference, name: str) -> Any:
        fields = reference.dtype.fields
        return reference.dtype[fields.index(name)] if name in fields else None


@lower_getattr_generic(Reference)
def _field(context: Any, builder: Any, reference: Reference, address: Any, name: str) -> Any:
    k = reference.dtype.fields.index(name)
    field = cgutils.gep_inbounds(builder, address, 0, k)
    value = context.data_model_manager[reference.dtype[k]].load_from_data_pointer(builder, field)
    return impl_ret_borrowed(context, builder, reference.dtype[k], value)


@unbox(Reference)
def _unbox(reference: Reference, value: Any, c: Any) -> NativeValue:
    """The parts, laid out where the caller's frame keeps them until it returns."""
    address = cgutils.alloca_once(c.builder, c.context.get_data_type(reference.dtype))
    failed = cgutils.alloca_once_value(c.builder, cgutils.false_bit)
    parts = []
    for k, kind in enumerate(reference.dtype):
        part = c.unbox(kind, c.pyapi.tuple_getitem(value, k))
        model = c.context.data_model_manager[kind]
        c.builder.store(model.as_data(c.builder, part.value), cgutils.gep_inbounds(c.builder, address, 0, k))
        with c.builder.if_then(part.is_error):
            c.builder.store(cgutils.true_bit, failed)
        parts.append((kind, part))

    def release() -> None:
        for kind, part in parts:
            if c.context.enable_nrt:
                c.context.nrt.decref(c.builder, kind, part.value)
            if part.cleanup is not None:
                part.cleanup()

    return NativeValue(address, is_error=c.builder.load(failed), cleanup=release)

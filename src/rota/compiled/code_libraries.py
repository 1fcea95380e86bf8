# mypy: disallow-untyped-calls=False
# mypy: disable-error-code="misc, attr-defined, no-any-return, assignment, method-assign"
"""Code that becomes machine code, and code that its callers take in and that becomes machine code within them alone.

numba optimises and emits whatever it compiles, each of its own small functions for arrays too, and then does so again
within each caller. Here that is done once, where code is called by the interpreter or by name.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba import types
from numba.core import compiler, transforms
from numba.core.base import BaseContext
from numba.core.codegen import JITCodeLibrary
from numba.core.dispatcher import _FunctionCompiler
from numba.core.postproc import PostProcessor
from numba.core.runtime import rtsys
from numba.core.targetconfig import ConfigStack
from numba.core.types.functions import BaseFunction

OF_ENTRIES = ("no_cpython_wrapper", "no_cfunc_wrapper", "release_gil")  # flags of who calls, not of what is called
# of the garbage collector: what is compiled stays, and looking through it all again and again took a sixth of the time
YOUNG, MIDDLE, OLD = 100_000, 100, 1000
REMEMBERED = (types.Boolean, types.Integer, types.Float, types.Array, types.UniTuple)
# signatures of operators and functions of such, with the keys of their code: by them, their types and the flags
_CALLS: dict[Any, Any] = {}
_call_type: Any = BaseFunction.get_call_type
_SIZES: dict[str, int] = {}  # bytes of LLVM's types
_size: Any = BaseContext.get_abi_sizeof
_post_process: Any = PostProcessor.run


class _WithoutEnvironments:
    """The code generator of code that no interpreter calls: its constants of Python are given to what takes it in."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, env_name: str, env: Any) -> None:
        """Nothing: there is no such place yet."""


class MachineCode(JITCodeLibrary):
    """Code that becomes machine code, and is optimised once, as a whole."""

    def _optimize_functions(self, module: Any) -> None:
        """Nothing: numba would optimise each function before, and then all of them again with what they take in."""
        module.data_layout = self._codegen._data_layout


class TakenIn(JITCodeLibrary):
    """Code that callers take in, kept as it was lowered; the interpreter cannot call it."""

    @property
    def codegen(self) -> Any:
        """The code generator."""
        return _WithoutEnvironments(self._codegen)

    def finalize(self) -> None:
        """Take in what the code calls, but for numba's own runtime, which whoever takes in this has already."""
        self._linking_libraries = [library for library in self._linking_libraries if library is not rtsys.library]
        super().finalize()

    def _optimize_final_module(self) -> None:
        """Nothing: callers optimise what they take in."""

    def _finalize_final_module(self) -> None:
        """As the class above, without the machine code."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def serialize_using_object_code(self) -> Any:
        """The code for callers; there is no other."""
        return self.name, "bitcode", self._get_module_for_linking().as_bitcode()


class KernelFlags(compiler.Flags):
    """Flags that are equal where kernels can take in the same functions of numba's.

    numba asks this at each call in each kernel, and would compare all flags one by one.
    """

    __slots__ = ("_key",)

    def __hash__(self) -> int:
        return hash(self._content())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, KernelFlags) and self._content() == other._content()

    def _content(self) -> frozenset[tuple[str, str]]:
        """What they say of the code that is taken in; nobody changes flags once they are asked for this."""
        if not hasattr(self, "_key"):
            told = ((name, value) for name, value in self._values.items() if name not in OF_ENTRIES)
            self._key = frozenset((name, str(value)) for name, value in told if value != self.options[name].default)
        return self._key


def _flags_of_kernels(_: _FunctionCompiler, flags: compiler.Flags) -> compiler.Flags:
    """How numba compiles its own functions for kernels: without what lets the interpreter or C call them."""
    flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    return KernelFlags(flags)


def _remembered_call_type(self: Any, context: Any, args: tuple[types.Type, ...], keywords: Any) -> Any:
    """The signature of a call, looked up where all arguments are numbers or arrays and not all stand in the code.

    numba would try some ten ways to add for arrays, dates and strings at each sum in each kernel.
    """
    plain = tuple(map(types.unliteral, args))
    is_known = not keywords and all(isinstance(kind, REMEMBERED) for kind in plain)
    if not is_known or all(isinstance(kind, types.Literal) for kind in args):
        return _call_type(self, context, args, keywords)
    key = self, plain, ConfigStack.top_or_none()
    if key in _CALLS:
        signature, self._impl_keys[signature.args] = _CALLS[key]
        return signature
    signature = _call_type(self, context, args, keywords)
    if not any(isinstance(kind, types.Literal) for kind in signature.args):  # or it would hold for that number alone
        _CALLS[key] = signature, self._impl_keys[signature.args]
    return signature


def _remembered_size(self: Any, kind: Any) -> int:
    """How many bytes a type of LLVM's takes, which numba asks LLVM anew for each variable."""
    name = str(kind)
    if name not in _SIZES:
        _SIZES[name] = _size(self, kind)
    return _SIZES[name]


def _post_process_once(self: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """Work out how long variables live where the code is lowered: numba would after each pass, for nobody."""
    if emit_dels or self.func_ir.is_generator:
        _post_process(self, emit_dels, extend_lifetimes)
    else:
        self.func_ir.blocks = transforms.canonicalize_cfg(self.func_ir.blocks)
        self.func_ir.generator_info = None


# what is otherwise while kernels compile
REPLACED = (
    (_FunctionCompiler, "_customize_flags", _flags_of_kernels),
    (BaseFunction, "get_call_type", _remembered_call_type),
    (BaseContext, "get_abi_sizeof", _remembered_size),
    (PostProcessor, "run", _post_process_once),
)


@contextmanager
def take_in(context: Any) -> Iterator[None]:
    """Whatever numba compiles meanwhile is taken in by kernels; under numba's lock, which keeps other threads out."""
    before, thresholds = [getattr(owner, name) for owner, name, _ in REPLACED], gc.get_threshold()
    for owner, name, ours in REPLACED:
        setattr(owner, name, ours)
    gc.set_threshold(YOUNG, MIDDLE, OLD)
    try:
        with _libraries(context.codegen(), TakenIn):
            yield
    finally:
        if thresholds[0] != YOUNG and not gc.get_freeze_count():  # the outermost
            gc.freeze()
            gc.unfreeze()  # all that is young counts as old: the collector need not look through it at once
        gc.set_threshold(*thresholds)
        for (owner, name, _), theirs in zip(REPLACED, before, strict=True):
            setattr(owner, name, theirs)


@contextmanager
def _libraries(codegen: Any, made: type[JITCodeLibrary]) -> Iterator[None]:
    """Let numba make libraries of this class."""
    before = codegen._library_class
    codegen._library_class = made
    try:
        yield
    finally:
        codegen._library_class = before


def new_library(context: Any, name: str, *, is_taken_in: bool) -> Any:
    """An empty library, of machine code or of code that callers take in."""
    library = (TakenIn if is_taken_in else MachineCode)(context.codegen(), name)
    library.enable_object_caching()
    return library


def give_environments(result: Any) -> None:
    """Let machine code find the constants of Python of all that it has taken in."""
    for environment in result._find_referenced_environments():
        result.library.codegen.set_env(environment.env_name, environment)


def rebuild(context: Any, parts: Any) -> Any:
    """The result of compiling of which these are the parts, as numba's ``CompileResult._reduce`` gives them."""
    (_, kind, _), *_ = parts
    with _libraries(context.codegen(), TakenIn if kind == "bitcode" else JITCodeLibrary):
        return compiler.CompileResult._rebuild(context, *parts)

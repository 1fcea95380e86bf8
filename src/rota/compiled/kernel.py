# mypy: disallow-untyped-calls=False, disallow-untyped-decorators=False
# mypy: disable-error-code="misc, attr-defined, arg-type, assignment, override, import-untyped, no-any-return"
"""The decorator of kernels: numba's ``njit`` with less to compile, and with a cache that processes share.

What numba does, and what is otherwise here:

- Each function gets an entry for calls from Python, which unpacks all arguments. Here a kernel that kernels call has
  none; it gets one when Python calls it.
- Each function is compiled again within each of its callers. Here a ``noinline`` kernel is compiled once, and its
  callers, which may be in the cache, find it by its name. Such names tell the contents (``_key``).
- What callers take in becomes machine code within them alone (``code_libraries``).
- numba looks in each function for what kernels do not have, as list comprehensions. Here it does not (``LEFT_OUT``).
- Options of the outermost caller pass to what it calls. Here each kernel has its own, so that the same call always
  compiles the same code.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, overload
from uuid import uuid4

import llvmlite
import numba
from numba import config, types
from numba.core import compiler, event as events, sigutils, untyped_passes as untyped
from numba.core.bytecode import FunctionIdentity
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.dispatcher import _FunctionCompiler
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.typed_passes import NopythonRewrites
from numba.np import linalg

from rota.compiled.by_reference import Reference
from rota.compiled.code_cache import discard_code, hold, read_code, write_code
from rota.compiled.code_libraries import KernelFlags, give_environments, new_library, rebuild, take_in
from rota.compiled.source_stamp import code_prefix, source_stamp

Arguments = tuple[types.Type, ...]
# nogil: whoever waits for a thread that runs a kernel goes on meanwhile, and hears signals
OWN_OPTIONS: dict[str, Any] = {
    "nopython": True, "nogil": True, "boundscheck": None, "_nrt": True, "error_model": "python",
}  # fmt: skip
ALLOCATION_FREE: dict[str, Any] = {"error_model": "numpy", "_nrt": False}
SETTINGS = (
    "BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT", "EXTEND_VARIABLE_LIFETIMES",
    "FULL_TRACEBACKS", "USING_SVML", "LLVM_REFPRUNE_PASS", "LLVM_REFPRUNE_FLAGS",
)  # fmt: skip
# what numba looks for in all code, and kernels do not have: functions within, ``with``, ``literally``, and whole arrays
# in expressions, which would become one loop
LEFT_OUT = (
    untyped.WithLifting, untyped.InlineClosureLikes, untyped.MakeFunctionToJitFunction, untyped.FindLiterallyCalls,
    untyped.LiteralUnroll, untyped.LiteralPropagationSubPipelinePass, NopythonRewrites,
)  # fmt: skip
DIGEST_DIGITS = 40
_BY_SYMBOL: dict[str, tuple[str, str, Arguments]] = {}  # the noinline kernels of this process


@overload
def kernel(function: Callable[..., Any]) -> Any: ...
@overload
def kernel(*, noinline: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]: ...
def kernel(function: Callable[..., Any] | None = None, *, noinline: bool = False, **options: Any) -> Any:
    """Compile the function when it is called, for the types it is called with; options as those of ``numba.njit``.

    noinline: callers call it instead of taking it in. It pays for large functions.
    """
    if function is None:
        return lambda function: _kernel(function, noinline, options)
    return _kernel(function, noinline, options)


def allocation_free(function: Callable[..., Any]) -> Any:
    """A compiled function that allocates no array, and whose divisions by 0 give what numpy's do.

    Such functions pass tuples of many arrays to each other; to count references to every array on every call (numba's
    runtime, "nrt") would take more time than all the rest.
    """
    return kernel(**ALLOCATION_FREE)(function)


def noinline(function: Callable[..., Any]) -> Any:
    """The same for a large function, which its callers call instead of taking it in: they compile in less time."""
    return kernel(**ALLOCATION_FREE, noinline=True)(function)


def always_inline(function: Callable[..., Any]) -> Any:
    """The same for a function that becomes part of its callers."""
    return kernel(**ALLOCATION_FREE, inline="always")(function)


def _kernel(function: Callable[..., Any], noinline: bool, options: dict[str, Any]) -> Any:
    if config.DISABLE_JIT:
        return function
    return Kernel(function, targetoptions={**OWN_OPTIONS, **options}, noinline=noinline)


class _Pipeline(compiler.Compiler):
    """numba's own, but for what kernels do not need and the name of what it compiles, the same in all processes."""

    def __init__(self, number: int, is_taken_in: bool, *rest: Any) -> None:
        super().__init__(*rest)
        self.number, self.is_taken_in = number, is_taken_in

    def define_pipelines(self) -> list[PassManager]:
        """numba's passes, but for those that are left out."""
        passes = PassManager("kernel")
        passes.passes = [named for named in super().define_pipelines()[0].passes if named[0] not in LEFT_OUT]
        passes.finalize()
        return [passes]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile the function under its qualified name and this number."""
        identity = FunctionIdentity.from_function(func)
        identity.unique_id = self.number
        identity.unique_name = f"{identity.func_qualname}${self.number}"
        self.state.func_id = identity
        self.state.library = new_library(self.state.targetctx, identity.func_qualname, is_taken_in=self.is_taken_in)
        untyped.ExtractByteCode().run_pass(self.state)
        self.state.lifted = ()
        self.state.lifted_from = None
        return self._compile_bytecode()


class _Compiler(_FunctionCompiler):
    """Compiles a kernel with an entry for Python or without."""

    has_entry = False

    def _customize_flags(self, flags: compiler.Flags) -> compiler.Flags:
        flags.no_cpython_wrapper = not self.has_entry
        flags.no_cfunc_wrapper = True
        return KernelFlags(flags)

    def compile_as(self, number: int, has_entry: bool, is_taken_in: bool, args: Arguments, return_type: Any) -> Any:
        """The result of compiling for these types; what has the same number has the same code."""
        self.has_entry, self.pipeline_class = has_entry, partial(_Pipeline, number, is_taken_in)
        with take_in(self.targetdescr.target_context):
            return self.compile(args, return_type)


class Kernel(CPUDispatcher):
    """A function with its compiled forms; ``overloads`` has what kernels call, ``entries`` what Python calls."""

    def __init__(self, function: Callable[..., Any], *, targetoptions: dict[str, Any], noinline: bool) -> None:
        super().__init__(function, targetoptions=targetoptions)
        self._compiler = _Compiler(function, self.targetdescr, targetoptions, {}, compiler.Compiler)
        self.noinline = noinline
        self.file = Path(function.__code__.co_filename)
        self.is_kept = "<locals>" not in function.__qualname__ and self.file.is_file()
        self.entries: dict[Arguments, Any] = {}
        self._python_calls = False

    def __reduce__(self) -> Any:
        return _kernel_named, (self.__module__, self.__qualname__)

    def _compile_for_args(self, *args: Any, **keywords: Any) -> Any:
        # the interpreter comes here when it knows no entry for these types
        with global_compiler_lock:
            self._python_calls = True
            try:
                return super()._compile_for_args(*args, **keywords)
            finally:
                self._python_calls = False

    def compile_entry(self, *arguments: types.Type) -> None:
        """Load or compile what Python calls with arguments of these types, before it does."""
        with global_compiler_lock:
            self._python_calls = True
            self.compile(arguments)

    def compile(self, sig: Any) -> Any:
        """Load or compile the form for these types: the one with an entry if Python calls, else any that can be called.

        Returns numba's entry point, which only the form with an entry lets Python call.
        """
        with global_compiler_lock:
            entry, self._python_calls = self._python_calls, False
            arguments, return_type = sigutils.normalize_signature(sig)
            arguments = tuple(map(types.unliteral, arguments))  # one form for all numbers that stand in calls
            found = (self.entries if entry else self.overloads).get(tuple(arguments))
            return (found or self._form(tuple(arguments), return_type, entry)).entry_point

    def _form(self, arguments: Arguments, return_type: Any, entry: bool) -> Any:
        """A form that is not in memory: from the cache, or else compiled, by one process while others wait for it."""
        kinds = ("entry",) if entry else ("inner",) if self.noinline else ("inner", "entry")
        names = [self._name(arguments, return_type, kind) for kind in kinds]
        found = next(((name, result) for name in names if (result := self._load(name)) is not None), None)
        if found is None:
            number = int(names[0][-DIGEST_DIGITS:][:15], 16)
            with hold(number):
                result = self._load(names[0]) or self._compile_now(names[0], number, entry, arguments, return_type)
            found = names[0], result
        name, result = found
        self._add(arguments, result, has_entry=entry or name != names[0])
        return result

    def _load(self, name: str) -> Any:
        """The form of this name in the cache, and before it all that it looks for by name; None: there is none."""
        data = read_code(name) if self.is_kept else None
        if data is None:
            return None
        _ready_to_load(self.targetctx)
        try:
            needs, parts = pickle.loads(data)
            for module, qualname, arguments in pickle.loads(needs):
                _kernel_named(module, qualname).compile(arguments)
            result = rebuild(self.targetctx, pickle.loads(parts))
        except Exception:  # whatever it is: what does not load is of no use to anybody
            discard_code(name)
            return None
        libraries = () if self.noinline else (result.library,)
        self.targetctx.insert_user_function(result.entry_point, result.fndesc, libraries)
        return result

    def _compile_now(self, name: str, number: int, entry: bool, arguments: Arguments, return_type: Any) -> Any:
        """The form compiled now, and kept if the cache can be written."""
        rtsys.initialize(self.targetctx)
        details = {"dispatcher": self, "args": arguments, "return_type": return_type}
        with self._compiling_counter, events.trigger_event("numba:compile", data=details):
            is_taken_in = not entry and not self.noinline
            result = self._compiler.compile_as(number, entry, is_taken_in, arguments, return_type)
        give_environments(result)
        if self.noinline:
            self.targetctx.remove_user_function(result.entry_point)
            self.targetctx.insert_user_function(result.entry_point, result.fndesc, ())
        module = result.library._final_module
        needs = [_BY_SYMBOL[f.name] for f in module.functions if f.is_declaration and f.name in _BY_SYMBOL]
        if self.is_kept and not result.library.has_dynamic_globals:
            plain = result._replace(type_annotation="")  # its text, with the source line by line, is long
            write_code(name, pickle.dumps((dumps(needs), dumps(plain._reduce()))))
        return result

    def _add(self, arguments: Arguments, result: Any, *, has_entry: bool) -> None:
        if has_entry:
            self.entries[arguments] = result
            self._insert([kind._code for kind in arguments], result.entry_point, result.objectmode)
        elif self.noinline:
            _BY_SYMBOL[result.fndesc.llvm_func_name] = self.__module__, self.__qualname__, arguments
        if not (has_entry and self.noinline):
            self.overloads.setdefault(arguments, result)

    def _name(self, arguments: Arguments, return_type: Any, kind: str) -> str:
        """The name of a form: the same wherever it would have the same code."""
        if not self.is_kept:
            return uuid4().hex + uuid4().hex
        told = (
            kind, self.noinline, sorted(self.targetoptions.items()), _type_name(arguments), str(return_type),
            source_stamp(self.file), numba.__version__, llvmlite.__version__,
            sys.version, self.targetctx.codegen().magic_tuple(), [str(getattr(config, name)) for name in SETTINGS],
        )  # fmt: skip
        digest = hashlib.sha256(repr(told).encode()).hexdigest()
        return code_prefix(self.__module__, self.__qualname__, self.file) + digest[:DIGEST_DIGITS]


def _ready_to_load(context: Any) -> None:
    """Make numba able to load code, which is less than to compile: it loads what that takes once it does.

    numba would load its typing of all that it knows, and scipy's linear algebra to see whether there is any. Together
    that is a third of the time of a short command.
    """
    rtsys.initialize(context)
    if "numba.np.arraymath" not in sys.modules:
        asks_for_blas, linalg.ensure_blas = linalg.ensure_blas, _no_blas
        try:
            import_module("numba.np.arraymath")
        finally:
            linalg.ensure_blas = asks_for_blas


def _no_blas() -> None:
    """What ``arraymath`` asks before it offers ``cov`` and ``corrcoef``, which no kernel calls."""
    raise ImportError


def _kernel_named(module: str, qualname: str) -> Kernel:
    """The kernel of this name."""
    return getattr(import_module(module), qualname)


def _type_name(kind: Any) -> str:
    """A type's name, with what numba leaves out of it: of which class a named tuple is."""
    if isinstance(kind, tuple):
        return ", ".join(map(_type_name, kind))
    if isinstance(kind, Reference):
        return f"Reference({_type_name(kind.dtype)})"
    if isinstance(kind, types.BaseNamedTuple):
        made = kind.instance_class
        return f"{made.__module__}.{made.__qualname__}{made._fields}({_type_name(tuple(kind))})"
    if isinstance(kind, types.BaseTuple):
        return f"({_type_name(tuple(kind))})"
    return str(kind)

"""Compile a kernel of many functions at once, in half of numba's own time.

Numba optimises each function together with all that it calls, so a function at depth d of the calls
is optimised d times. Here functions that only compiled code calls are optimised within their
callers only. Should numba's internals change, it compiles as usual.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from importlib import import_module
from typing import Any

around: Callable[[], AbstractContextManager[None]] = nullcontext
"""The block in which the kernel is compiled.

The compiler runs for many seconds, in which Python handles no signals. A command sets a block in
which they end it; a notebook would lose its session.
"""


def pipelines() -> tuple[Any, Any]:
    """Compilers for functions called from Python, and for the others; None if numba has changed."""
    try:
        return _pipelines()
    except (ImportError, AttributeError):
        return None, None


def _pipelines() -> tuple[Any, Any]:
    _dynfunc: Any = import_module("numba._dynfunc")
    base: Any = import_module("numba.core.codegen").JITCodeLibrary
    compiler: Any = import_module("numba.core.compiler")
    for name in ("finalize", "add_linking_library", "_optimize_functions", "_ensure_finalized"):
        getattr(base, name)

    class Part(base):  # type: ignore[misc]
        """The code of one function, neither optimised nor turned into machine code by itself."""

        def _optimize_functions(self, module: Any) -> None:
            module.data_layout = self._codegen._data_layout

        def finalize(self) -> None:
            self._finalized = True

    class Whole(base):  # type: ignore[misc]
        """The code of a function linked with all its parts, to be optimised together."""

        def finalize(self) -> None:
            found: dict[Any, None] = {}
            for library in self._linking_libraries:
                _collect(library, Part, found)
            # callers first: a function is linked only if what is there already calls it
            self._linking_libraries[:] = reversed(found)
            super().finalize()

    def uncalled(library: Any, description: Any, environment: Any) -> Any:
        name = description.qualname
        doc, module = f"part of compiled code: {name}", description.lookup_module()
        return _dynfunc.make_function(module, name.split(".")[-1], doc, 0, environment, (library,))

    class PartCompiler(compiler.Compiler):  # type: ignore[misc]
        def __init__(
            self, typing: Any, target: Any, library: Any, args: Any, result: Any, flags: Any,
            *others: Any,
        ) -> None:  # fmt: skip
            flags.nrt = False  # no reference counts: a part neither allocates nor keeps arrays
            super().__init__(typing, target, library, args, result, flags, *others)
            self.state.library = Part(self.state.targetctx.codegen(), "part")
            self.state.targetctx.get_executable = uncalled

    class WholeCompiler(compiler.Compiler):  # type: ignore[misc]
        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            self.state.library = Whole(self.state.targetctx.codegen(), "whole")
            self.state.library.enable_object_caching()

        def compile_extra(self, function: Any) -> Any:
            with around():
                return super().compile_extra(function)

    return WholeCompiler, PartCompiler


def _collect(library: Any, part: Any, found: dict[Any, None]) -> None:
    """Add a library to ``found``, after all parts that it calls."""
    if library in found:
        return
    if isinstance(library, part):
        for callee in library._linking_libraries:
            _collect(callee, part, found)
    found[library] = None

"""
How numba compiles inner functions, and how it compiles entries. This module needs numba.

By default, numba links to each function the code of all functions that it calls, optimizes both,
and makes machine code of both. The code of an inner function would be optimized again with each
of its callers, and its own machine code would never run. So inner functions are only translated.
An entry links the code of all functions that it reaches, each once, and is optimized as a whole.
"""

from importlib import import_module
from typing import Any

codegen: Any = import_module('numba.core.codegen')  # these three have no types
compiler: Any = import_module('numba.core.compiler')
dynfunc: Any = import_module('numba._dynfunc')


class Part(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of an inner function alone."""

    def finalize(self) -> None:
        """Leave linking, optimizing and machine code to the entry."""
        self._finalized = True


class Whole(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of an entry and of all functions that it reaches."""

    def finalize(self) -> None:
        """Link the code of all these functions, optimize it, and make machine code of it."""
        reached: dict[Any, None] = dict.fromkeys(self._linking_libraries)  # a set with an order
        waiting = list(reached)
        while waiting:
            library = waiting.pop()
            if isinstance(library, Part):
                new = [each for each in library._linking_libraries if each not in reached]
                reached.update(dict.fromkeys(new))
                waiting += new
        self._linking_libraries: list[Any] = list(reached)
        super().finalize()


def no_executable(library: Any, description: Any, environment: Any) -> Any:
    """Return a function that is never called: numba wants one for each compiled function."""
    module, name = description.lookup_module(), description.qualname
    return dynfunc.make_function(module, name, '', 0, environment, (library,))


# numba compiles a function once for all callers that have the same options. So options in which
# functions differ are set here, where callees no longer inherit them.


class Inner(compiler.Compiler):  # type: ignore[misc]
    """Translates an inner function."""

    inline = False

    def define_pipelines(self) -> Any:
        """Return numba's own steps."""
        state = self.state
        state.flags.forceinline = self.inline
        state.library = Part(state.targetctx.codegen(), state.func_id.func_qualname)
        state.targetctx.get_executable = no_executable  # this context is of one function
        return super().define_pipelines()


class Innermost(Inner):
    """Translates an inner function that is inlined into every caller."""

    inline = True


class Outermost(compiler.Compiler):  # type: ignore[misc]
    """Compiles an entry, which Python and, by its address, other entries call."""

    def define_pipelines(self) -> Any:
        """Return numba's own steps."""
        state = self.state
        state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = False
        state.library = Whole(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()

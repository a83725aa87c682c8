"""
The entries as one module of LLVM, as numba translates them, before anything is optimized.

This is the only file that uses names of numba that are not public.
"""

import gc
from typing import Any

from llvmlite import ir
import llvmlite.binding as llvm
import numba
from numba.core import cgutils, codegen, compiler
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.extending import register_jitable, typeof_impl
from numba.np import arrayobj

from billiard_shot.compiled import Entry, PARTS
from billiard_shot.records import ROWS

# Divisions follow IEEE 754, as in NumPy. Arrays are not counted: their callers keep them alive.
OPTIONS: dict[str, Any] = {
    'error_model': 'numpy',
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
    'no_rewrites': True,
    '_nrt': False,
}
# Pointers have 32 bits in this layout. Only their alignment depends on that. A pointer that is
# aligned to eight bytes is aligned to four, too, so one module serves all targets.
LAYOUT = 'wasm32-unknown-unknown'


class Function(codegen.CodeLibrary):  # type: ignore[misc]
    """What numba takes for the library of a function: it only collects the code."""

    get_function = get_llvm_str = get_asm_str = None

    def add_ir_module(self, ir_module: ir.Module) -> None:
        """Collect code."""
        text = cgutils.normalize_ir_text(str(ir_module))
        self.codegen.modules.append(llvm.parse_assembly(text))

    def add_linking_library(self, library: Any) -> None:
        """All is linked in the end."""

    def finalize(self) -> None:
        """All is optimized in the end."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Nothing is run."""
        return 0


class Code(codegen.Codegen):  # type: ignore[misc]
    """All that numba generates."""

    _library_class = Function

    def __init__(self) -> None:
        self._machine = llvm.Target.from_triple(LAYOUT).create_target_machine()
        self._target_data = self._machine.target_data
        self.modules: list[Any] = []

    def _create_empty_module(self, name: str) -> ir.Module:
        module = ir.Module(cgutils.normalize_ir_text(name))
        module.data_layout = str(self._target_data)
        return module

    def _add_module(self, module: Any) -> None:
        """Nothing is run."""

    def set_env(self, name: str, env: Any) -> None:
        """Nothing is run."""


class InliningCompiler(compiler.Compiler):  # type: ignore[misc]
    """Compiles a function that is inlined into every caller."""

    def define_pipelines(self) -> Any:
        """Set the option here, where callees do not inherit it, and return numba's own steps."""
        self.state.flags.forceinline = True
        return super().define_pipelines()


def capture(entries: list[Entry]) -> bytes:
    """
    Return one module of LLVM with entries, as bitcode.

    For each entry, it has a function of its name that takes the address of a table of arguments,
    as the description of the library states it, and returns what the entry returns, or 0.
    """
    gc.disable()  # collecting garbage in numba's large heap takes a tenth of the time
    llvm.initialize_all_targets()
    type(rtsys).initialize = lambda self, context: None  # numba's runtime is not needed
    type(rtsys).library = None
    context = cpu_target.target_context
    context._internal_codegen = code = Code()
    for function, inlined in PARTS.items():
        how = {'pipeline_class': InliningCompiler} if inlined else {}
        register_jitable(**OPTIONS, **how)(function)
    # Entries call each other as they call other functions.
    typeof_impl.register(Entry)(
        lambda entry, _: cpu_target.typing_context.resolve_value_type(entry.function)
    )
    for entry in entries:
        register_jitable(**OPTIONS)(entry.function)
    for entry in entries:
        kinds = tuple(map(numba.typeof, entry.example(ROWS)))
        translated = numba.njit(**OPTIONS)(entry.function)
        translated.compile(kinds)
        called = translated.overloads[kinds].fndesc
        code.modules.append(_from_table(context, entry.function.__name__, called))
    while len(code.modules) > 1:  # in pairs, because each link reads all of its target
        for target, source in zip(code.modules[::2], code.modules[1::2], strict=False):
            target.link_in(source)
        code.modules = code.modules[::2]
    linked: bytes = code.modules[0].as_bitcode()
    return linked


def _from_table(context: Any, name: str, called: Any) -> Any:
    """Write the function that reads a table of arguments and calls an entry with them."""
    module, word = context.create_module(name), ir.IntType(64)
    function = ir.Function(module, ir.FunctionType(word, [word.as_pointer()]), name)
    builder = ir.IRBuilder(function.append_basic_block())
    place = function.args[0]

    def read() -> Any:
        nonlocal place
        value = builder.load(place, align=8)
        place = builder.gep(place, [ir.IntType(32)(1)])
        return value

    def argument(kind: Any) -> Any:
        if isinstance(kind, numba.types.BaseTuple):
            return context.make_tuple(builder, kind, [argument(each) for each in kind.types])
        value = read()
        if kind == numba.types.boolean:
            return builder.trunc(value, context.get_value_type(kind))
        if not isinstance(kind, numba.types.Array):
            return builder.bitcast(value, context.get_value_type(kind))
        array = context.make_array(kind)(context, builder)
        shape = [read() for _ in range(kind.ndim)]
        strides = [word(context.get_abi_sizeof(context.get_data_type(kind.dtype)))]
        for length in shape[:0:-1]:
            strides.insert(0, builder.mul(strides[0], length))
        arrayobj.populate_array(
            array,
            data=builder.inttoptr(value, array.data.type),
            shape=shape,
            strides=strides,
            itemsize=strides[-1],
            meminfo=None,
        )
        return array._getvalue()

    convention = context.call_conv
    kind = convention.get_function_type(called.restype, called.argtypes)
    _, result = convention.call_function(
        builder,
        ir.Function(module, kind, called.llvm_func_name),
        called.restype,
        called.argtypes,
        [argument(each) for each in called.argtypes],
    )
    builder.ret(word(0) if called.restype == numba.types.none else result)
    return llvm.parse_assembly(str(module))

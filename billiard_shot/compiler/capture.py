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
# Its pointers have 32 bits. Nothing but their alignment depends on that, and what is aligned to
# four bytes may be aligned to eight; so one module serves all targets.
LAYOUT = 'wasm32-unknown-unknown'


class Code(codegen.Codegen):  # type: ignore[misc]
    """Collects what numba generates."""

    def __init__(self) -> None:
        machine = llvm.Target.from_triple(LAYOUT).create_target_machine()
        self._target_data = machine.target_data
        self._library_class = Function
        self.modules: list[Any] = []

    def _create_empty_module(self, name: str) -> ir.Module:
        module = ir.Module(cgutils.normalize_ir_text(name))
        module.data_layout = str(self._target_data)
        return module

    def _add_module(self, module: Any) -> None:
        """Nothing is run."""

    def set_env(self, name: str, env: Any) -> None:
        """Nothing is run."""

    def linked(self) -> Any:
        """Link all modules into one; in pairs, because each link reads all of the target."""
        modules = self.modules
        while len(modules) > 1:
            for target, source in zip(modules[::2], modules[1::2], strict=False):
                target.link_in(source)
            modules = modules[::2]
        return modules[0]


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


class Inlined(compiler.Compiler):  # type: ignore[misc]
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
        how = {'pipeline_class': Inlined} if inlined else {}
        register_jitable(**OPTIONS, **how)(function)
    # Entries call each other as they call other functions.
    typeof_impl.register(Entry)(
        lambda entry, _: cpu_target.typing_context.resolve_value_type(entry.function)
    )
    for entry in entries:
        register_jitable(**OPTIONS)(entry.function)
    for entry in entries:
        types_of_arguments = tuple(map(numba.typeof, entry.example(ROWS)))
        translated = numba.njit(**OPTIONS)(entry.function)
        translated.compile(types_of_arguments)
        description = translated.overloads[types_of_arguments].fndesc
        code.modules.append(_from_table(context, entry.function.__name__, description))
    linked: bytes = code.linked().as_bitcode()
    return linked


def _from_table(context: Any, name: str, description: Any) -> Any:
    """Write the function that reads a table of arguments and calls an entry with them."""
    module = context.create_module(name)
    word = ir.IntType(64)
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
        if isinstance(kind, numba.types.Array):
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
        model = context.get_value_type(kind)
        if kind == numba.types.boolean:
            return builder.trunc(value, model)
        return builder.bitcast(value, model)

    _, result = context.call_conv.call_function(
        builder,
        ir.Function(
            module,
            context.call_conv.get_function_type(description.restype, description.argtypes),
            description.llvm_func_name,
        ),
        description.restype,
        description.argtypes,
        [argument(kind) for kind in description.argtypes],
    )
    builder.ret(word(0) if description.restype == numba.types.none else result)
    return llvm.parse_assembly(str(module))

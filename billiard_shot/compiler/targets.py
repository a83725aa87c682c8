"""Machine code for a target: LLVM optimizes a captured module; zig compiles musl and links."""

import os
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import NamedTuple

import llvmlite.binding as llvm
import ziglang


class Target(NamedTuple):
    """A system that the library is built for."""

    file: str  # name of the library
    triple: str  # of LLVM
    cpu: str
    system: str  # as zig names it
    headers: str  # folder of zig's, with the types of the system
    link: tuple[str, ...]


_SHARED = '-shared', '-fPIC', '-Wl,-Bsymbolic', '-Wl,-z,noexecstack'
TARGETS = {
    'linux-x86_64': Target(
        'linux-x86_64.so',
        'x86_64-unknown-linux-gnu',
        'x86-64',
        'x86_64-linux-musl',
        'x86_64-linux-musl',
        _SHARED,
    ),
    'linux-aarch64': Target(
        'linux-aarch64.so',
        'aarch64-unknown-linux-gnu',
        'generic',
        'aarch64-linux-musl',
        'aarch64-linux-musl',
        _SHARED,
    ),
    'wasm32': Target(
        'wasm32.wasm',
        'wasm32-unknown-unknown',
        'generic',
        'wasm32-wasi-musl',
        'wasm-wasi-musl',
        ('-Wl,--no-entry', '-Wl,--export=__heap_base', '-Wl,-z,stack-size=1048576'),
    ),
}
_LIBC = Path(ziglang.__file__).parent / 'lib' / 'libc'
LICENCE = _LIBC / 'musl' / 'COPYRIGHT'
# What the code calls, and what that calls in turn.
_FUNCTIONS = (
    *('sin', 'cos', 'sincos', '__sin', '__cos', '__rem_pio2', '__rem_pio2_large', 'scalbn'),
    *('pow', 'pow_data', 'exp', 'exp_data', 'log10', 'log2', 'log2_data', 'erf'),
    *('atan', 'atan2', 'asin', 'acos', 'hypot', 'floor', 'fabs', 'sqrt', 'sqrt_data'),
    *(f'__math_{each}' for each in ('xflow', 'oflow', 'uflow', 'divzero', 'invalid')),
)
# No fused multiply-add: the same bits everywhere.
_OPTIONS = (
    *('-std=c99', '-O2', '-ffreestanding', '-fno-builtin', '-ffp-contract=off', '-U__FP_FAST_FMA'),
    *('-fvisibility=hidden', '-fno-sanitize=all', '-fno-stack-protector', '-w', '-nostdlib', '-s'),
)


def compile_for(target: Target, code: Path, entries: list[str]) -> bytes:
    """
    Return the library for a target.

    Parameters
    ----------
    target : Target
    code : Path
        The captured module.
    entries : list of str
        The functions that it exports.

    """
    with tempfile.TemporaryDirectory() as scratch:
        made, library = Path(scratch, 'entries.o'), Path(scratch, target.file)
        made.write_bytes(_optimized(target, code.read_bytes(), entries))
        _link(target, made, library, entries)
        return library.read_bytes()


def _optimized(target: Target, bitcode: bytes, entries: list[str]) -> bytes:
    """Return an object file."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(target.triple).create_target_machine(
        cpu=target.cpu,
        opt=3,
        codemodel='default',
        reloc='static' if target.file.endswith('wasm') else 'pic',
    )
    module = llvm.parse_bitcode(bitcode)
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    # What is internal vanishes if it is not used, as are the environments of numba.
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name not in entries:
            each.linkage = llvm.Linkage.internal
    module.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = False
    passes = llvm.create_pass_builder(machine, options)
    passes.getModulePassManager().run(module, passes)
    return machine.emit_object(module)


def _link(target: Target, made: Path, library: Path, entries: list[str]) -> None:
    """Link an object file with the functions of musl that it calls."""
    musl = _LIBC / 'musl'
    headers = musl / 'src' / 'include', musl / 'src' / 'internal', musl / 'arch' / 'generic'
    systems = _LIBC / 'include' / target.headers, _LIBC / 'include' / 'generic-musl'
    exports = [f'-Wl,--export={name}' for name in entries] if target.file.endswith('wasm') else []
    sources = [musl / 'src' / 'math' / f'{name}.c' for name in _FUNCTIONS]
    command: tuple[str | Path, ...] = (
        *(sys.executable, '-m', 'ziglang', 'cc', '-target', target.system, *_OPTIONS),
        *(f'-I{each}' for each in headers),
        *(f'-isystem{each}' for each in systems),
        *(*target.link, *exports, '-o'),
        *(library, made, *sources),
        musl / 'src' / 'string' / 'memset.c',
    )
    scratch = str(library.parent)
    caches = {'ZIG_GLOBAL_CACHE_DIR': scratch, 'ZIG_LOCAL_CACHE_DIR': scratch}
    done = subprocess.run(
        command, env=os.environ | caches, cwd=scratch, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f'{library.name} cannot be linked: {done.stderr.strip()[-2000:]}')

"""Machine code for a target: LLVM optimizes the captured code; zig compiles musl, and links."""

import os
from pathlib import Path
import subprocess
import sys
import tempfile
from typing import NamedTuple

import llvmlite.binding as llvm
import ziglang

_LIBC = Path(ziglang.__file__).parent / 'lib' / 'libc'
_MUSL = _LIBC / 'musl'
LICENCE = _MUSL / 'COPYRIGHT'


class BuildTarget(NamedTuple):
    """A system that the library is built for."""

    suffix: str  # of the library's file
    triple: str  # its name for LLVM
    cpu: str
    zig: str  # its name for zig
    headers: str  # folder of zig's, with the types of the system
    options: tuple[str, ...]
    own: str = ''  # C of what this system wants beside musl's functions


_SHARED = '-shared', '-fPIC'
_WASM = 'wasm-wasi-musl'  # the folder of headers whose types macOS and Windows share
_STACK = 1 << 20  # bytes
# LLVM joins sin and cos of the same angle into a call of the mathematics of macOS.
_SINCOS = """
struct both { double sin, cos; };
void sincos(double, double *, double *);
struct both __sincos_stret(double x) { struct both y; sincos(x, &y.sin, &y.cos); return y; }
"""
_MAIN = 'int _DllMainCRTStartup(void *library, unsigned why, void *more) { return 1; }'
TARGETS = {
    'linux-x86_64': BuildTarget(
        '.so', 'x86_64-linux-gnu', 'x86-64', 'x86_64-linux-musl', 'x86_64-linux-musl', _SHARED
    ),
    'linux-aarch64': BuildTarget(
        '.so', 'aarch64-linux-gnu', 'generic', 'aarch64-linux-musl', 'aarch64-linux-musl', _SHARED
    ),
    'darwin-arm64': BuildTarget(
        '.dylib',
        'arm64-apple-macosx11.0',
        'apple-m1',
        'aarch64-macos.11.0',
        _WASM,
        _SHARED,
        _SINCOS,
    ),
    'windows-amd64': BuildTarget(
        '.dll',
        'x86_64-pc-windows-gnu',
        'x86-64',
        'x86_64-windows-gnu',
        _WASM,
        ('-shared', '-D__DEFINED_size_t'),
        _MAIN,
    ),
    'wasm32': BuildTarget(
        '.wasm',
        'wasm32-unknown-unknown',
        'generic',
        'wasm32-wasi-musl',
        _WASM,
        ('-Wl,--no-entry', '-Wl,--export=__heap_base', f'-Wl,-z,stack-size={_STACK}'),
    ),
}
# What the code calls, and what that calls in turn.
_NAMES = (
    *('sin', 'cos', 'sincos', '__sin', '__cos', '__rem_pio2', '__rem_pio2_large', 'scalbn'),
    *('pow', 'pow_data', 'exp', 'exp_data', 'log10', 'log2', 'log2_data', 'erf'),
    *('atan', 'atan2', 'asin', 'acos', 'hypot', 'floor', 'fabs', 'sqrt', 'sqrt_data'),
    *(f'__math_{each}' for each in ('xflow', 'oflow', 'uflow', 'divzero', 'invalid')),
)
_FUNCTIONS = 'string/memset', *(f'math/{name}' for name in _NAMES)
# No fused multiply-add: the same bits everywhere.
_OPTIONS = (
    *('-std=c99', '-O2', '-ffreestanding', '-fno-builtin', '-ffp-contract=off', '-U__FP_FAST_FMA'),
    *('-fvisibility=hidden', '-fno-sanitize=all', '-fno-stack-protector', '-w', '-nostdlib', '-s'),
)


def compile_for(target: BuildTarget, code: bytes, entries: list[str]) -> bytes:
    """
    Return the library for a target.

    Parameters
    ----------
    target : BuildTarget
    code : bytes
        The captured module, as bitcode.
    entries : list of str
        The functions that it exports.

    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(target.triple).create_target_machine(
        cpu=target.cpu,
        opt=3,
        codemodel='default',
        reloc='pic' if '-fPIC' in target.options else 'static',
    )
    module = llvm.parse_bitcode(code)
    module.triple, module.data_layout = target.triple, str(machine.target_data)
    # LLVM removes internal functions and variables that nothing uses: the environments of numba.
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name not in entries:
            each.linkage = llvm.Linkage.internal
        elif target.suffix == '.dll' and not each.is_declaration:
            each.storage_class = llvm.StorageClass.dllexport
    module.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = False
    passes = llvm.create_pass_builder(machine, options)
    passes.getModulePassManager().run(module, passes)
    exports = [f'-Wl,--export={name}' for name in entries] if target.suffix == '.wasm' else []
    return _linked(target, machine.emit_object(module), exports)


def _linked(target: BuildTarget, made: bytes, exports: list[str]) -> bytes:
    """Link an object file with the functions of musl that it calls."""
    headers = _MUSL / 'src' / 'include', _MUSL / 'src' / 'internal', _MUSL / 'arch' / 'generic'
    systems = _LIBC / 'include' / target.headers, _LIBC / 'include' / 'generic-musl'
    sources = [_MUSL / 'src' / f'{name}.c' for name in _FUNCTIONS]
    with tempfile.TemporaryDirectory() as scratch:
        entries, library = Path(scratch, 'entries.o'), Path(scratch, f'library{target.suffix}')
        own = Path(scratch, 'own.c')
        entries.write_bytes(made)
        own.write_text(target.own)
        command: tuple[str | Path, ...] = (
            *(sys.executable, '-m', 'ziglang', 'cc', '-target', target.zig, *_OPTIONS),
            *(*(f'-I{each}' for each in headers), *(f'-isystem{each}' for each in systems)),
            *(*target.options, *exports, '-o'),
            *(library, entries, own, *sources),
        )
        caches = {'ZIG_GLOBAL_CACHE_DIR': scratch, 'ZIG_LOCAL_CACHE_DIR': scratch}
        subprocess.run(command, env=os.environ | caches, cwd=scratch, check=True)
        return library.read_bytes()

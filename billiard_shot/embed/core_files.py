"""The files of the compiled core that pages and programs in C take with them."""

from base64 import b64encode
import json
from pathlib import Path
import shutil
import zlib

from billiard_shot import machine_code
from billiard_shot.compiler.build import HEADER, NOTICE, PAGES, provide

MODULE = Path(__file__).with_name('web')


def core_folder(target: str) -> Path:
    """
    Find the folder with the core for a target; build the core if there is none.

    Raises
    ------
    ValueError
        If it cannot be built.

    """
    if any(machine_code.PACKAGED.glob(f'{target}.*')):
        return machine_code.PACKAGED
    try:
        return provide(target)
    except (ModuleNotFoundError, RuntimeError) as error:
        raise ValueError(f'the core for {target} cannot be built: {error}') from None


def copy_module(folder: Path) -> None:
    """Copy the JavaScript module and the core into a folder, which then is a package for npm."""
    core = core_folder(PAGES)
    shutil.copy(core / f'{PAGES}.wasm', folder / 'core.wasm')
    for file in (core / machine_code.DESCRIPTION, core / NOTICE, *MODULE.iterdir()):
        shutil.copy(file, folder)


def copy_library(folder: Path) -> None:
    """Copy the header and the library for this machine into a folder."""
    core = core_folder(machine_code.LIBRARY)
    for file in (core / HEADER, core / NOTICE, *core.glob(f'{machine_code.LIBRARY}.*')):
        shutil.copy(file, folder)


def core_script() -> str:
    """
    Write the core as a script that pages on any host, or without one, can include.

    It defines `billiardShotCore`: the text of the `module`, and `wasm` and `description`,
    compressed, in base64.
    """
    core = core_folder(PAGES)
    parts = {
        'module': (MODULE / 'core.mjs').read_text(encoding='utf-8'),
        'wasm': _compressed(core / f'{PAGES}.wasm'),
        'description': _compressed(core / machine_code.DESCRIPTION),
    }
    return f'const billiardShotCore = {json.dumps(parts)};'.replace('<', '\\u003c')


def _compressed(file: Path) -> str:
    return b64encode(zlib.compress(file.read_bytes(), 9)).decode()

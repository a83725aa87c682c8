"""The files of the compiled core that pages and programs in C take with them."""

import json
from pathlib import Path
import shutil

from billiard_shot import machine_code
from billiard_shot.compiler.header import HEADER

WEB = Path(__file__).with_name('web')
FOR_PAGES = 'core.wasm', machine_code.DESCRIPTION, 'COPYRIGHT.musl'
FOR_C = HEADER, f'{machine_code.LIBRARY}.*', 'COPYRIGHT.musl'


def core_folder() -> Path:
    """
    Find the folder with the core that was built from these sources.

    Raises
    ------
    ValueError
        If there is none.

    """
    for folder in (machine_code.PACKAGED, machine_code.built()):
        file = folder / machine_code.DESCRIPTION
        if file.is_file() and json.loads(file.read_bytes())['sources'] == machine_code.sources():
            return folder
    raise ValueError('the core must be built first: billiard-shot compile')


def copy_core(folder: Path, in_c: bool) -> None:
    """Copy the core into a folder: the header and the library for C, or the module of pages."""
    built = core_folder()
    names = [path for name in (FOR_C if in_c else FOR_PAGES) for path in built.glob(name)]
    for path in (*names, *(() if in_c else WEB.iterdir())):
        shutil.copy(path, folder)

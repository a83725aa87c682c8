"""The backend of setuptools, which also asks for the tools that make the library."""

from pathlib import Path
import platform

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403

_REQUIRED = Path(__file__).with_name('requirements-build.txt')


def get_requires_for_build_wheel(config_settings=None):
    """Name the tools too, if numba has wheels for this system; it has none for musl."""
    required = build_meta.get_requires_for_build_wheel(config_settings)
    here = f'{platform.system()}-{platform.machine()}'.lower()
    if platform.libc_ver()[0] == 'glibc' or here in ('darwin-arm64', 'windows-amd64'):
        lines = _REQUIRED.read_text(encoding='utf-8').splitlines()
        required += ['pyyaml', *(line for line in lines if not line.startswith('#'))]
    return required

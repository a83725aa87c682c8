"""
Writes the tables of docs/benchmarks.md from what the benchmarks measure now.

    python benchmarks/tables.py [--quick] [NAME ...]

NAME: benchmarks to run, such as `strike`; by default all that the page has, in about ten minutes.
Each table says at which commit it was measured, and on which machine, if not on that of the page.
`--quick` takes smaller samples; the page says so. A benchmark that fails or takes too long keeps
its former table, and the others go on. The last three need a ROS 2. `table` compares with pooltool
if POOLTOOL_PYTHON names an interpreter that has it.
"""

import argparse
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
from time import perf_counter

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / 'docs' / 'benchmarks.md'
NAMES = 'strike', 'prediction', 'throughput', 'table', 'plan', 'service', 'cue', 'driver'
BEGIN, END = '<!-- table: {} -->', '<!-- end: {} -->'
MACHINE = 'Measured on '  # begins the line of the machine; a table from another one names its own
UNITS = {'x': '×', 'us': 'µs', '1/s': ''}  # as the page writes them
LONGEST = 600.0  # s that a benchmark may take
ROUNDING = 1e-8
ENDING = 30.0  # s in which an interrupted one may end its processes


def measured(name, quick):
    """Run a benchmark; return its rows, or None if it ended without any."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'rows.json'
        environment = os.environ | {'BENCHMARK_ROWS': str(path)}
        if quick:
            environment['BENCHMARK_QUICK'] = '1'
        script = [sys.executable, HERE / f'{name}.py']
        with subprocess.Popen(script, env=environment) as process:
            try:
                process.wait(LONGEST)
            except subprocess.TimeoutExpired:
                print(f'{name}: interrupted after {LONGEST:.0f} s', file=sys.stderr)
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(ENDING)
                except subprocess.TimeoutExpired:
                    process.kill()
        return json.loads(path.read_text()) if path.exists() else None


def commit():
    """Name the commit that is measured, and say if files but the page differ from it."""
    git = ['git', '-C', HERE]
    named = subprocess.run(
        [*git, 'describe', '--always', '--exclude=*'], text=True, capture_output=True, check=False
    ).stdout.strip()
    others = [
        'diff',
        '--quiet',
        'HEAD',
        '--',
        ':/',
        f':(exclude,top){PAGE.relative_to(HERE.parent)}',
    ]
    same = not subprocess.run([*git, *others], check=False).returncode
    if not named:
        return 'an unknown commit'
    return named if same else f'{named}, with changes'


def as_table(found, page):
    """Write the rows of a benchmark as a table of the page."""
    size = ', smaller samples' if found['quick'] else ''
    machine = '' if f'{MACHINE}{found["machine"]}.' in page else f', on {found["machine"]}'
    lines = [
        f'At {commit()}{size}{machine}.',
        '',
        '| quantity | measured | limit |',
        '|---|---|---|',
    ]
    group = ''  # of rows with the same words before a colon, which only the first one shows
    for row in found['rows']:
        if row['name'].startswith(' ') and (row['limit'] is None or row['kept']):
            continue  # a detail, which only the benchmark itself prints
        unit = UNITS.get(row['unit'], row['unit'])
        cpu = '' if row['cpu'] is None else f' (CPU {row["cpu"]:.3g})'
        limit = ''
        if row['limit'] is not None:
            sign = '≤' if row['limit'] > 0.0 else '≥'
            limit = f'{sign} {in_words(abs(row["limit"]))}{"" if row["kept"] else ", missed"}'
        name = row['name'].strip().replace('|', '/')
        before, colon, after = name.partition(': ')
        if row['name'].startswith(' '):
            name = f'– {name}'
        elif colon and before == group:
            name = f'– {after}'
        else:
            group = before
        value = f'{in_words(row["value"])} {unit}'.rstrip()
        lines.append(f'| {name} | {value}{cpu} | {limit} |')
    return '\n'.join([*lines, *(f'\n{note}.' for note in found['notes'])])


def in_words(number):
    """Write a number with three digits, without an exponent; 0 if it is only rounding."""
    if abs(number) < ROUNDING:
        return '0'
    return f'{number:,.0f}' if abs(number) >= 1000.0 else f'{number:.3g}'


def replaced(page, name, table):
    """Put a table between its marks in the page."""
    begin, end = BEGIN.format(name), END.format(name)
    before, _, rest = page.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise SystemExit(f'{PAGE}: no marks {begin} and {end}')
    return f'{before}{begin}\n{table}\n{end}{after}'


def all_on(page, machine):
    """Name the machine once, if it has measured all tables."""
    lines = page.replace(f', on {machine}', '').split('\n')
    return '\n'.join(
        f'{MACHINE}{machine}.' if line.startswith(MACHINE) else line for line in lines
    )


def main():
    """Measure, and write the page after each benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('names', nargs='*', metavar='NAME', help=f'of {", ".join(NAMES)}')
    parser.add_argument('--quick', action='store_true', help='smaller samples')
    options = parser.parse_args()
    if unknown := sorted(set(options.names) - set(NAMES)):
        parser.error(f'NAME must be of {", ".join(NAMES)}, got {", ".join(unknown)}')
    failed = []
    for name in options.names or NAMES:
        print(f'== {name}', flush=True)
        begin = perf_counter()
        found = measured(name, options.quick)
        print(f'== {name}: {perf_counter() - begin:.0f} s', flush=True)
        if found is None:
            failed.append(name)
            continue
        page = PAGE.read_text()
        page = replaced(page, name, as_table(found, page))
        if name == NAMES[-1] and not options.names and not failed:
            page = all_on(page, found['machine'])
        PAGE.write_text(page)
    if failed:
        sys.exit(f'without a result: {", ".join(failed)}')


if __name__ == '__main__':
    main()

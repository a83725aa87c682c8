"""The pages of README and docs, with the examples that they show from files."""

from pathlib import Path
import re

DOCS = Path(__file__).resolve().parents[1]
FILE = re.compile(r'<!-- file: (\S+) -->\n```\w+\n(.*?)^```$', re.MULTILINE | re.DOTALL)
"""A file that a page shows: its name and its text."""
_INCLUDED = re.compile(r'^```{literalinclude} (\S+)\n:language: (\w+)\n```$', re.MULTILINE)


def text_of(page: Path) -> str:
    """Return the text of a page in which each `literalinclude` is the file that it names."""
    return _INCLUDED.sub(
        lambda found: f'```{found[2]}\n{(page.parent / found[1]).read_text()}```', page.read_text()
    )


def included_in(page: Path) -> set[str]:
    """Return the names of the files that a page shows with `literalinclude`."""
    return {name for name, _ in _INCLUDED.findall(page.read_text())}

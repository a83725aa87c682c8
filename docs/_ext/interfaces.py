"""The page of all interfaces, made of the comments in msg_defs."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
import re

PACKAGE = 'billiard_shot_msgs'
PARTS = {'.msg': ('',), '.srv': ('Request', 'Response'), '.action': ('Goal', 'Result', 'Feedback')}
KINDS = {'.srv': 'service', '.action': 'action', '.msg': 'message'}


@dataclass
class Item:
    """A field or constant: its type, name, value (of a constant) and comment."""

    type: str
    name: str
    value: str
    comment: str


@dataclass
class Group:
    """Constants that stand together, under one comment."""

    comment: str
    constants: list[Item] = field(default_factory=list)


@dataclass
class Part:
    """A message, or one part of a service or an action, in the order of its file."""

    name: str
    comment: str
    items: list[Item | Group]

    @property
    def fields(self) -> list[Item]:
        """Fields of the message, without its constants."""
        return [item for item in self.items if isinstance(item, Item)]


@dataclass
class Interface:
    """A file of msg_defs."""

    name: str
    kind: str
    parts: list[Part]


def read_interfaces(folder: Path) -> list[Interface]:
    """All interfaces of a package; services and actions first."""
    files = [file for suffix in KINDS for file in sorted(folder.glob(f'*/*{suffix}'))]
    return [Interface(file.stem, KINDS[file.suffix], list(_parts(file))) for file in files]


def page(folder: Path) -> str:
    """The page, in Markdown."""
    interfaces = read_interfaces(folder)
    names = {interface.name for interface in interfaces}
    lines = [
        '# Interfaces',
        '',
        f'Package `{PACKAGE}`. All in SI units and, where not said otherwise, in the frame '
        '`table` (REP-103): origin on the cloth at the centre of the bed, x along its length, y '
        'along its width, z up.',
        '',
    ]
    for interface in interfaces:
        lines += [
            f'## {interface.name}',
            '',
            f'*{interface.kind}* `{PACKAGE}/{_folder(interface.kind)}/{interface.name}`',
            '',
        ]
        for part in interface.parts:
            if part.name:
                lines += [f'### {interface.name}: {part.name.lower()}', '']
            lines += [_escaped(part.comment), ''] if part.comment else []
            lines += _table(part, names)
    return '\n'.join(lines) + '\n'


def _table(part: Part, names: set[str]) -> Iterator[str]:
    """Tables in the order of the file: of fields, and of each group of constants."""
    for of_fields, items in groupby(part.items, lambda item: isinstance(item, Item)):
        if of_fields:
            yield from ('| field | type | what |', '|---|---|---|')
            for item in items:
                yield f'| `{item.name}` | {_type(item.type, names)} | {_escaped(item.comment)} |'
            yield ''
            continue
        for group in items:
            yield from (_escaped(group.comment), '', '| constant | value | |', '|---|---|---|')
            for item in group.constants:
                yield f'| `{item.name}` | {item.value} | {_escaped(item.comment)} |'
            yield ''


def _type(name: str, names: set[str]) -> str:
    bare = name.removesuffix('[]')
    return f'[`{name}`](#{bare.lower()})' if bare in names else f'`{name}`'


def _folder(kind: str) -> str:
    return {'service': 'srv', 'action': 'action', 'message': 'msg'}[kind]


def _escaped(text: str) -> str:
    return text.replace('|', '\\|').replace('<', '&lt;')


def _parts(file: Path) -> Iterator[Part]:
    texts = re.split(r'^---$\n?', file.read_text(), flags=re.MULTILINE)
    for name, text in zip(PARTS[file.suffix], texts, strict=True):
        yield _part(name, text)


def _part(name: str, text: str) -> Part:
    """Read one part: paragraphs of comments, each followed by the declarations it describes."""
    comments: list[str] = []
    header = ''
    items: list[Item | Group] = []
    for paragraph in re.split(r'\n\s*\n', text.strip('\n')):
        lines = paragraph.splitlines()
        said = [line[1:].strip() for line in lines if line.startswith('#')]
        declared = [line for line in lines if line and not line.startswith('#')]
        comment = re.sub(r' *\n *', '\n', ' '.join(line or '\n\n' for line in said)).strip()
        if not declared:
            comments.append(comment)
            continue
        if not items:
            header, comments = '\n\n'.join(comments), []
        for line in declared:
            item = _item(line, comment)
            if not item.value:
                items.append(item)
            else:
                if comment or not items or isinstance(items[-1], Item):
                    items.append(Group(comment))
                    comment = ''
                items[-1].constants.append(item)
    if not items:
        header = '\n\n'.join(comments)
    return Part(name, header, items)


def _item(line: str, comment: str) -> Item:
    declaration, _, inline = line.partition('#')
    # Not at the = of a bound, as in Type[<=1].
    declaration, value = [*re.split('(?<!<)=', declaration, maxsplit=1), ''][:2]
    type_, name, *default = declaration.split()
    if default:
        comment = f'{comment} {default[0]} by default.'
    return Item(type_, name, value.strip(), inline.strip() if value else comment)

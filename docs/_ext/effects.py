"""The page of all effects, made from their gates."""

from billiard_shot.shot.effects import GATES


def page() -> str:
    """The page, in Markdown."""
    lines = [
        '# All effects',
        '',
        'The names are the keys of `effects` in a scene. [Effects](../effects.md) explains the '
        'settings.',
        '',
        '| effect | simulated when | if it is off |',
        '|---|---|---|',
    ]
    for gate in GATES:
        lines.append(f'| `{gate.name}` | {gate.condition} | {gate.without} |')
    return '\n'.join([*lines, ''])

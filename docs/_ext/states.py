"""The page of the safety states of the cue, made from their table."""

from billiard_shot.cue.safety import Condition, SAFE, SafetyEvent, SafetyState, TRANSITIONS


def page() -> str:
    """The page, in Markdown."""
    rows: dict[tuple[SafetyEvent, SafetyState, frozenset[Condition]], list[str]] = {}
    for (before, event), (after, needed) in TRANSITIONS.items():
        rows.setdefault((event, after, needed), []).append(before.name)
    lines = [
        '# States of the cue',
        '',
        '[The mechanical cue](../cue.md#the-states) explains them. Every event that is not in '
        'this table is refused with the reason.',
        '',
        f'*Safe*: {"; ".join(each for each in Condition if each in SAFE)}.',
        '',
        '| event | from | to | needs |',
        '|---|---|---|---|',
    ]
    for (event, after, needed), before in rows.items():
        rest = needed - SAFE if needed >= SAFE else needed
        needs = [*(['safe'] if needed >= SAFE else []), *(c for c in Condition if c in rest)]
        lines.append(f'| {event} | {", ".join(before)} | {after.name} | {"; ".join(needs)} |')
    return '\n'.join([*lines, ''])

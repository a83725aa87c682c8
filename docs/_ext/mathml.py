"""An extension that writes formulas as MathML, which browsers show without any script."""

from typing import Any

from docutils.nodes import math, math_block, SkipNode
from latex2mathml.converter import convert


def inline(visitor: Any, node: math) -> None:
    """Write a formula in a line."""
    visitor.body.append(convert(node.astext()))
    raise SkipNode


def block(visitor: Any, node: math_block) -> None:
    """Write a formula on its own."""
    visitor.body.append(f'<div>{convert(node.astext(), display="block")}</div>')
    raise SkipNode


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_html_math_renderer('mathml', (inline, None), (block, None))
    return {'version': '1', 'parallel_read_safe': True}

"""YAML as people write it: 1e-3 is a number, and a key that is there twice is a mistake."""
from pathlib import Path
import re
from typing import Any

import yaml


class _Loader(yaml.SafeLoader):
    """Safe loader after YAML 1.2 where PyYAML's YAML 1.1 surprises people."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(
                    None, None, f'key {key!r} is there twice', node.start_mark
                )
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$'),
    list('-+0123456789.'),
)


def read_yaml(path: Path) -> Any:
    """Read a YAML file; ValueError with file and place if that is not possible."""
    try:
        with path.open(encoding='utf-8') as file:
            return yaml.load(file, _Loader)  # a safe loader
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ValueError(f'{path}: {error}') from error

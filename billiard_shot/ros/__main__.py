"""`python -m billiard_shot.ros PROGRAM ...`: runs a node or a client, installed or not."""

from importlib import import_module
from pathlib import Path
import sys

MODULES = {path.stem for path in Path(__file__).parent.glob('*.py')}

if __name__ == '__main__':
    name = sys.argv.pop(1) if len(sys.argv) > 1 else ''
    module = import_module(f'billiard_shot.ros.{name}') if name in MODULES else None
    main = getattr(module, 'main', None)
    if main is None:
        sys.exit(f'the program must be a node or a client, such as planner, got {name!r}')
    main()

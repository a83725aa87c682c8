"""`python -m billiard_shot.ros PROGRAM ...`: runs a node or a client, installed or not."""

from importlib import import_module
import sys

if __name__ == '__main__':
    import_module(f'billiard_shot.ros.{sys.argv.pop(1)}').main()

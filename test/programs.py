"""Programs that tests run."""

import subprocess


def ran(command, check=False, **options):
    """Run a command to its end; its exit code, output and errors."""
    return subprocess.run(command, capture_output=True, text=True, check=check, **options)

"""Exit codes of the command line."""

from collections.abc import Mapping

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

EXIT_CODES: Mapping[int, str] = {
    DONE: 'done',
    FAILED: 'no result, such as a refused stroke, no plan or a file with mistakes',
    WRONG_INPUT: 'wrong input',
    INTERRUPTED: 'interrupted by Ctrl+C',
}

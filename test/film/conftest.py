"""Skips the tests of films if their libraries are missing, and renders the films once."""

import pytest

pytest.importorskip('cv2', reason='needs OpenCV, an extra: film')
pytest.importorskip('av', reason='needs PyAV, an extra: film')

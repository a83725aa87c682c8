"""A browser for the tests of a module."""

from browser import Browser
import pytest


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp('browser'))
    yield opened
    opened.close()

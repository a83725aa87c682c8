"""The option `--site`: where a page is to be published."""

import argparse
from urllib.parse import urlsplit


def add_site_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        '--site',
        default='',
        metavar='URL',
        help='address at which the page is to be published: the links that it shares lead there '
        '(default: to where the page is)',
    )


def site_of(options: argparse.Namespace) -> str:
    """Return the address; ValueError if it is not one of a page on the web."""
    parts = urlsplit(options.site)
    if options.site and not (parts.scheme in ('http', 'https') and parts.netloc):
        raise ValueError(
            f'--site must be an address, such as https://host/table.html, got {options.site!r}'
        )
    return parts._replace(fragment='').geturl()

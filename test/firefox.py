"""Firefox without a window, driven by its protocol Marionette."""

import json
from pathlib import Path
import shutil
import socket
import subprocess
import time

PATIENCE = 120  # s


def find_firefox():
    """Path of Firefox, None if there is none."""
    return shutil.which('firefox') or shutil.which('firefox-esr')


class Firefox:
    """A page in a Firefox of its own, with an empty profile in a folder."""

    def __init__(self, folder):
        (folder / 'user.js').write_text('user_pref("marionette.port", 0);')  # a free one
        self.process = subprocess.Popen(
            [find_firefox(), '--headless', '--no-remote', '--marionette', '--profile', folder],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        end = time.monotonic() + PATIENCE
        port = Path(folder) / 'MarionetteActivePort'
        while not (port.is_file() and port.read_text().strip()):
            assert time.monotonic() < end
            time.sleep(0.05)
        self.socket = socket.create_connection(('127.0.0.1', int(port.read_text())), PATIENCE)
        self.number, self.stream = 0, self.socket.makefile('rb')
        self._read()  # its greeting
        self.call('WebDriver:NewSession')

    def call(self, command, **parameters):
        """Send a command; return its result."""
        self.number += 1
        text = json.dumps([0, self.number, command, parameters]).encode()
        self.socket.sendall(b'%d:%s' % (len(text), text))
        _, _, error, result = self._read()
        assert error is None, error
        return result

    def _read(self):
        length = b''
        while (digit := self.stream.read(1)) != b':':
            length += digit
        return json.loads(self.stream.read(int(length)))

    def run(self, expression):
        """Value of an expression in the page."""
        return self.call('WebDriver:ExecuteScript', script=f'return {expression}')['value']

    def open(self, path):
        """Open a file and wait until it can be played on."""
        self.call('WebDriver:Navigate', url=path.as_uri())
        end = time.monotonic() + PATIENCE
        while self.run('document.body.dataset.ready') != 'true':
            assert time.monotonic() < end
            time.sleep(0.05)

    def close(self):
        """End it."""
        self.process.terminate()
        self.process.wait(PATIENCE)
        self.socket.close()

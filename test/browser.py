"""Chromium without a window, driven over a pipe by its DevTools protocol."""

import base64
import contextlib
import json
import os
from pathlib import Path
import shutil
import subprocess
import time

import numpy as np

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
OPTIONS = (
    '--headless=new',
    '--no-sandbox',
    '--disable-dev-shm-usage',
    '--remote-debugging-pipe',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--hide-scrollbars',
    '--force-device-scale-factor=1',
)
PATIENCE = 120  # s for one answer: machines that test are busy


def find_browser():
    """Path of a Chromium, None if there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Browser:
    """A page in a browser of its own; `messages` is all that it said on the console."""

    def __init__(self, folder, width=1000, height=600):
        to_child, self.send_end = os.pipe()
        self.receive_end, from_child = os.pipe()

        def connect():  # the browser reads from 3 and writes to 4
            a, b = os.dup(to_child), os.dup(from_child)
            os.dup2(a, 3)
            os.dup2(b, 4)

        self.process = subprocess.Popen(
            [
                find_browser(),
                *OPTIONS,
                f'--user-data-dir={folder}',
                f'--window-size={width},{height}',
                'about:blank',
            ],
            preexec_fn=connect,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_child)
        os.close(from_child)
        os.set_blocking(self.receive_end, False)
        self.buffer, self.number, self.messages, self.session = b'', 0, [], None
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        self.session = self.call('Target.attachToTarget', targetId=target, flatten=True)[
            'sessionId'
        ]
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')
        self.call(
            'Emulation.setDeviceMetricsOverride',
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def call(self, method, **parameters):
        """Call a method of the protocol; return its result."""
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        os.write(self.send_end, json.dumps(message).encode() + b'\0')
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for answer in self._receive():
                if answer.get('id') == self.number:
                    assert 'error' not in answer, answer
                    return answer['result']
                self._note(answer)
        raise TimeoutError(method)

    def _receive(self):
        while b'\0' not in self.buffer:
            try:
                part = os.read(self.receive_end, 1 << 20)
                assert part, 'the browser has gone'
                self.buffer += part
            except BlockingIOError:
                time.sleep(0.005)
                return []
        *whole, self.buffer = self.buffer.split(b'\0')
        return [json.loads(text) for text in whole]

    def _note(self, event):
        parameters = event.get('params', {})
        if event.get('method') == 'Runtime.consoleAPICalled':
            self.messages.append([argument.get('value') for argument in parameters['args']])
        elif event.get('method') == 'Runtime.exceptionThrown':
            self.messages.append(parameters['exceptionDetails'])
        elif event.get('method') == 'Log.entryAdded':
            self.messages.append(parameters['entry'])
        elif event.get('method') == 'Network.requestWillBeSent':
            self.requests.append(parameters['request']['url'])

    def open(self, page, fragment=''):
        """Open a file or an address and wait until it is loaded."""
        self.requests = []
        self.call('Page.navigate', url='about:blank')  # else a fragment alone is followed
        address = page if isinstance(page, str) else page.as_uri()
        self.call('Page.navigate', url=address + fragment)
        self.wait_for('document.readyState === "complete"')

    def run(self, script):
        """Value of an expression in the page; promises are awaited."""
        result = self.call(
            'Runtime.evaluate', expression=script, returnByValue=True, awaitPromise=True
        )
        assert 'exceptionDetails' not in result, result
        return result['result'].get('value')

    def wait_for(self, script):
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.run(script):
            assert time.monotonic() < end, script
            time.sleep(0.02)

    def settle(self):
        """Wait until what was asked for is drawn."""
        self.run('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))')

    def press(self, key, modifiers=0):
        """Press and release a key."""
        text = {'text': key} if len(key) == 1 else {}
        for kind in ('keyDown', 'keyUp'):
            self.call('Input.dispatchKeyEvent', type=kind, key=key, modifiers=modifiers, **text)

    def mouse(self, kind, x, y, **options):
        """Send a mouse event."""
        self.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, **options)

    def screenshot(self, path):
        """Write what is shown to a PNG file."""
        self.settle()
        data = self.call('Page.captureScreenshot', format='png')['data']
        Path(path).write_bytes(base64.b64decode(data))

    def close(self):
        """End the browser."""
        with contextlib.suppress(OSError):
            self.call('Browser.close') if self.process.poll() is None else None
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.send_end)
        os.close(self.receive_end)


# ---- the page of a shot ----


def opened(browser, path, text, fragment=''):
    """Write a page, open it and wait until it can be played on."""
    path.write_text(text, encoding='utf-8')
    browser.messages.clear()
    browser.open(path, fragment)
    browser.wait_for('document.body.dataset.ready === "true"')
    browser.settle()
    return browser


def choose(browser, field, value):
    browser.run(
        f"(() => {{ const s = document.getElementById('{field}'); s.value = {value!r};"
        "s.dispatchEvent(new Event('change')); })()"
    )
    browser.settle()


def click(browser, x, y):
    for kind in ('mousePressed', 'mouseReleased'):
        browser.mouse(kind, x, y, button='left', buttons=1, clickCount=1)
    browser.settle()


def drag(browser, begin, end):
    browser.mouse('mousePressed', *begin, button='left', buttons=1, clickCount=1)
    for part in (0.3, 0.7, 1.0):
        x, y = np.array(begin) + part * (np.array(end) - begin)
        browser.mouse('mouseMoved', x, y, button='left', buttons=1)
    browser.mouse('mouseReleased', *end, button='left', clickCount=1)
    browser.settle()


def open_tab(browser, name):
    browser.run(f"document.getElementById('tab-{name}').click()")
    browser.settle()

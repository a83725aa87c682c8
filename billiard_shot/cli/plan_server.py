"""
Serves the page of a scene from this machine, with the planner behind it.

The address has a random token, which other pages and users of the machine cannot know. A request
for a plan is answered line by line, as JSON: `progress` of the search, then its `result`, or that
the request was `refused`. The search is cancelled if the page closes the request.
"""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from hmac import compare_digest
import json
from secrets import token_urlsafe
from threading import Event
from time import monotonic
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.iostream import StreamClosedError
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler

from billiard_shot import plan, Scene
from billiard_shot.cli.plan import as_json
from billiard_shot.embed.page_state import check_form, noise_in, scene_in
from billiard_shot.planning.plan import USUAL_SECONDS
from billiard_shot.planning.runner import Progress
from billiard_shot.scene.player import OFFSETS

ADDRESS = '127.0.0.1'
USUAL_PORT = 80  # which browsers do not name
LARGEST_REQUEST = 1_000_000  # bytes
PATIENCE_S = 5.0  # s, for answers to end with the server
REPORT_S = 0.1  # s between two reports of progress, unless there is a better stroke
HEADERS = {  # so that pages of other origins can neither show, read nor keep hold of this one
    'Content-Security-Policy': "frame-ancestors 'none'",
    'X-Frame-Options': 'DENY',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'same-origin',
    'Cache-Control': 'no-store',
}
Line = dict[str, Any]


async def serve(scene: Scene, page: str, port: int, announce: Callable[[str], object]) -> None:
    """
    Serve the page of a scene until the task is cancelled.

    Parameters
    ----------
    scene : Scene
    page : str
        Made with the data `planner`.
    port : int
        0 to 65535; 0: one that is free.
    announce : callable
        Called with the address once it answers.

    Raises
    ------
    OSError
        If the port is in use.

    """
    sockets = bind_sockets(port, ADDRESS)
    used = sockets[0].getsockname()[1]
    host = ADDRESS if used == USUAL_PORT else f'{ADDRESS}:{used}'
    served = Served(scene, page, host, token_urlsafe(), Event())
    handlers = [(path, kind, {'served': served}) for path, kind in PATHS.items()]
    application = Application(handlers, log_function=lambda handler: None)
    server = HTTPServer(application, max_body_size=LARGEST_REQUEST)
    server.add_sockets(sockets)
    announce(f'http://{host}/{served.token}/')
    try:
        await asyncio.Event().wait()
    finally:
        served.ending.set()
        server.stop()
        await server.close_all_connections()
        if answers := asyncio.all_tasks() - {asyncio.current_task()}:
            await asyncio.wait(answers, timeout=PATIENCE_S)


@dataclass(frozen=True, slots=True)
class Served:
    """What is served; searches are cancelled once `ending` is set."""

    scene: Scene
    page: str
    host: str
    token: str
    ending: Event


class Guarded(RequestHandler):
    """Answers only requests with the token, and none of pages with another origin or name."""

    def initialize(self, served: Served) -> None:
        """Take what is served."""
        self.served = served

    def set_default_headers(self) -> None:
        """Set the headers of all answers."""
        for name, text in HEADERS.items():
            self.set_header(name, text)

    def prepare(self) -> None:
        """Refuse requests of others. Browsers name the origin of all that can change something."""
        host, origin = self.served.host, self.request.headers.get('Origin', '')
        may_lack_origin = self.request.method == 'GET'
        # another name can be bound to this address by a page of another origin
        if self.request.host != host or not (
            origin == f'http://{host}' or (may_lack_origin and not origin)
        ):
            raise HTTPError(403)
        if not compare_digest(self.path_args[0].encode(), self.served.token.encode()):
            raise HTTPError(404)


class Page(Guarded):
    """The page."""

    def get(self, token: str) -> None:
        """Answer with the page."""
        self.finish(self.served.page)


class Plans(Guarded):
    """Plans for the state of a page."""

    def initialize(self, served: Served) -> None:
        """Take what is served."""
        super().initialize(served)
        self.gone = Event()

    def on_connection_close(self) -> None:
        """Cancel the search if the page has closed the request."""
        self.gone.set()

    async def post(self, token: str) -> None:
        """Search in a thread, and write each line as it comes."""
        try:
            asked = read_request(self.request.body)
        except ValueError as error:
            self.set_status(400)
            self.finish(str(error))
            return
        loop, lines = asyncio.get_running_loop(), asyncio.Queue[Line | None]()

        def tell(line: Line | None) -> None:
            loop.call_soon_threadsafe(lines.put_nowait, line)

        work = loop.run_in_executor(None, self._search, asked, tell)
        self.set_header('Content-Type', 'application/x-ndjson')
        with suppress(StreamClosedError):
            while line := await lines.get():
                self.write(json.dumps(line, allow_nan=False) + '\n')
                await self.flush()
        await work

    def _search(self, asked: Line, tell: Callable[[Line | None], None]) -> None:
        """Plan; tell of progress and the result, and None at the end."""
        try:
            scene = scene_in(asked['state'], self.served.scene)
            noise = noise_in(asked['state'], scene)
            result = plan(
                scene,
                asked['target'],
                noise,
                seconds=asked.get('seconds') or USUAL_SECONDS,
                progress=reporter(tell),
                cancel=lambda: self.gone.is_set() or self.served.ending.is_set(),
            )
            tell({'result': as_json(result)})
        except ValueError as error:
            tell({'refused': str(error)})
        finally:
            tell(None)


def read_request(body: bytes) -> Line:
    """Read a request for a plan; ValueError if it does not have the form of one."""
    asked = json.loads(body)
    if not isinstance(asked, dict) or not {'state', 'target'} <= asked.keys():
        raise ValueError(f'a request must have state and target, got {asked!r}')
    check_form(asked['state'])
    return asked


def reporter(tell: Callable[[Line], None]) -> Callable[[Progress], None]:
    """Make a function that tells of better strokes at once, and of other progress now and then."""
    last, best = 0.0, None

    def report(now: Progress) -> None:
        nonlocal last, best
        if now.stroke is best and monotonic() - last < REPORT_S:
            return
        last, best = monotonic(), now.stroke
        stroke = best and dict(zip(OFFSETS, best.offsets, strict=True))
        counted = {'simulations': now.simulations, 'budget': now.budget, 'success': now.success}
        tell({'progress': {**counted, 'stroke': stroke}})

    return report


PATHS: dict[str, type[Guarded]] = {'/([^/]*)/': Page, '/([^/]*)/plan': Plans}

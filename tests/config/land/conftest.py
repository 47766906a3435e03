"""A server on this machine that notes what is asked of it."""

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import pytest


@pytest.fixture
def requests():
    """The address of a server, and the paths of all requests that it got."""
    noted = SimpleNamespace(paths=[])

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            noted.paths.append(self.path)
            self.send_error(404)

        do_HEAD = do_POST = do_GET

        def log_message(self, *_):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        noted.address = f"http://127.0.0.1:{server.server_port}"
        thread = threading.Thread(target=server.serve_forever, args=(0.02,))
        thread.start()
        yield noted
        server.shutdown()
        thread.join()

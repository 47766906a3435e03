"""The viewer's server: who gets 403, what a page gets, and what one that does not read costs."""

import http.client
import json
import socket
import struct
import time
from contextlib import ExitStack

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from ecs_eco.view.guard import SUBPROTOCOL
from ecs_eco.view.server import PAGES, WAITING, Server


def get(server, path, host=None, method="GET", **headers):
    """Status, headers and body of a GET, or of another method."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.putrequest(method, path, skip_host=True)
    connection.putheader("Host", f"127.0.0.1:{server.port}" if host is None else host)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    decoded = answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read().decode()
    connection.close()
    return decoded


def page(server, shown="ours", origin="ours", **options):
    shown = [SUBPROTOCOL, server.credentials.credential] if shown == "ours" else shown
    origin = f"http://127.0.0.1:{server.port}" if origin == "ours" else origin
    return connect(
        f"ws://127.0.0.1:{server.port}/ws",
        origin=origin,
        subprotocols=shown,
        compression=None,
        max_size=None,
        **options,
    )


def refused(server, **options):
    """The status that a WebSocket is refused with."""
    with pytest.raises(InvalidStatus) as caught, page(server, **options):
        pass
    return caught.value.response.status_code


def until(condition, seconds=30):
    """Wait for something."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)


def receive(ws, kind, most=500):
    """The next message of a kind; frames on the way are acknowledged."""
    for _ in range(most):
        message = ws.recv(60)
        if isinstance(message, bytes):
            ws.send(json.dumps({"kind": "ack", "frame": struct.unpack_from("<I", message, 4)[0]}))
            if kind == "frame":
                return message
        elif json.loads(message)["kind"] == kind:
            return json.loads(message)
    raise AssertionError(f"no {kind} among {most} messages")


def enter(server, authorization, **headers):
    """Status, headers and body of the answer to a page that wants to come in."""
    return get(
        server,
        "/enter",
        method="POST",
        **headers,
        **({} if authorization is None else {"Authorization": authorization}),
    )


def code_of(address):
    place, _, code = address.partition("#code=")
    assert "?" not in place  # a fragment is sent to no server and stands in no referrer
    return code


def test_the_page_itself_holds_no_data_and_is_served_without_a_cookie(served):
    for path, content in (("/", "<p>the page</p>"), ("/page.js", "import { a }")):
        status, headers, body = get(served.server, path)
        assert status == 200
        assert body.startswith(content)
        assert "set-cookie" not in headers
    assert headers["content-type"].startswith("text/javascript")


def test_browsers_are_told_all_modules_of_the_page(served):
    link = get(served.server, "/")[1]["link"]
    assert link == "<other.js>; rel=modulepreload, <page.js>; rel=modulepreload"


def test_small_messages_are_sent_without_delay(served):
    # otherwise each answer waits for the acknowledgement of the one before, often 40 ms
    with socket.create_connection(("127.0.0.1", served.server.port)) as connection:
        until(lambda: connection.getsockname() in served.server._strangers)
        arrived = served.server._strangers[connection.getsockname()].get_extra_info("socket")
        assert arrived.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_code_is_exchanged_for_the_credential_once(served):
    server = served.server
    code = code_of(server.address())
    status, headers, body = enter(server, f"Code {code}")
    assert status == 200
    assert headers["cache-control"] == "no-store"
    assert "set-cookie" not in headers
    credential = json.loads(body)["credential"]
    with page(server, [SUBPROTOCOL, credential]) as ws:
        assert ws.subprotocol == SUBPROTOCOL  # the credential is not repeated
        receive(ws, "hello")
    status, _, body = enter(server, f"Code {code}")
    assert status == 403
    assert credential not in body
    assert enter(server, f"Bearer {credential}")[0] == 200  # a page that is loaded again


@pytest.mark.parametrize(
    "authorization",
    [
        None,
        "",
        "Code",
        "Code ",
        "Bearer ",
        "Code wrong",
        "Bearer wrong",
        "Code {credential}",
        "Bearer {code}",
        "{code}",
        "code {code}",
        "Basic {code}",
        "Code {code} x",
        "Code é",
        "Bearer {credential}=",
    ],
)
def test_nobody_comes_in_with_anything_else(served, authorization):
    server = served.server
    code = code_of(server.address())
    if authorization is not None:
        authorization = authorization.format(code=code, credential=server.credentials.credential)
    status, _, body = enter(server, authorization)
    assert status == 403
    assert server.credentials.credential not in body
    assert server.credentials.is_good(code)


def test_the_credential_of_one_port_opens_no_other(served):
    with Server(served.player) as other:
        credential = json.loads(enter(other, f"Code {code_of(other.address())}")[2])["credential"]
        assert refused(served.server, shown=[SUBPROTOCOL, credential]) == 403
        assert enter(served.server, f"Bearer {credential}")[0] == 403
        assert enter(served.server, f"Code {code_of(other.address())}")[0] == 403
        assert refused(other, shown=[SUBPROTOCOL, served.server.credentials.credential]) == 403


def test_a_code_is_not_taken_by_a_form_or_a_picture_of_another_page(served):
    code = code_of(served.server.address())
    assert get(served.server, f"/enter?code={code}")[0] in (404, 405)
    assert enter(served.server, f"Code {code}", Origin="http://example.org")[0] == 403
    assert enter(served.server, f"Code {code}", Origin="null")[0] == 403
    assert served.server.credentials.is_good(code)


def test_nothing_that_a_page_loads_may_come_from_elsewhere(served):
    policy = get(served.server, "/")[1]["content-security-policy"]
    assert "default-src 'none'" in policy
    places = {word for rule in policy.split(";") for word in rule.split()[1:]}
    ours = {f"ws://{host}:{served.server.port}" for host in ("127.0.0.1", "localhost")}
    assert places <= {"'none'", "'self'", "'unsafe-inline'", "data:", "blob:"} | ours
    assert "'unsafe-inline'" not in policy.split("script-src")[1].split(";")[0]


@pytest.mark.parametrize(
    "origin",
    ["http://example.org", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1", "http://127.0.0.1"],
)
def test_another_origin_is_403_even_with_the_credential(served, origin):
    origin = origin.format(port=served.server.port)
    assert get(served.server, "/", Origin=origin)[0] == 403
    assert enter(served.server, f"Bearer {served.server.credentials.credential}", Origin=origin)[0] == 403
    assert refused(served.server, origin=origin) == 403


@pytest.mark.parametrize(
    "host", ["example.org", "example.org:{port}", "127.0.0.1", "127.0.0.1:1", "[::1]:{port}", ""]
)
def test_another_host_is_403_whatever_its_name_stands_for(served, host):
    host = host.format(port=served.server.port)
    assert get(served.server, "/", host)[0] == 403
    assert enter(served.server, f"Bearer {served.server.credentials.credential}", host=host)[0] == 403


def test_localhost_is_this_machine_too(served):
    assert get(served.server, "/", f"localhost:{served.server.port}")[0] == 200


@pytest.mark.parametrize(
    "path", ["/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/static/../../secret.txt"]
)
def test_no_file_outside_of_the_page_is_served(served, path):
    status, _, body = get(served.server, path)
    assert status in (400, 404)
    assert "secret" not in body


def test_it_listens_on_this_machine_alone(served):
    assert served.server._socket.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize(
    "shown",
    [
        None,
        ["ecs-eco"],
        ["{credential}"],
        ["ecs-eco", "wrong"],
        ["{credential}", "ecs-eco"],
        ["ecs-eco", "{credential}", "more"],
        ["other", "{credential}"],
    ],
)
def test_a_socket_without_the_credential_is_403(served, shown):
    credential = served.server.credentials.credential
    assert (
        refused(served.server, shown=shown and [word.format(credential=credential) for word in shown]) == 403
    )


def test_a_socket_that_does_not_say_where_it_comes_from_is_403(served):
    assert refused(served.server, origin=None) == 403  # a browser says so


def test_a_page_sees_the_world_live_and_steers_it(served):
    with page(served.server) as ws:
        hello = receive(ws, "hello")
        assert [s["name"] for s in hello["species"]] == ["mite"]
        first, second = (struct.unpack_from("<II", receive(ws, "frame"), 4) for _ in range(2))
        assert second[0] > first[0]
        assert second[1] > first[1]
        ws.send('{"kind": "pause"}')
        while receive(ws, "state")["playing"]:
            pass
        ws.send('{"kind": "step", "ticks": 2}')
        now = receive(ws, "state")["tick"]
        while (state := receive(ws, "state"))["tick"] < now + 2:
            assert state["playing"] is False
        assert state["tick"] == now + 2
        ws.send('{"kind": "speed", "value": null}')
        ws.send('{"kind": "play"}')
        while not receive(ws, "state")["playing"]:
            pass


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "7", '{"kind": "join"}', '{"kind": "leave"}', "[" * 5000, '{"kind": NaN}', '{"a": 1}'],
)
def test_nonsense_is_answered_in_words_and_harms_nobody(served, text):
    with page(served.server) as ws:
        ws.send(text)
        assert receive(ws, "said")["level"] == "error"
        receive(ws, "frame")


def test_bytes_or_too_much_at_once_end_that_page_alone(served):
    for nonsense in (b"\x00\x01", "x" * 300_000):
        with page(served.server) as ws:
            ws.send(nonsense)
            with pytest.raises(ConnectionClosed):
                receive(ws, "nothing of this kind")
    with page(served.server) as ws:
        receive(ws, "frame")


def test_pages_have_colours_of_their_own(served):
    with page(served.server) as one, page(served.server) as two:
        one.send('{"kind": "colour", "by": "age"}')
        two.send('{"kind": "select", "uid": 99999999}')
        assert "99999999" in receive(two, "said")["text"]
        receive(one, "frame")


def test_pages_are_not_without_number(served):
    with ExitStack() as crowd:
        for _ in range(PAGES):
            receive(crowd.enter_context(page(served.server)), "hello")
        assert refused(served.server) == 403


def test_a_page_that_stops_reading_waits_with_one_frame_and_the_world_goes_on(served):
    # the second client reads one message, no more
    with page(served.server) as ws, page(served.server, max_queue=1, close_timeout=0.1):
        receive(ws, "frame")
        until(
            lambda: (
                len(served.player._views) == 2 and all(view.seen for view in served.player._views.values())
            )
        )
        tick, made = served.player.source.tick, served.player.frames
        for _ in range(8):
            receive(ws, "frame")
        assert served.player.source.tick > tick + 50
        awaits = sorted(view.awaits for view in served.player._views.values() if view.awaits is not None)
        assert awaits[0] <= made  # the stalled one's, from before
        assert max(client._waiting.qsize() for client in served.server.clients) <= 4


@pytest.mark.slow
def test_a_page_that_asks_and_never_reads_is_let_go(served):
    server, raw = served.server, socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.settimeout(10)
    raw.connect(("127.0.0.1", server.port))
    raw.sendall(
        (
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\n"
            f"Sec-WebSocket-Protocol: {SUBPROTOCOL}, {server.credentials.credential}\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n"
            f"Origin: http://127.0.0.1:{server.port}\r\n\r\n"
        ).encode()
    )
    assert b" 101 " in raw.recv(100)
    until(lambda: len(server.clients) == 1)
    (client,) = server.clients
    text = b'{"kind": "nonsense"}'
    frame = bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text  # a mask of zeros masks nothing
    most = []

    def gone():
        raw.sendall(50 * frame)
        most.append(client._waiting.qsize())
        return client not in server.clients

    until(gone)
    raw.close()
    assert max(most) <= WAITING


def test_a_port_that_is_taken_is_an_error(served):
    with pytest.raises(OSError, match="in use"):
        Server(served.player, served.server.port)

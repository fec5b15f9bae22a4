"""Who may talk to the page: host, origin and token, of requests and of websockets."""

from __future__ import annotations

import asyncio

import pytest

from electrovib.apps.explorer.access import COOKIE, LOOPBACK, AccessControl, is_loopback, new_token

PORT = 8123
TOKEN = "a-secret"


def call(*, kind="http", headers=(), query="", path="/", method="GET", hosts=LOOPBACK, **settings):
    """Send one request, and return whether the application saw it, with the messages that were sent back."""
    seen, sent = [], []

    async def app(scope, receive, send):
        seen.append(scope)
        if scope["type"] == "http":
            await send(
                {"type": "http.response.start", "status": 200, "headers": [(b"x-frame-options", b"ALLOW")]}
            )
            await send({"type": "http.response.body", "body": b"page"})

    async def receive():
        return {"type": f"{kind}.connect"}

    async def send(message):
        sent.append(message)

    scope = {
        "type": kind,
        "method": method,
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), value.encode("latin-1")) for name, value in headers],
    }
    asyncio.run(AccessControl(app, hosts=hosts, port=PORT, **settings)(scope, receive, send))
    return seen, sent


OWN = ("host", f"127.0.0.1:{PORT}")
ORIGIN = ("origin", f"http://127.0.0.1:{PORT}")


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "[::1]", "LocalHost"])
def test_own_names_are_served(name):
    seen, sent = call(headers=[("host", f"{name}:{PORT}")])
    assert seen
    assert sent[0]["status"] == 200


@pytest.mark.parametrize(
    "headers",
    [
        [],
        [("host", "127.0.0.1")],
        [("host", "127.0.0.1:81")],
        [("host", f"attacker.example:{PORT}")],
        [("host", f"127.0.0.1:{PORT}.attacker.example")],
        [OWN, ("host", f"attacker.example:{PORT}")],
        [OWN, ("origin", "http://attacker.example")],
        [OWN, ("origin", "http://127.0.0.1:81")],
        [OWN, ("origin", f"http://localhost:{PORT}")],
        [OWN, ("origin", "null")],
        [OWN, ("origin", f"file://127.0.0.1:{PORT}")],
        [OWN, ORIGIN, ("origin", "http://attacker.example")],
        [OWN, ("origin", f"https://127.0.0.1:{PORT}")],
        [OWN, ("origin", f"http://user@127.0.0.1:{PORT}")],
        [OWN, ("origin", f"http://127.0.0.1:{PORT}@attacker.example")],
        [OWN, ("origin", f"http://127.0.0.1:{PORT}/")],
        [OWN, ("origin", f"http://127.0.0.1:{PORT}?")],
        [OWN, ("origin", f"http://127.0.0.1.:{PORT}")],
        [OWN, ("origin", f"http://127.0.0.1:0{PORT}")],
        [OWN, ("origin", "http://[::1")],
        [OWN, ("origin", "http://\u00bd")],
        [OWN, ("origin", "")],
        [OWN, OWN],
        [("host", f"127.0.0.1.:{PORT}")],
        [("host", f"user@127.0.0.1:{PORT}")],
        [("host", f"127.0.0.1:{PORT} ")],
        [("host", f"0.0.0.0:{PORT}")],
        [("host", f"127.1:{PORT}")],
        [("host", f"attacker.example:{PORT}"), ("x-forwarded-host", f"127.0.0.1:{PORT}")],
    ],
)
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_everything_else_is_refused_with_a_sentence(headers, kind):
    seen, sent = call(kind=kind, headers=headers)
    assert not seen
    if kind == "http":
        assert sent[0]["status"] == 403
        assert sent[1]["body"].endswith(b".\n")
    else:
        assert sent == [{"type": "websocket.close", "code": 1008, "reason": sent[0]["reason"]}]


@pytest.mark.parametrize(
    ("site", "mode", "target", "is_served"),
    [
        ("same-origin", "cors", "empty", True),
        ("none", "navigate", "document", True),
        ("cross-site", "navigate", "document", True),
        ("cross-site", "navigate", "iframe", False),
        ("cross-site", "no-cors", "image", False),
        ("same-site", "no-cors", "script", False),
        ("cross-site", "navigate", None, False),
    ],
)
def test_another_site_may_link_but_not_load(site, mode, target, is_served):
    fetch = {"sec-fetch-site": site, "sec-fetch-mode": mode, "sec-fetch-dest": target}
    headers = [OWN, *((name, value) for name, value in fetch.items() if value)]
    assert bool(call(headers=headers)[0]) is is_served
    assert bool(call(headers=headers, method="POST")[0]) is (site in ("same-origin", "none"))


def test_headers_of_proxies_reach_nothing():
    foreign = ["x-forwarded-for", "X-Forwarded-Prefix", "forwarded", "x-real-ip", "x-original-url"]
    headers = [OWN, *((name, "evil") for name in foreign), ("accept", "a")]
    (scope,) = call(headers=headers)[0]
    assert [name for name, _ in scope["headers"]] == [b"host", b"accept"]


def test_every_numeric_address_of_a_server_on_all_interfaces():
    for host, is_served in (
        (f"192.168.1.7:{PORT}", True),
        (f"[fe80::1]:{PORT}", True),
        (f"192.168.1.7:{PORT + 1}", False),
        (f"fe80::1:{PORT}", False),
        (f"[192.168.1.7]:{PORT}", False),
        (f"attacker.example:{PORT}", False),
        ("192.168.1.7", False),
    ):
        assert bool(call(headers=[("host", host)], any_address=True)[0]) is is_served
        assert not call(headers=[("host", host)])[0]


def test_two_servers_in_one_browser_keep_their_tokens():
    cookies = ("cookie", f'x="a b; y={{"z": 1}}; {COOKIE}-1=another; {COOKIE}-{PORT}={TOKEN}')
    assert call(headers=[OWN, cookies], token=TOKEN)[0]


def test_a_websocket_needs_an_origin():
    assert not call(kind="websocket", headers=[OWN])[0]
    assert call(kind="websocket", headers=[OWN, ORIGIN])[0]
    assert call(headers=[OWN])[0]


def test_headers_of_every_answer():
    for headers in ([OWN], []):
        sent = call(headers=headers)[1]
        found = dict(sent[0]["headers"])
        assert found[b"referrer-policy"] == b"no-referrer"
        assert found[b"x-frame-options"] == b"DENY"
        assert b"frame-ancestors 'none'" in found[b"content-security-policy"]
        assert [name for name, _ in sent[0]["headers"]].count(b"x-frame-options") == 1


def test_a_token_moves_from_the_address_into_a_cookie():
    seen, sent = call(headers=[OWN], query=f"preset=a%2Fb&token={TOKEN}&set=x%3D1", token=TOKEN)
    assert not seen
    headers = dict(sent[0]["headers"])
    assert sent[0]["status"] == 303
    assert headers[b"location"] == b"/?preset=a%2Fb&set=x%3D1"
    assert headers[b"set-cookie"] == f"{COOKIE}-{PORT}={TOKEN}; Path=/; HttpOnly; SameSite=Strict".encode()
    assert headers[b"referrer-policy"] == b"no-referrer"
    cookie = ("cookie", f"other=1; {COOKIE}-{PORT}={TOKEN}")
    assert call(headers=[OWN, cookie], token=TOKEN)[0]
    assert call(kind="websocket", headers=[OWN, ORIGIN, cookie], token=TOKEN)[0]


def test_the_address_to_which_it_leads_stays_on_this_server():
    sent = call(headers=[OWN], path="//attacker.example/x", query=f"token={TOKEN}", token=TOKEN)[1]
    assert dict(sent[0]["headers"])[b"location"] == b"/attacker.example/x"


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    ("query", "cookie"),
    [
        ("", ""),
        ("token=", ""),
        ("token=a-secre", ""),
        ("token=A-SECRET", ""),
        ("", f"{COOKIE}-{PORT}=wrong"),
        ("", f"{COOKIE}-{PORT}="),
        ("", f"{COOKIE}-81=a-secret"),
        ("", f"{COOKIE}=a-secret"),
        ("token=" + "a" * 60_000, ""),
        ("token=%ff%fe%00", ""),
        ("token=ä", f"{COOKIE}-{PORT}=ä"),
        ("", "x=a-secret"),
    ],
)
def test_without_its_token_nothing_is_served(kind, query, cookie):
    headers = [OWN, ORIGIN] + ([("cookie", cookie)] if cookie else [])
    assert not call(kind=kind, headers=headers, query=query, token=TOKEN)[0]


def test_a_websocket_takes_no_token_from_the_address():
    assert not call(kind="websocket", headers=[OWN, ORIGIN], query=f"token={TOKEN}", token=TOKEN)[0]


def test_other_scopes_reach_the_application():
    seen = []

    async def app(scope, receive, send):
        seen.append(scope["type"])

    asyncio.run(AccessControl(app, hosts=(), port=1)({"type": "lifespan"}, None, None))
    assert seen == ["lifespan"]


def test_tokens_and_loopback():
    assert len({new_token() for _ in range(20)}) == 20
    assert len(new_token()) >= 43  # 256 bits
    assert [is_loopback(each) for each in ("127.0.0.1", "localhost", "::1", "0.0.0.0", "192.168.1.7")] == [
        True
    ] * 3 + [False] * 2

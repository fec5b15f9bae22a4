"""Who may talk to the page: host and origin, of requests and of websockets."""

import asyncio

import pytest

from electrovib.apps.explorer.access import AccessControl

PORT = 8123
OWN = ("host", f"127.0.0.1:{PORT}")
ORIGIN = ("origin", f"http://127.0.0.1:{PORT}")


def call(*, kind="http", headers=(), query="", path="/", method="GET"):
    """Send one request, and return whether the application saw it, with the messages that were sent back."""
    seen, sent = [], []

    async def app(scope, receive, send):
        seen.append(scope)
        if scope["type"] == "http":
            own = [(b"x-frame-options", b"ALLOW")]
            await send({"type": "http.response.start", "status": 200, "headers": own})
            await send({"type": "http.response.body", "body": b"page"})

    async def receive():
        return {"type": f"{kind}.connect"}

    async def send(message):
        sent.append(message)

    found = [(name.encode(), value.encode("latin-1")) for name, value in headers]
    scope = {"type": kind, "method": method, "path": path, "query_string": query.encode(), "headers": found}
    asyncio.run(AccessControl(app, port=PORT)(scope, receive, send))
    return seen, sent


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "[::1]", "LocalHost"])
def test_own_names_are_served(name):
    seen, sent = call(headers=[("host", f"{name}:{PORT}")])
    assert seen
    assert sent[0]["status"] == 200


def test_a_server_may_leave_the_names_of_headers_as_they_were_sent():
    written = [("Host", OWN[1]), ("Origin", ORIGIN[1])]
    assert call(kind="websocket", headers=written)[0]
    assert not call(kind="websocket", headers=[*written, ("Sec-Fetch-Site", "cross-site")])[0]


HOSTS = f"""
127.0.0.1
127.0.0.1:81
attacker.example:{PORT}
127.0.0.1:{PORT}.attacker.example
127.0.0.1.:{PORT}
user@127.0.0.1:{PORT}
0.0.0.0:{PORT}
127.1:{PORT}
192.168.1.7:{PORT}
[fe80::1]:{PORT}
"""
ORIGINS = f"""
http://attacker.example
http://127.0.0.1:81
http://localhost:{PORT}
null
file://127.0.0.1:{PORT}
https://127.0.0.1:{PORT}
http://user@127.0.0.1:{PORT}
http://127.0.0.1:{PORT}@attacker.example
http://127.0.0.1:{PORT}/
http://127.0.0.1:{PORT}?
http://127.0.0.1.:{PORT}
http://127.0.0.1:0{PORT}
http://[::1
http://\u00bd
"""
REFUSED = [
    [],
    *([("host", name)] for name in [*HOSTS.split(), f"127.0.0.1:{PORT} "]),
    *([OWN, ("origin", name)] for name in [*ORIGINS.split(), ""]),
    [OWN, OWN],
    [OWN, ("host", f"attacker.example:{PORT}")],
    [OWN, ORIGIN, ("origin", "http://attacker.example")],
    [("host", f"attacker.example:{PORT}"), ("x-forwarded-host", f"127.0.0.1:{PORT}")],
]


@pytest.mark.parametrize("headers", REFUSED)
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


def test_a_websocket_needs_an_origin_and_other_scopes_reach_the_application():
    assert not call(kind="websocket", headers=[OWN])[0]
    assert call(kind="websocket", headers=[OWN, ORIGIN])[0]
    assert call(headers=[OWN])[0]
    assert call(kind="lifespan")[0]


def test_headers_of_every_answer():
    for headers in ([OWN], []):
        sent = call(headers=headers)[1]
        found = dict(sent[0]["headers"])
        assert found[b"referrer-policy"] == b"no-referrer"
        assert found[b"x-frame-options"] == b"DENY"
        assert b"frame-ancestors 'none'" in found[b"content-security-policy"]
        assert [name for name, _ in sent[0]["headers"]].count(b"x-frame-options") == 1

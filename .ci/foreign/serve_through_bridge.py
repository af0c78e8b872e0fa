"""The page of a ring behind a gateway that others wrote (bridge.py): over TCP and on a serial line.

    serve_through_bridge.py target/release/encoring

It shows positions, reads a value through the gateway, and says when the gateway is gone.
"""

import json
import os
import subprocess
import sys
import urllib.request

ENCORING = os.path.abspath(sys.argv[1])
BRIDGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bridge.py")
AT = ["--at", "0-2", "--model", "la-66,ce-100-m,ce-65-m"]


def first_words(child, count):
    return [child.stdout.readline().split()[1] for _ in range(count)]


class Page:
    def __init__(self, bus):
        command = [ENCORING, "serve", "--bus", bus, *AT, "--web", "0", "--allow-control", "--format", "json"]
        self.program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.base = "http://" + json.loads(self.program.stdout.readline())["web"]

    def ask(self, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request) as answer:
            return json.load(answer)

    def once(self, holds):
        """The ring, as soon as it is so."""
        while True:
            ring = self.ask("/api/state")["ring"]
            if holds(ring):
                return ring


def check(*options):
    bridge = subprocess.Popen([sys.executable, BRIDGE, "--start", ENCORING, *options], stdout=subprocess.PIPE, text=True)
    page = None
    try:
        bus, _ = first_words(bridge, 2)
        page = Page(bus)
        shown = lambda ring: all(device["verdict"] == "unchecked" for device in ring["devices"].values())
        ring = page.once(shown)
        assert ring["link"]["up"], ring["link"]
        reply = page.ask("/api/command", {"verb": "service", "position": 2, "service": 2})["reply"]
        assert reply["data"] == 0xFFFFFF and not reply["error"], reply
        bridge.terminate()
        assert bridge.wait() == 0, "the bridge ends with 0 on SIGTERM"
        ring = page.once(lambda ring: ring["link"]["up"] is False)
        assert ring["devices"]["2"]["value"] is None, ring["devices"]["2"]
        page.program.terminate()
        assert page.program.wait() == 0, "serve ends with 0 on SIGTERM"
    finally:
        for child in [bridge, page and page.program]:
            if child and child.poll() is None:
                child.kill()
    print(f"serve {' '.join(options) or 'tcp'}: all is well")


check()
check("--rtu", "--order", "low-first")

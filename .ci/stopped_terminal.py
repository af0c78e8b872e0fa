"""On a terminal that is stopped (Ctrl-S) a simulation answers, a log grows, a live view goes on polling, and everything
ends on a signal.

Usage: stopped_terminal.py ENCORING
"""

import os
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import threading
import time

program = os.path.abspath(sys.argv[1])
# What a command has after the signal: a second for its reader, and what the machine needs.
END_S = 5


def start(*arguments):
    """A command whose terminal is stopped before it prints anything."""
    master, slave = pty.openpty()
    termios.tcsetwinsize(slave, (24, 100))
    termios.tcflow(slave, termios.TCOOFF)
    command = subprocess.Popen([program, *arguments], stdin=slave, stdout=slave, stderr=slave, start_new_session=True)
    return command, (master, slave)


def end(name, command, terminal, code):
    assert command.poll() is None, f"{name}: it has ended with {command.returncode}"
    command.send_signal(signal.SIGTERM)
    ended = command.wait(END_S)
    assert ended == code, f"{name}: {ended}, not {code}"
    for side in terminal:
        os.close(side)
    print(f"{name}: ended with {ended}")


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def connect(port):
    for _ in range(100):
        try:
            return socket.create_connection(("127.0.0.1", port), 5)
        except ConnectionRefusedError:
            time.sleep(0.05)
    raise AssertionError(f"nobody listens on {port}")


def first_in_word(client):
    client.sendall(bytes.fromhex("000100000006 01 04 0000 0002"))
    answer = client.recv(64)
    assert len(answer) == 13, answer
    return answer[9:]


def size(file):
    return os.stat(file).st_size if os.path.exists(file) else 0


def grows(file):
    before = size(file)
    for _ in range(100):
        time.sleep(0.1)
        if size(file) > before > 0:
            return True
        before = before or size(file)
    return False


class Gateway:
    """A gateway whose words differ from poll to poll, and which counts its requests."""

    def __init__(self):
        self.requests = 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        client, _ = self.listener.accept()
        while request := client.recv(12):
            self.requests += 1
            count = 2 * request[11]
            word = (self.requests % 10_000).to_bytes(4) * (count // 4)
            client.sendall(request[:4] + (3 + count).to_bytes(2) + request[6:8] + bytes([count]) + word)


os.chdir(tempfile.mkdtemp())

port = free_port()
sim, terminal = start("sim", "--modbus", str(port), "--for", "1h", "--counters", "0.01")
client = connect(port)
words = set()
until = time.monotonic() + 2
while time.monotonic() < until:
    words.add(first_in_word(client))
assert len(words) > 10, "the ring stands"
end("sim --for", sim, terminal, 0)

log, terminal = start("log", "a.csv", "--bus", "sim", "--every", "1ms")
assert grows("a.csv") and grows("a.csv"), "the log stands"
end("log", log, terminal, 0)

# The notes of a link that never comes up.
log, terminal = start("log", "b.csv", "--bus", f"modbus-tcp://127.0.0.1:{free_port()}", "--at", "0", "--model", "la-66")
time.sleep(1)
end("log of a dead gateway", log, terminal, 3)

for name, more in [("live watch", []), ("watch", ["--format", "json"])]:
    watch, terminal = start("watch", "--bus", "sim", *more)
    time.sleep(1)
    end(name, watch, terminal, 0)

# What it draws fills the terminal long before.
gateway = Gateway()
where = f"modbus-tcp://127.0.0.1:{gateway.port}"
watch, terminal = start("watch", "--bus", where, "--at", "0-7", "--model", "ce-65-m")
until = time.monotonic() + 20
while gateway.requests < 400 and time.monotonic() < until:
    time.sleep(0.1)
assert gateway.requests >= 400, f"the live view has asked {gateway.requests} times and waits for its terminal"
end("live view of a gateway", watch, terminal, 0)

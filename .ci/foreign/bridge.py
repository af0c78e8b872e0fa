"""A Modbus gateway that others wrote, in front of a simulated ring: a pymodbus server that mirrors `encoring sim`.

It stands between the client side of encoring and the simulator, so that neither meets only itself:

    encoring read --bus ADDRESS  <->  bridge.py (pymodbus server)  <->  (pymodbus client)  encoring sim

Start it with pymodbus 3.16 (`pip install pymodbus pyserial`), and socat for `--rtu`:

    bridge.py --start target/release/encoring              # starts `encoring sim` itself, and ends it
    bridge.py --start target/release/encoring -- --scenario x.toml --state /tmp/state     # with options of sim
    bridge.py --sim 127.0.0.1:5020                         # a simulator that runs already (high word first)

The first line on stdout is the address that reaches the ring through it:

    bus modbus-tcp://127.0.0.1:40123?order=low-first
    bus modbus-rtu:/tmp/bridge-x/line?baud=19200&parity=none

With --start, the second is where the simulator itself listens: `sim 127.0.0.1:PORT`, and if it was told to have a
control port, the third `control 127.0.0.1:PORT`. More lines of the simulator's are
passed on behind `sim: `. It ends with 0 on SIGTERM and SIGINT, and with 1 if the simulator goes away.

Like a controller it moves words in scans (--scan-ms): OUT registers that were written go to the ring with the next scan,
both halves together as they stand then, and IN registers are as of the last. Registers that it does not have are
exception 02.

    --port N                 TCP port; 0, the default, takes a free one
    --rtu                    a pseudo terminal instead of TCP
    --unit N                 unit identifier, 1; others are exception 0Bh on TCP and not answered on a serial line
    --order high-first|low-first
    --out holding:N  --in holding:N|input:N
    --layout inline          as an Inline coupler: 1400 the number of modules, 1401.. length and ident codes, 8000.. IN
                             data of all modules, then OUT data; function 23 is exception 01
    --modules 0101,0233,..   modules of that coupler, in hex; each 0233 is the next encoder of the ring
    --scan-ms N              the time from one scan to the next, 5

Misbehaviour, by the number of the answer, so that a run can be repeated (0, the default, is never):

    --delay-every N --delay-ms MS   answers come late; on a serial line those after it wait, as a unit answers in order
    --drop-every N                  do not come
    --double-every N                come twice
    --short-every N                 are a register short
    --busy-every N                  are exception 06
    --hang-up-every N               are cut in the middle, and the connection closed

    --faults                        the same at single answers, told on stdin: a line like `drop 17` spoils the 17th
                                    answer from now on so, `sound` spoils none any more; each line is answered with
                                    `faults N` on stdout, N answers having been sent so far
"""

import argparse
import asyncio
import contextlib
import json
import logging
import os
import signal
import sys
import tempfile

from pymodbus import FramerType, pymodbus_apply_logging_config
from pymodbus.client import AsyncModbusTcpClient
from pymodbus.constants import ExcCodes
from pymodbus.pdu import ExceptionResponse
from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.server.requesthandler import ServerRequestHandler
from pymodbus.simulator import DataType, SimData, SimDevice

DIRECTORY, DATA = 1400, 8000
LENGTHS = {
    0x00: 0, 0x01: 1, 0x02: 2, 0x03: 3, 0x04: 4, 0x05: 5, 0x06: 8, 0x07: 9, 0x08: 1, 0x09: 1, 0x0B: 2, 0x0D: 1,
    0x0E: 6, 0x0F: 7, 0x11: 26, 0x12: 16, 0x13: 24, 0x14: 32, 0x15: 10, 0x16: 12, 0x17: 14,
}  # fmt: skip
ENCODER = 0x0233
FAULTS = ["delay", "drop", "double", "short", "busy", "hang_up"]
OUT_ONLY, IN_ONLY = {0x01, 0x31}, {0x02, 0x32}


class Ring:
    """The simulator's words, as of the last scan."""

    def __init__(self, client):
        self.client = client
        self.out, self.input, self.written = [], [], set()

    async def begin(self):
        """Finds out how many encoders there are and takes over what stands in the OUT words."""
        while not (answer := await self.client.read_holding_registers(2 * len(self.out), count=2)).isError():
            self.out.append(answer.registers)
        assert self.out, "the simulator has no encoders"
        await self.scan()

    async def scan(self):
        written, self.written = self.written, set()
        for position in sorted(written):
            answer = await self.client.write_registers(2 * position, list(self.out[position]))
            assert not answer.isError(), answer
        registers = []
        while len(registers) < 2 * len(self.out):
            count = min(124, 2 * len(self.out) - len(registers))
            answer = await self.client.read_input_registers(len(registers), count=count)
            assert not answer.isError(), answer
            registers += answer.registers
        self.input = [registers[k : k + 2] for k in range(0, len(registers), 2)]


class Context:
    """The gateway's registers; what pymodbus's server asks for them."""

    def __init__(self, ring, options):
        self.ring, self.unit, self.serial = ring, options.unit, options.rtu
        self.halves = [0, 1] if options.order == "high-first" else [1, 0]
        # (table, register) -> ("in" or "out", position, half), or a number that stands there
        self.map, self.refused = {}, set()
        if options.layout == "plain":
            for what, (table, first) in [("out", options.out), ("in", options.input)]:
                for position in range(len(ring.out)):
                    self.place(table, first + 2 * position, what, position)
        else:
            self.refused = {23}
            self.inline(options.modules or [ENCODER] * len(ring.out))

    def place(self, table, register, what, position):
        for offset, half in enumerate(self.halves):
            self.map[table, register + offset] = (what, position, half)

    def inline(self, modules):
        assert modules.count(ENCODER) == len(self.ring.out), f"the ring has {len(self.ring.out)} encoders"
        for register, value in enumerate([len(modules), *modules], DIRECTORY):
            self.map["holding", register] = value
        register = DATA
        for what, without in [("in", OUT_ONLY), ("out", IN_ONLY)]:
            encoders = iter(range(len(self.ring.out)))
            for module in modules:
                if module == ENCODER:
                    self.place("holding", register, what, next(encoders))
                    register += 2
                elif module & 0xFF not in without:
                    for _ in range(LENGTHS[module >> 8]):
                        self.map["holding", register] = 0xA5A5
                        register += 1

    def device_ids(self):
        return [self.unit]

    def find(self, unit, function, address, count):
        if unit != self.unit:
            return ExcCodes.GATEWAY_NO_RESPONSE
        if function in self.refused or function not in (3, 4, 6, 16, 23):
            return ExcCodes.ILLEGAL_FUNCTION
        table = "input" if function == 4 else "holding"
        cells = [self.map.get((table, register)) for register in range(address, address + count)]
        return ExcCodes.ILLEGAL_ADDRESS if None in cells else cells

    async def async_getValues(self, unit, function, address, count=1):
        cells = self.find(unit, function, address, count)
        return cells if isinstance(cells, ExcCodes) else [self.value(cell) for cell in cells]

    def value(self, cell):
        if isinstance(cell, int):
            return cell
        what, position, half = cell
        return (self.ring.out if what == "out" else self.ring.input)[position][half]

    async def async_setValues(self, unit, function, address, values):
        cells = self.find(unit, function, address, len(values))
        if isinstance(cells, ExcCodes):
            return cells
        if any(isinstance(cell, int) or cell[0] == "in" for cell in cells):
            return ExcCodes.ILLEGAL_ADDRESS
        for (_, position, half), value in zip(cells, values, strict=True):
            self.ring.out[position][half] = value
            self.ring.written.add(position)
        return None


class Handler(ServerRequestHandler):
    """Answers, or misbehaves."""

    def pdu_send(self, pdu, addr=None):
        server, options = self.server, self.server.options
        if server.context.serial and pdu.dev_id != server.context.unit:
            return
        server.answers += 1

        def due(name):
            every = getattr(options, f"{name}_every")
            return every and server.answers % every == 0 or server.faults.get(server.answers) == name

        if due("busy"):
            busy = ExceptionResponse(pdu.function_code & 0x7F, ExcCodes.DEVICE_BUSY)
            busy.dev_id, busy.transaction_id = pdu.dev_id, pdu.transaction_id
            pdu = busy
        if due("short") and getattr(pdu, "registers", None) and not pdu.isError():
            pdu.registers = pdu.registers[:-1]
        packet = self.framer.buildFrame(pdu)
        if due("drop"):
            return
        if due("hang_up"):
            self.send(packet[: len(packet) // 2])
            if not server.context.serial:
                self.close()
            return
        if due("double"):
            packet += packet
        now = self.loop.time()
        at = now + options.delay_ms / 1000 if due("delay") else now
        if server.context.serial:
            at = server.free_at = max(at, server.free_at + 1e-6)
        if at > now:
            self.loop.call_at(at, self.send_if_there, packet)
        else:
            self.send(packet)

    def send_if_there(self, packet):
        if self.transport and not self.transport.is_closing():
            self.send(packet)


class Misbehaving:
    """What both servers have besides pymodbus's."""

    def prepare(self, context, options):
        self.context, self.options, self.answers, self.free_at = context, options, 0, 0.0
        # What is wrong with an answer, by its number.
        self.faults = {}
        return self

    async def take_faults(self):
        """Takes faults of single answers from stdin."""
        lines = asyncio.StreamReader()
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
        while line := (await lines.readline()).decode().split():
            if line == ["sound"]:
                self.faults.clear()
            else:
                kind, number = line
                assert kind in FAULTS, kind
                self.faults[self.answers + int(number)] = kind
            print("faults", self.answers, flush=True)

    def callback_new_connection(self):
        return Handler(self, self.trace_packet, self.trace_pdu, self.trace_connect)


class TcpServer(Misbehaving, ModbusTcpServer):
    pass


class RtuServer(Misbehaving, ModbusSerialServer):
    pass


def place(text):
    table, _, first = text.partition(":")
    if table not in ("holding", "input") or not first.isdigit():
        raise argparse.ArgumentTypeError(f"{text!r}; it must be holding:N or input:N")
    return table, int(first)


def arguments():
    parser = argparse.ArgumentParser(usage=__doc__)
    simulator = parser.add_mutually_exclusive_group(required=True)
    simulator.add_argument("--start")
    simulator.add_argument("--sim")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--rtu", action="store_true")
    parser.add_argument("--unit", type=int, default=1)
    parser.add_argument("--order", choices=["high-first", "low-first"], default="high-first")
    parser.add_argument("--out", type=place, default=("holding", 0))
    parser.add_argument("--in", dest="input", type=place, default=("input", 0))
    parser.add_argument("--layout", choices=["plain", "inline"], default="plain")
    parser.add_argument("--modules", type=lambda text: [int(module, 16) for module in text.split(",")])
    parser.add_argument("--scan-ms", type=float, default=5.0)
    for name in FAULTS:
        parser.add_argument(f"--{name.replace('_', '-')}-every", type=int, default=0)
    parser.add_argument("--faults", action="store_true")
    parser.add_argument("--delay-ms", type=float, default=1500.0)
    parser.add_argument("rest", nargs="*", help="options of encoring sim, behind --")
    return parser.parse_args()


def bus_address(way, options):
    given = list(way[1])
    if options.unit != 1:
        given.append(f"unit={options.unit}")
    if options.layout == "inline":
        given.append("layout=inline")
    elif (options.out, options.input) != (("holding", 0), ("input", 0)):
        given += [f"out={':'.join(map(str, options.out))}", f"in={':'.join(map(str, options.input))}"]
    if options.order != "high-first":
        given.append(f"order={options.order}")
    return way[0] + ("?" + "&".join(given) if given else "")


@contextlib.asynccontextmanager
async def process(*command, **streams):
    child = await asyncio.create_subprocess_exec(*command, **streams)
    try:
        yield child
    finally:
        if child.returncode is None:
            child.terminate()
        await child.wait()


async def pass_on(stream):
    while line := await stream.readline():
        print("sim:", line.decode().rstrip(), flush=True)


async def main(options):
    # It tells of every connection that a client drops, and of what went before.
    pymodbus_apply_logging_config(logging.CRITICAL)
    ended = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    async with contextlib.AsyncExitStack() as stack:
        if options.start:
            command = [options.start, "sim", "--web", "off", "--modbus", "127.0.0.1:0", "--format", "json", *options.rest]
            sim = await stack.enter_async_context(process(*command, stdout=asyncio.subprocess.PIPE))
            listening = json.loads(await sim.stdout.readline())
            options.sim = listening["modbus"]
            stack.callback(asyncio.create_task(pass_on(sim.stdout)).cancel)
        host, port = options.sim.rsplit(":", 1)
        client = AsyncModbusTcpClient(host, port=int(port))
        assert await client.connect(), options.sim
        stack.callback(client.close)
        ring = Ring(client)
        await ring.begin()

        # pymodbus wants a device of its own; the context takes its place.
        unused = SimDevice(options.unit, simdata=[SimData(0, values=0, datatype=DataType.REGISTERS)])
        context = Context(ring, options)
        if options.rtu:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="bridge-"))
            ends = [os.path.join(folder, name) for name in ("gateway", "line")]
            pair = [f"pty,raw,echo=0,link={end}" for end in ends]
            await stack.enter_async_context(process("socat", *pair))
            while not all(map(os.path.exists, ends)):
                await asyncio.sleep(0.01)
            server = RtuServer(unused, framer=FramerType.RTU, port=ends[0], baudrate=19200).prepare(context, options)
            await server.serve_forever(background=True)
            way = f"modbus-rtu:{ends[1]}", ["baud=19200", "parity=none"]
        else:
            server = TcpServer(unused, address=("127.0.0.1", options.port)).prepare(context, options)
            await server.serve_forever(background=True)
            way = "modbus-tcp://127.0.0.1:%d" % server.transport.sockets[0].getsockname()[1], []
        print("bus", bus_address(way, options), flush=True)
        if options.faults:
            stack.callback(asyncio.create_task(server.take_faults()).cancel)
        if options.start:
            print("sim", options.sim, flush=True)
            if "control" in listening:
                print("control", listening["control"], flush=True)
        while not ended.is_set():
            try:
                await ring.scan()
            except Exception as problem:  # whatever it was, there is no ring any more
                print(f"the simulator is gone: {problem}", file=sys.stderr)
                return 1
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(ended.wait(), options.scan_ms / 1000)
        await server.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(asyncio.run(main(arguments())))

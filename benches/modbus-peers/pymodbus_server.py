"""pymodbus as a server: prints its address, serves 1000 holding and 1000 input registers, ends by itself after five
minutes."""

import asyncio
import signal

from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

REGISTERS = 1000
LIFETIME_S = 300


def registers():
    return [SimData(address=0, values=[i * 37 % 65536 for i in range(REGISTERS)], datatype=DataType.REGISTERS)]


def bits():
    return [SimData(address=0, values=[False], datatype=DataType.BITS)]


async def main():
    signal.alarm(LIFETIME_S)
    device = SimDevice(1, simdata=(bits(), bits(), registers(), registers()))
    server = ModbusTcpServer(device, address=("127.0.0.1", 0))
    await server.listen()
    port = server.transport.sockets[0].getsockname()[1]
    print(f"127.0.0.1:{port}", flush=True)
    await asyncio.get_running_loop().create_future()


asyncio.run(main())

"""A UDP relay between a vehicle and a client that loses datagrams, by a seed."""

import contextlib
import random
import select
import socket
import threading


class LossyRelay:
    """Listens where the vehicle sends to, and passes on to the client at `client_port` and back."""

    def __init__(self, vehicle_port, client_port, loss, seed=1):
        self.lost_n = self.passed_n = 0
        self._loss, self._random = loss, random.Random(seed)
        self._vehicle = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._vehicle.bind(("127.0.0.1", vehicle_port))
        self._client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._client.bind(("127.0.0.1", 0))
        self._client_address, self._vehicle_address = ("127.0.0.1", client_port), None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._stop.is_set():
            for ready in select.select([self._vehicle, self._client], [], [], 0.1)[0]:
                with contextlib.suppress(OSError):  # nobody there yet
                    data, address = ready.recvfrom(65536)
                    if ready is self._vehicle:
                        self._vehicle_address = address
                    self._pass(ready, data)

    def _pass(self, source, data):
        if self._random.random() < self._loss:
            self.lost_n += 1
            return
        self.passed_n += 1
        if source is self._vehicle:
            self._client.sendto(data, self._client_address)
        elif self._vehicle_address is not None:
            self._vehicle.sendto(data, self._vehicle_address)

    def close(self):
        self._stop.set()
        self._thread.join()
        self._vehicle.close()
        self._client.close()


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]

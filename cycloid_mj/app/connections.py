"""Limits of the page's HTTP connections: their number, and how long each may keep the server waiting."""

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from cycloid_mj.app.limits import LIMITS

TIMEOUT_MESSAGE = "The request did not arrive completely in time.\n"


class LimitedConnection(H11Protocol):
    """An HTTP/1.1 connection of uvicorn with a deadline for each request and a limit of the number of connections.

    Public methods override those of `H11Protocol`, which uvicorn and asyncio call.

    A new connection is never refused: when there are too many, the one that has waited longest for its request is
    closed. Connections whose request is being answered do not count as waiting.
    """

    limits = LIMITS

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._deadline_timer: asyncio.TimerHandle | None = None
        self._stall_timer: asyncio.TimerHandle | None = None
        self._waiting_since: float | None = None
        self._idle, self._refused = True, False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start to wait for a request; close another waiting connection if there are too many."""
        super().connection_made(transport)
        if len(self.connections) > self.limits.connections:
            self._close_longest_waiting()
        self._wait_for_request()

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the timers."""
        self._stop_waiting()
        self._cancel_stall()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse data that a client of the page's server sent, and start the deadline of a request at its first byte.

        Data after a refusal is ignored.
        """
        if self._refused:
            return
        if self._idle and self._waiting_since is not None:
            self._wait_for_request()
            self._idle = False
        super().data_received(data)

    def handle_events(self) -> None:
        """Handle what was parsed; a request that is complete is no longer waited for."""
        super().handle_events()
        if self.cycle is not None and not self.cycle.more_body and not self.cycle.response_complete:
            self._stop_waiting()

    def on_response_complete(self) -> None:
        """Wait for the next request of the connection."""
        self._wait_for_request()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Answer a malformed request, if there is no other response under way."""
        self._refuse(400, f"{msg}\n")

    def pause_writing(self) -> None:
        """Pause the response, and watch whether the client reads on."""
        super().pause_writing()
        self._watch_progress(self.transport.get_write_buffer_size())

    def resume_writing(self) -> None:
        """Go on writing."""
        self._cancel_stall()
        super().resume_writing()

    def _wait_for_request(self) -> None:
        self._stop_waiting()
        self._idle, self._waiting_since = True, self.loop.time()
        self._deadline_timer = self.loop.call_later(self.limits.timeout_s, self._expire)

    def _stop_waiting(self) -> None:
        self._waiting_since = None
        if self._deadline_timer is not None:
            self._deadline_timer.cancel()
            self._deadline_timer = None

    def _expire(self) -> None:
        """Close a connection whose request did not arrive in time; report that if it had begun."""
        if self._idle:
            self.transport.close()
        else:
            self._refuse(408, TIMEOUT_MESSAGE)

    def _refuse(self, status: int, text: str) -> None:
        """Send a response with an HTTP status and a `text`, and close the connection.

        Nothing is sent if a response has begun, or if the connection is closing already. The application is notified of
        the disconnection, so that it stops writing.
        """
        headers = [("Content-Type", "text/plain; charset=utf-8"), ("Connection", "close")]
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE) and not self.transport.is_closing():
            response = h11.Response(status_code=status, headers=headers)
            for event in (response, h11.Data(data=text.encode("ascii", "replace")), h11.EndOfMessage()):
                self.transport.write(self.conn.send(event) or b"")
        if self.cycle is not None:  # the application must not write into a connection that is closed
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        self._close_after_client()

    def _close_after_client(self) -> None:
        """Stop sending; close the connection when the client closes its side, or after `close_delay_s` at the latest.

        Until then, received data is discarded. If there are too many connections, this one is closed first.
        """
        self._stop_waiting()
        if self.transport.is_closing():
            return
        self._refused, self._waiting_since = True, 0.0  # 0: it counts as the connection that has waited longest
        self.transport.write_eof()
        self.transport.resume_reading()
        self._deadline_timer = self.loop.call_later(self.limits.close_delay_s, self.transport.close)

    def _close_longest_waiting(self) -> None:
        """Abort the connection that has waited longest for a complete request; do nothing if none waits."""
        start_times = {
            connection: connection._waiting_since
            for connection in self.connections
            if isinstance(connection, LimitedConnection)
        }
        waiting = {connection: start for connection, start in start_times.items() if start is not None}
        if waiting:
            oldest = min(waiting, key=waiting.__getitem__)
            oldest._stop_waiting()  # else it would be chosen again before the event loop has removed it
            oldest.transport.abort()

    def _watch_progress(self, unsent: int) -> None:
        """Abort the connection if the client takes none of the `unsent` bytes of a response within the time-out."""

        def abort_if_stalled() -> None:
            remaining_bytes = self.transport.get_write_buffer_size()
            if remaining_bytes < unsent:
                self._watch_progress(remaining_bytes)
            else:
                self.transport.abort()

        self._cancel_stall()
        self._stall_timer = self.loop.call_later(self.limits.timeout_s, abort_if_stalled)

    def _cancel_stall(self) -> None:
        if self._stall_timer is not None:
            self._stall_timer.cancel()
            self._stall_timer = None

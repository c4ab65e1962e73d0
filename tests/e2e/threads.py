"""One thread of another process stopped as by SIGSTOP, while the others run: by ptrace, from outside, so that
nothing in the product has to know of it."""

import contextlib
import ctypes
import os

LIBC = ctypes.CDLL(None, use_errno=True)
LIBC.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
PTRACE_DETACH, PTRACE_SEIZE, PTRACE_INTERRUPT = 17, 0x4206, 0x4207
WALL = 0x40000000


def of(pid):
    """{name: thread id}"""
    names = {}
    for tid in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{tid}/comm", encoding="utf-8") as file:
            names[file.read().strip()] = int(tid)
    return names


def call(request, tid):
    if LIBC.ptrace(request, tid, None, None) != 0:
        error = ctypes.get_errno()
        raise OSError(error, f"ptrace {request:#x} of {tid}: {os.strerror(error)}")


@contextlib.contextmanager
def stopped(pid, name):
    """The thread of that name stands still inside."""
    tid = of(pid)[name]
    call(PTRACE_SEIZE, tid)
    try:
        call(PTRACE_INTERRUPT, tid)
        os.waitpid(tid, WALL)
        yield
    finally:
        call(PTRACE_DETACH, tid)

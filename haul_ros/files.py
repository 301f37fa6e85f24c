"""Files of users, opened so that nothing can hang, and nothing lands where it was not meant to."""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO


def open_file(path: Path) -> BufferedReader:
    """Open a regular file for reading; a device or a pipe may have no end, or no one at its other end.

    Raises
    ------
    OSError
        It cannot be opened, or is of another kind; ``strerror`` says so.
    """
    # Without O_NONBLOCK a pipe that nobody writes to would wait; regular files do not care.
    file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    mode = os.fstat(file).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(file, "rb")
    os.close(file)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    raise OSError(errno.EINVAL, "not a regular file", str(path))


def create_file(path: Path) -> BinaryIO:
    """Open a file for writing, empty; a link in its place is not followed.

    Raises
    ------
    OSError
        It cannot be made, or there is a link of its name.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC | os.O_NOFOLLOW
    try:
        return os.fdopen(os.open(path, flags, 0o666), "wb")
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise OSError(errno.ELOOP, "is a link, expected a file or nothing", str(path)) from error
        raise


def write_new_file(path: Path, data: bytes) -> None:
    """Write a new file whole, or leave none.

    Raises
    ------
    OSError
        It cannot be made or written, or there is something of its name.
    """
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666), "wb") as file:
        try:
            file.write(data)
            file.flush()
        except BaseException:
            path.unlink(missing_ok=True)
            raise

"""A log written anew: a cut one made whole, or its viewers' messages at another rate."""

import os

from cycloid_mj.log.reader import Log
from cycloid_mj.log.viewer import Viewer
from cycloid_mj.log.writer import LogWriter


def rewrite(log: Log, path: str | os.PathLike[str], viewer: Viewer | None = None, *, force: bool = False) -> None:
    """Write a log that was loaded to another file, whole: every topic, the provenance and every attachment.

    The file appears once it is whole.

    A cut log stays incomplete, and its note goes on to say how far it was read.

    Parameters
    ----------
    log
        What was loaded.
    path
        File to write. Refused if it exists, unless `force`.
    viewer
        What makes the viewers' messages from the columns; without it the new log has none.
    force
        Whether to replace an existing log.

    Raises
    ------
    LogError
        The file exists or cannot be written.
    """
    run = log.run
    groups = {topic: [(name, run.units[name]) for name in names] for topic, names in log.topics.items()}
    with LogWriter(path, groups, run.provenance, run.attachments, force=force, viewer=viewer, hidden=True) as writer:
        writer.write(run.time, {topic: run.block(names) for topic, names in log.topics.items()})
        writer.close(run.note, run.complete)

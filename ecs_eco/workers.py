"""Worker processes that do not outlive who started them."""

import multiprocessing
import os
import signal
import threading


def end_with_parent() -> None:
    """Send this process SIGTERM as soon as the one that started it is gone; to be called as a worker starts.

    A pool's workers wait on a pipe that they hold both ends of: killed from outside, their parent would leave them at
    work on all that is queued.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=wait, daemon=True).start()

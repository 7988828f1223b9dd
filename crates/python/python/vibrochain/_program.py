"""What the installed program ``mapgen`` does for Python: the explorer, and sweeps in shares."""

from __future__ import annotations

import atexit
import json
import os
import shutil
import subprocess
import sysconfig
import tempfile
import webbrowser
from typing import Any, SupportsIndex

from ._errors import RequestError, VibrochainError
from ._map import _as_text


def _program(given: str | os.PathLike[str] | None = None) -> str:
    """Where the program is: as given, as the variable MAPGEN says, where a wheel has put it, whose path need not be searched, or on the path."""
    name = os.fspath(given) if given is not None else os.environ.get("MAPGEN")
    found = shutil.which(name) if name else shutil.which("mapgen", path=sysconfig.get_path("scripts")) or shutil.which("mapgen")
    if found is None:
        message = (
            f"the program {name or 'mapgen'} is not installed: a wheel brings it, `cargo install --locked --path crates/cli` makes it, "
            "or name it in the variable MAPGEN"
        )
        raise FileNotFoundError(2, message, name or "mapgen")
    return found


def _there(scene: str | os.PathLike[str]) -> str:
    """The whole path of a scene file."""
    path = os.path.abspath(os.fspath(scene))
    if not os.path.exists(path):
        raise FileNotFoundError(2, "there is no such file", os.fspath(scene))
    return path


def _failed(told: str, code: int) -> VibrochainError:
    """What the program has said as it ended."""
    lines = told.strip().removeprefix("error: ")
    return (RequestError if code == 2 else VibrochainError)(lines or f"mapgen ended with {code}")


class Explorer:
    """The explorer at work; it ends with `close`, with the block of a ``with``, or with Python.

    Attributes
    ----------
    address : str
        Where its page is, on this machine alone.

    Examples
    --------
    >>> import vibrochain as vc
    >>> with vc.explore("scenes/conservative-n5.toml", browser=False) as explorer:  # doctest: +MAPGEN
    ...     explorer.address.startswith("http://127.0.0.1:")
    True
    """

    def __init__(self, process: subprocess.Popen[str], folder: tempfile.TemporaryDirectory[str], address: str) -> None:
        self._process, self._folder, self.address = process, folder, address
        atexit.register(self.close)

    def close(self) -> None:
        """Ends it. Whatever it has computed is gone; to end it twice does nothing.

        Examples
        --------
        >>> import vibrochain as vc
        >>> explorer = vc.explore("scenes/conservative-n5.toml", browser=False)  # doctest: +MAPGEN
        >>> explorer.close()  # doctest: +MAPGEN
        >>> explorer  # doctest: +MAPGEN
        <Explorer, ended>
        """
        atexit.unregister(self.close)
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if self._process.stdout:
            self._process.stdout.close()
        self._folder.cleanup()

    def __reduce__(self) -> Any:
        raise TypeError("an explorer is a process at work: it can neither be copied nor pickled")

    def __enter__(self) -> Explorer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Explorer at {self.address}>" if self._process.poll() is None else "<Explorer, ended>"

    def _repr_html_(self) -> str:
        return f'<a href="{self.address}" target="_blank">{self.address}</a>'


def explore(
    scene: str | os.PathLike[str] | dict[str, Any] | None = None,
    *,
    port: SupportsIndex = 0,
    browser: bool = True,
    mapgen: str | os.PathLike[str] | None = None,
) -> Explorer:
    """Opens a scene's map in the browser, to fly over: starts ``mapgen explore``.

    Parameters
    ----------
    scene : str, os.PathLike or dict, optional
        A scene file, or a dictionary with the same keys (`read_scene`); without it an example.
    port : int
        Port of this machine; 0 takes a free one.
    browser : bool
        Whether to open a window; else `Explorer.address` says where to look.
    mapgen : str or os.PathLike, optional
        The program; else the one that the variable MAPGEN names, that the wheel has brought, or that is on the path.

    Returns
    -------
    Explorer
        Keep it: `Explorer.close` ends it.

    Raises
    ------
    FileNotFoundError
        If the program, or the scene, is not there.
    RequestError
        For a scene that cannot be flown over, or a port that browsers refuse.

    Examples
    --------
    >>> import vibrochain as vc
    >>> scene = vc.read_scene("scenes/conservative-n20.toml")
    >>> scene["model"]["asymmetry"] = 0.7
    >>> with vc.explore(scene, browser=False) as explorer:  # doctest: +MAPGEN
    ...     print(explorer.address[:17])
    http://127.0.0.1:
    """
    program = _program(mapgen)
    folder = tempfile.TemporaryDirectory(prefix="vibrochain-")
    try:
        if isinstance(scene, dict):
            path = os.path.join(folder.name, "scene.json")
            with open(path, "w", encoding="utf-8") as file:
                file.write(_as_text(scene))
        elif scene is not None:
            path = _there(scene)
        command = [program, "explore", "--port", str(port.__index__()), *([path] if scene is not None else [])]
        with tempfile.TemporaryFile("w+", encoding="utf-8") as told:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=told, text=True)
            address = process.stdout.readline().strip() if process.stdout else ""
            if not address:
                code = process.wait()
                told.seek(0)
                raise _failed(told.read(), code)
    except BaseException:
        folder.cleanup()
        raise
    if browser:
        webbrowser.open(address)
    return Explorer(process, folder, address)


def _share(program: str | None, scene: str, folder: str, share: str, threads: int | None) -> str:
    """One share of a sweep, wherever this is run."""
    command = [_program(program), "sweep", scene, "--out", folder, "--shard", share, "--resume", "--quiet"]
    if threads is not None:
        command += ["--threads", str(threads)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise _failed(done.stderr, done.returncode)
    return share


def sweep_shares(
    scene: str | os.PathLike[str] | dict[str, Any],
    out: str | os.PathLike[str],
    executor: Any,
    *,
    shares: SupportsIndex,
    threads: SupportsIndex | None = None,
    mapgen: str | os.PathLike[str] | None = None,
) -> str:
    """Spreads a sweep over the workers of an executor, and merges it into one table: ``mapgen sweep --shard``, ``mapgen merge``.

    Chunks lie in the folder ``OUT.chunks``, which may be deleted once the table is there. If a worker is lost, or this call is ended, call
    it once more: finished chunks are kept. The table has the same bytes as that of one undisturbed run.

    Parameters
    ----------
    scene : str, os.PathLike or dict
        A scene file, of a chain or of a structure, or a dictionary with the same keys (`Structure.scene`).
    out : str or os.PathLike
        The table to write, in a folder that all workers see: ".csv", ".csv.gz", ".csv.zst".
    executor : object with ``submit(function, *arguments)``
        A ``dask.distributed.Client`` (of a local cluster, or of ``dask_jobqueue.SLURMCluster``), a `concurrent.futures.Executor`, or the like.
        The program must be there on every worker.
    shares : int
        In how many shares: a few for each worker.
    threads : int, optional
        Threads of each share; one a core if not given. Give 1 where workers share a machine.
    mapgen : str or os.PathLike, optional
        The program on every worker; else as for `explore`.

    Returns
    -------
    str
        The path of the table.

    Raises
    ------
    FileNotFoundError
        Where the program is not installed.
    RequestError
        For a scene that is wrong.

    Examples
    --------
    >>> import concurrent.futures, os, tempfile, vibrochain as vc
    >>> with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(2) as pool:  # doctest: +MAPGEN
    ...     table = vc.sweep_shares("scenes/conservative-n5.toml", f"{folder}/map.csv", pool, shares=4, threads=1)
    ...     os.path.basename(table), sum(1 for _ in open(table))
    ('map.csv', 120001)
    """
    table = os.path.abspath(os.fspath(out))
    count, each = shares.__index__(), None if threads is None else threads.__index__()
    if not 1 <= count <= 100_000:
        raise RequestError(f"shares = {count} is out of range: give a whole number from 1 to 100000")
    chunks = f"{table}.chunks"
    os.makedirs(chunks, exist_ok=True)
    if isinstance(scene, dict):
        path = f"{table}.scene.json"
        with open(path, "w", encoding="utf-8") as file:
            json.dump(json.loads(_as_text(scene)), file)
    else:
        path = _there(scene)
    program = None if mapgen is None else os.fspath(mapgen)
    waiting = [executor.submit(_share, program, path, chunks, f"{share}/{count}", each) for share in range(count)]
    for future in waiting:
        future.result()
    done = subprocess.run(
        [_program(mapgen), "merge", chunks, "--out", table, "--quiet"], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise _failed(done.stderr, done.returncode)
    return table

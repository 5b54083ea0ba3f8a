"""Let numba's cache of the compiled kernel survive damaged files and read-only folders.

Each cached file ends with a digest of its content; where the two disagree the kernel is compiled
anew. Should numba's internals change, its own cache is used as it is.
"""

from __future__ import annotations

import hashlib
import logging
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

SEAL = 16  # bytes of the digest at the end of a file


def guard(dispatcher: Any, sources: str) -> None:
    """Give a compiled function a cache that tolerates damaged files and read-only folders.

    It depends on the digest of all ``sources``, not on the function's own file only.
    """
    own: Any = getattr(dispatcher, "_cache", None)
    try:
        file = own._cache_file
        file._source_stamp = (file._source_stamp, sources)
        sealed = _sealed()(file._cache_path, "", file._source_stamp)
        sealed.__dict__.update(vars(file))
        own._cache_file = sealed
    except (ImportError, AttributeError, TypeError):
        return


@cache
def _sealed() -> Any:
    """Subclass of numba's cache files that checks digests, and logs errors instead of raising."""
    base: Any = import_module("numba.core.caching").IndexDataCacheFile

    class Sealed(base):  # type: ignore[misc]
        def load(self, key: Any) -> Any:
            try:
                return super().load(key)
            except Exception as error:  # unpickling damaged bytes may raise anything
                reason = " ".join(str(error).split()) or type(error).__name__
                _say(self._cache_path, f"is damaged ({reason})")
                return None

        def save(self, key: Any, data: Any) -> None:
            try:
                try:
                    super().save(key, data)
                except OSError:
                    raise
                except Exception:  # the index is damaged
                    self.flush()
                    super().save(key, data)
            except OSError as error:
                _say(self._cache_path, f"cannot be written ({error.strerror or error})")

        def _dump(self, value: Any) -> bytes:
            content: bytes = super()._dump(value)
            return content + _seal(content)  # pickle ignores what follows its own end

        def _load_data(self, name: str) -> Any:
            content = Path(self._data_path(name)).read_bytes()
            if _seal(content[:-SEAL]) != content[-SEAL:]:
                raise ValueError(f"{name} is not what was written")
            return super()._load_data(name)

    return Sealed


def _seal(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=SEAL).digest()


@cache
def _say(folder: str, what: str) -> None:
    logging.getLogger("woodpecker").warning(
        "the cache of the compiled kernel in %s %s: the kernel is compiled anew, which takes "
        "twenty to forty seconds",
        folder,
        what,
    )

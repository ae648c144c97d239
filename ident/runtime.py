"""The only place that configures JAX: double precision, how XLA compiles, where compiled code is kept.

XLA runs each pass of a loop as a separate dispatch (about 0.6 µs) unless it may compile the whole loop into one
kernel, which by default it does for tiny bodies only. The flag below lifts that limit; it must be set before the
backend starts.
"""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path

_LOOP_FLAG = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1000000000"
_CACHE_SWITCH = "IDENT_CACHE"


def configure() -> None:
    """Set up JAX for this process; called once by `import ident.model` and safe to call again.

    JAX's own compilation cache stays as it is: `programs` keeps what it compiles, and code that JAX took from its cache
    cannot be kept a second time.
    """
    _append_loop_flag()
    import jax

    jax.config.update("jax_enable_x64", True)


def compiler_options() -> dict[str, bool | int]:
    """Options of `jax.jit` for large programs: XLA's older emitter, in one piece.

    It compiles simulations in half the time, to code that runs as fast. A release without one of these options would
    refuse to compile: newer ones than were tried do without.
    """
    import jax

    if jax.__version_info__ >= (0, 11):
        return {}
    return {"xla_cpu_use_fusion_emitters": False, "xla_cpu_parallel_codegen_split_count": 1}


def _append_loop_flag() -> None:
    flags = os.environ.get("XLA_FLAGS", "")
    if "xla_cpu_small_while_loop_byte_threshold" in flags:
        return
    if _backend_started():
        warnings.warn(
            "JAX was already running when ident was imported: simulations will be 4 to 10 times slower. "
            "Import ident before using jax, or set XLA_FLAGS=" + _LOOP_FLAG,
            RuntimeWarning,
            stacklevel=3,
        )
        return
    os.environ["XLA_FLAGS"] = f"{flags} {_LOOP_FLAG}".strip()


def _backend_started() -> bool:
    bridge = sys.modules.get("jax._src.xla_bridge")
    return bool(bridge is not None and getattr(bridge, "_backends", None))


def cache_folder() -> Path | None:
    """Where compiled code is kept: in the user's cache folder; `IDENT_CACHE=off` keeps none, any other value of the
    variable names another folder."""
    switch = os.environ.get(_CACHE_SWITCH, "")
    if switch.lower() == "off":
        return None
    if switch:
        return Path(switch)
    from platformdirs import user_cache_path

    return user_cache_path("ident")

"""Linear algebra keeps to one thread inside ident, and to what the user chose outside of it."""

import threading

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import ident
from ident.threads import one_thread


def counts() -> set[int]:
    import scipy.linalg  # noqa: F401  (brings a library of its own)

    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


@one_thread
def inside(then=lambda: None):
    found = counts()
    then()
    return found


def test_one_thread_inside_and_the_users_own_after_it():
    with threadpool_limits(2, "blas"):
        assert inside() == {1}
        assert counts() == {2}
        inside(lambda: inside())
        assert counts() == {2}
        with pytest.raises(ZeroDivisionError):
            inside(lambda: 1 / 0)
        assert counts() == {2}


def test_calls_that_overlap_leave_what_was_there_before_the_first():
    entered, may_end = threading.Event(), threading.Event()
    with threadpool_limits(2, "blas"):
        first = threading.Thread(target=inside, args=(lambda: (entered.set(), may_end.wait(10)),))
        first.start()
        assert entered.wait(10)
        inside(lambda: (may_end.set(), first.join()))
        assert counts() == {2}


def test_functions_of_ident_are_such():
    with threadpool_limits(2, "blas"):
        ident.read_campaign("data/platform_clean")
        assert counts() == {2}
    for name in ("check", "diagnose", "discover", "add", "remove", "sample", "compare", "attribute", "simulate",
                 "profile", "write_run", "read_campaign"):  # fmt: skip
        assert hasattr(getattr(ident, name), "__wrapped__"), name

"""The listings of the READMEs and of the guide run as they stand."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from listings import Listing, is_of_optional, listings

ROOT = Path(__file__).parents[2]
FILES = [ROOT / "README.md", ROOT / "python/README.md", *sorted((ROOT / "guide/src").glob("*.md"))]
LISTINGS = [listing for path in FILES for listing in listings(path)]


@pytest.fixture(autouse=True)
def no_cluster_left() -> Iterator[None]:
    """Stops the cluster of Ray that a listing has started, so that tests that start their own find none."""
    yield
    if "ray" in sys.modules:
        sys.modules["ray"].shutdown()


@pytest.mark.parametrize("listing", LISTINGS, ids=lambda own: f"{own.path.name}:{own.line}")
def test_a_listing_runs(listing: Listing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "assets").symlink_to(ROOT / "assets")  # listings name the robots of the repository
    monkeypatch.chdir(tmp_path)
    try:
        listing.run()
    except ImportError as error:
        if not is_of_optional(error):
            raise
        pytest.skip(str(error))


def test_each_file_has_listings() -> None:
    assert len(LISTINGS) > 30
    assert {path.name for path in FILES[:2]} <= {listing.path.name for listing in LISTINGS}

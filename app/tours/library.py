"""The folder of the user's tours, and the tours that come with the program.

A tour is a file ``ID.yaml``; pictures and videos lie beside it, in ``media/`` or wherever the tour names them. A tour
of the user's hides the program's of the same id; the program's own files are never written.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import ClassVar

from app.base.errors import ConfigError
from app.base.named_library import NamedLibrary, data_folder
from app.base.plain_file import megabytes
from app.base.whole_file import write_whole
from app.tours.model import Tour
from app.tours.tour_file import MOST_BYTES, load_tour, tour_text

#: More tours are not kept.
MOST_TOURS = 500


class TourError(Exception):
    """It cannot be done; the message is one sentence."""


class UnknownTour(TourError):
    """There is no tour of this id."""


class TourTaken(TourError):
    """Another tour has this id already."""


class ShippedTour(TourError):
    """A tour that comes with the program is not deleted."""


class TooManyTours(TourError):
    """There are as many tours as are kept."""


class TourTooLarge(TourError):
    """Its file would be larger than what is read."""


class NoVersion(TourError):
    """There is nothing to undo, or to redo."""


class TourLibrary(NamedLibrary):
    """Tours in the folder of the user's, and those in ``shipped``. All methods touch the disk.

    Methods raise OSError, ValueError for an id that cannot be one, and UnknownTour where no tour has it.
    """

    kind: ClassVar[str] = "tour"
    suffix: ClassVar[str] = ".yaml"

    def __init__(self, folder: Path, shipped: Path | None = None) -> None:
        super().__init__(folder)
        self._shipped = shipped

    @property
    def folders(self) -> tuple[Path, ...]:
        """Where files of tours are looked for, the user's first."""
        return (self.folder,) if self._shipped is None else (self.folder, self._shipped)

    def names(self) -> list[str]:
        """The id of every tour, sorted."""
        found = {name for name, path in self.entries() if path.is_file()}
        if self._shipped is not None:
            found |= {path.stem for path in self._shipped.glob(f"*{self.suffix}")}
        return sorted(found)

    def file(self, name: str) -> Path:
        """The file of the tour ``name``."""
        for folder in self.folders:
            path = folder / self.path(name).name
            if path.is_file():
                return path
        names = self.names()
        raise UnknownTour(f"there is no tour {name!r}; there are: {', '.join(names) or 'none'}")

    def read(self, name: str) -> Tour:
        """The tour ``name``. Raises ConfigError for a file that is no tour, or one of another id."""
        tour, document = load_tour(self.file(name))
        if tour.id != name:
            raise document.error(f"id: should be {name!r}, as the file is called, not {tour.id!r}", ("id",))
        return tour

    def is_shipped(self, name: str) -> bool:
        """Whether the tour ``name`` is the program's own, as it came."""
        return not self.path(name).is_file() and self.shipped(name) is not None

    def shipped(self, name: str) -> Tour | None:
        """The program's own tour of this id, hidden or not; None: there is none that can be read."""
        if self._shipped is None or not (path := self._shipped / self.path(name).name).is_file():
            return None
        with contextlib.suppress(ConfigError):
            return load_tour(path)[0]
        return None

    def write(self, tour: Tour) -> None:
        """Keep ``tour`` under its id, wholly or not at all. Raises TourTooLarge."""
        path, text = self.path(tour.id), tour_text(tour)
        if len(text.encode()) > MOST_BYTES:
            raise TourTooLarge(
                f"The file of {tour.id} would have more than {megabytes(MOST_BYTES)}, the most that is read"
            )
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.encode())

    def delete(self, name: str) -> None:
        """Delete the user's tour ``name``, if there is one; the program's of that id is there again."""
        self.path(name).unlink(missing_ok=True)


def default_folder() -> Path:
    """``$HBBA_TOURS``, or ``hbba/tours`` in the user's data folder."""
    return data_folder("HBBA_TOURS", "tours")

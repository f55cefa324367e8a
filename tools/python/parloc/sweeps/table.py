"""The trials of a sweep as one table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from ..errors import BackendError, UsageError
from .folder import writing

if TYPE_CHECKING:
    import pandas


class Table(Sequence[dict[str, Any]]):
    """Rows of {column: value}, kept by columns. What a trial does not have is None."""

    def __init__(self, columns: dict[str, list[Any]]):
        self.columns = columns

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), []))

    @overload
    def __getitem__(self, row: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, row: slice) -> list[dict[str, Any]]: ...
    def __getitem__(self, row: int | slice) -> dict[str, Any] | list[dict[str, Any]]:
        if isinstance(row, slice):
            return [self[k] for k in range(*row.indices(len(self)))]
        return {name: values[row] for name, values in self.columns.items()}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for values in zip(*self.columns.values(), strict=True):
            yield dict(zip(self.columns, values, strict=True))

    def to_pandas(self) -> pandas.DataFrame:
        """Needs pandas."""
        import pandas

        return pandas.DataFrame(self.columns)

    def save(self, path: str | Path) -> None:
        """As CSV, or as Parquet if the name ends so, which needs pyarrow. Raises OutputError, UsageError for another ending,
        BackendError without pyarrow."""
        path = Path(path)
        ending = path.suffix.lower()
        if ending not in (".csv", ".parquet"):
            raise UsageError(f"{path}: expected a name that ends in .csv or .parquet")
        draft = path.with_name(path.name + ".tmp")
        with writing(path):
            self._save_parquet(draft) if ending == ".parquet" else draft.write_text(self.to_csv(), encoding="utf-8")
            draft.replace(path)

    def to_csv(self) -> str:
        """Numbers to their last digit; true and false; nothing for None."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        for values in zip(*self.columns.values(), strict=True):
            writer.writerow([str(value).lower() if isinstance(value, bool) else value for value in values])
        return text.getvalue()

    def _save_parquet(self, path: Path) -> None:
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise BackendError("a Parquet file needs pyarrow: pip install 'parloc[parquet]', or a name in .csv") from None
        pyarrow.parquet.write_table(pyarrow.table(self.columns), path)

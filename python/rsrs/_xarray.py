"""The cells of a sweep as a dataset of xarray."""

from typing import Any

import numpy as np

from ._rsrs import SweepResult


def dataset(result: SweepResult) -> Any:
    """One dimension for each axis, or ``cell`` for a list of cells, and ``world``."""
    import xarray  # it need not be there for anything else

    table = result.cells.to_numpy()
    axes = result.axes
    values = [np.unique(table[axis]) for axis in axes]
    index = [np.searchsorted(values[i], table[axis]) for i, axis in enumerate(axes)]
    shape: tuple[int, ...] = tuple(len(of_axis) for of_axis in values)
    worlds = list(dict.fromkeys(table["world"]))
    is_grid = len(table["world"]) == len(worlds) * int(np.prod(shape))
    coordinates: dict[str, Any] = dict(zip(axes, values))
    if not is_grid:
        first = table["world"] == worlds[0]
        coordinates = {axis: ("cell", table[axis][first]) for axis in axes}
        shape = (int(first.sum()),)
    data = {}
    for name, column in table.items():
        if name in axes or name == "world":
            continue
        grid = np.empty((len(worlds), *shape), dtype=column.dtype)
        for number, world in enumerate(worlds):
            rows = table["world"] == world
            if is_grid:
                grid[(number, *(of_axis[rows] for of_axis in index))] = column[rows]
            else:
                grid[number] = column[rows]
        data[name] = (["world", *(axes if is_grid else ["cell"])], grid)
    return xarray.Dataset(data, {"world": worlds, **coordinates})

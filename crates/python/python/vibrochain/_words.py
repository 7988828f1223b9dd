"""Which breathers a model can be asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import SupportsIndex

from . import _vibrochain
from ._vibrochain import Model


def words(
    model: Model,
    sites_used: SupportsIndex = 1,
    reach: SupportsIndex | None = None,
    families: Sequence[str] = ("double-sided", "single-sided"),
) -> list[str]:
    """Impact words of two instants on a few sites, each of which hits as a family does: what `Model.breathers` can be asked for.

    Words that the symmetry of the chain makes one are listed once. Beside words there are the families "double-sided", "single-sided" and
    "period-doubled".

    Parameters
    ----------
    model : Model
        The parameters; whether there is a force decides which words are the same.
    sites_used : int
        How many sites hit.
    reach : int, optional
        How far apart they may be, along the chain; as little as has room for them if not given.
    families : sequence of {"double-sided", "single-sided"}
        As what each site may hit.

    Returns
    -------
    list of str

    Raises
    ------
    RequestError
        For more sites than there is room for, or another family.
    TooLargeError
        For more than a million words.

    Examples
    --------
    >>> import vibrochain as vc
    >>> model = vc.Model(vc.Chain(12, 0.2, 0.05), omega=1.5, asymmetry=0.2)
    >>> vc.words(model, 2, 2, ["double-sided"])
    ['0+1+,0-1-', '0+1-,0-1+', '0+2+,0-2-', '0+2-,0-2+']
    >>> {word: len(model.breathers(word)) for word in vc.words(model)}
    {'0+,0-': 1, '0-': 1}
    """
    sites = sites_used.__index__()
    return _vibrochain._words(model, sites, max(sites - 1, 0) if reach is None else reach.__index__(), _vibrochain._items("families", families))

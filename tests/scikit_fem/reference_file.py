"""Writing reference files and comparing them with freshly made ones."""
import json

import numpy as np
import scipy.sparse as sp


def plain(value):
    """The record as plain lists, numbers and strings; matrices as triplets."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if sp.issparse(value):
        coo = value.tocsr().tocoo()
        return {
            "rows": int(coo.shape[0]),
            "columns": int(coo.shape[1]),
            "row": coo.row.tolist(),
            "column": coo.col.tolist(),
            "value": coo.data.tolist(),
        }
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def text(record):
    """JSON with one line per entry of the record, numbers as Python's repr."""
    def block(value, indent):
        if isinstance(value, dict) and any(isinstance(v, (dict, list)) for v in value.values()):
            lines = [f"{indent} {json.dumps(k)}: {block(v, indent + ' ')}" for k, v in value.items()]
            return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
        return json.dumps(value, separators=(",", ":"), allow_nan=False)

    return block(plain(record), "") + "\n"


def differences(committed, fresh, tolerance=1e-13, place=""):
    """Sentences on every entry that differs by more than the tolerance.

    Floating-point entries are compared relative to the largest entry of the
    committed array; everything else must be equal. Matrices are compared as
    matrices, so that an entry that is absent equals zero.
    """
    if isinstance(committed, dict) and isinstance(fresh, dict):
        if committed.keys() != fresh.keys():
            return [f"{place}: keys {sorted(committed)} against {sorted(fresh)}"]
        if committed.keys() == {"rows", "columns", "row", "column", "value"}:
            shape = committed["rows"], committed["columns"]
            if shape != (fresh["rows"], fresh["columns"]):
                return [f"{place}: another shape"]
            a, b = (sp.csr_matrix((m["value"], (m["row"], m["column"])), shape) for m in (committed, fresh))
            return too_large(abs(a - b).max(), abs(a).max(), tolerance, place)
        return [
            line
            for key in committed
            for line in differences(committed[key], fresh[key], tolerance, f"{place}/{key}")
        ]
    if isinstance(committed, (list, float)) and type(committed) is type(fresh):
        try:
            a, b = np.array(committed), np.array(fresh)
        except ValueError:
            return [] if committed == fresh else [f"{place}: differs"]
        if a.shape == b.shape and a.size and np.issubdtype(a.dtype, np.floating):
            return too_large(np.abs(a - b).max(), np.abs(a).max(), tolerance, place)
    return [] if committed == fresh else [f"{place}: differs"]


def too_large(difference, largest, tolerance, place):
    if difference <= tolerance * largest:
        return []
    return [f"{place}: differs by {difference:.3e}, largest entry {largest:.3e}"]

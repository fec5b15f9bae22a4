"""Files of waveforms read by other readers than their writer."""

import wave

import numpy as np
import scipy.io


def read_back(path, full_scale):
    """Times and voltages of a file, by another reader than its writer."""
    if path.suffix == ".mat":
        content = scipy.io.loadmat(path)
        return content["time"].ravel(), content["voltage"].ravel()
    if path.suffix == ".npy":
        array = np.load(path)
        return array["time"], array["voltage"]
    if path.suffix == ".wav":
        with wave.open(str(path), "rb") as file:
            raw = np.frombuffer(file.readframes(file.getnframes()), "u1").reshape(-1, 3)
            whole = np.concatenate([raw, np.where(raw[:, 2:] > 127, 255, 0).astype("u1")], axis=1)
            codes = np.ascontiguousarray(whole).view("<i4").ravel()
            return np.arange(len(codes)) / file.getframerate(), codes / 2**23 * full_scale
    if path.suffix == ".pwl":
        rows = [line.split()[1:] for line in path.read_text("utf-8").splitlines() if line.startswith("+ ")]
        table = np.array([[float(each) for each in row] for row in rows if len(row) == 2])
        return table[:, 0], table[:, 1]
    lines = path.read_text(encoding="utf-8").splitlines()
    table = np.array([line.split(",") for line in lines if line[0].isdigit()], dtype=float)
    return table[:, 0], table[:, 1]

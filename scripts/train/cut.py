"""From the values of a network to a solid, as the program does it (src/deepslam/propose/cut_shares.h)."""
import itertools

import numpy as np
import torch
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

LEAST_SHARE, REACH, SMALL_SHARE = 0.05, 2, 0.003


def levels(shares, threshold, kept_of_expected):
    """[N, 64, 64, 64] -> [N, 64]: the value above which the voxels of each layer along z are solid."""
    layers = shares.permute(0, 3, 1, 2).flatten(2)
    kept = (kept_of_expected * layers.double().sum(2) + 0.5).long().clamp(max=layers.shape[2] - 1)
    ranked = layers.sort(2, descending=True).values
    return ranked.gather(2, kept[..., None])[..., 0].clamp(min=LEAST_SHARE).clamp(max=threshold)


def components(solid):
    """Number of the component of each voxel of [64, 64, 64] bool, 0 where nothing is; voxels within REACH along every axis belong
    together. Neighbours are joined first, so that few pairs are left to look at."""
    labels, count = ndimage.label(solid, np.ones((3, 3, 3)))
    if count < 2:
        return labels
    padded, links = np.pad(labels, REACH), [np.zeros((0, 2), labels.dtype)]
    for offset in itertools.product(range(-REACH, REACH + 1), repeat=3):
        if offset <= (0, 0, 0) or max(map(abs, offset)) < 2:
            continue  # half of them are the other half from the other end
        other = padded[tuple(slice(REACH + o, REACH + o + n) for o, n in zip(offset, labels.shape))]
        apart = (labels != other) & (labels > 0) & (other > 0)
        links.append(np.stack([labels[apart], other[apart]], 1))
    links = np.unique(np.concatenate(links), axis=0)
    graph = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count + 1, count + 1))
    return np.where(labels > 0, 1 + connected_components(graph, directed=False)[1][labels], 0)


def without_small_components(solid):
    part = components(solid.numpy())
    count = np.bincount(part.reshape(-1))
    large = count >= SMALL_SHARE * count[1:].sum()
    large[0] = False
    return torch.from_numpy(large[part])


def cut(shares, threshold, kept_of_expected):
    """[N, 64, 64, 64] values in [0, 1] -> bool."""
    solid = shares > levels(shares, threshold, kept_of_expected)[:, None, None, :]
    return torch.stack([without_small_components(one) if bool(one.any()) else one for one in solid])

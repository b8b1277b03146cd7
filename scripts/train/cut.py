"""From the values of a network to a solid, as the program does it (src/deepslam/propose/cut_shares.h)."""
import numpy as np
import torch
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

LEAST_SHARE, REACH, CRUMB = 0.05, 2, 0.003


def levels(shares, threshold, kept_of_expected):
    """[N, 64, 64, 64] -> [N, 64]: the value above which the voxels of each layer along z are solid."""
    layers = shares.permute(0, 3, 1, 2).flatten(2)
    kept = (kept_of_expected * layers.double().sum(2) + 0.5).long().clamp(max=layers.shape[2] - 1)
    ranked = layers.sort(2, descending=True).values
    return ranked.gather(2, kept[..., None])[..., 0].clamp(min=LEAST_SHARE).clamp(max=threshold)


def without_crumbs(solid):
    places = torch.nonzero(solid).numpy()
    near = cKDTree(places).query_pairs(REACH, p=np.inf, output_type="ndarray")
    links = coo_matrix((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(places), len(places)))
    part = connected_components(links, directed=False)[1]
    count = np.bincount(part)
    places = places[(count >= CRUMB * len(places))[part]]
    kept = torch.zeros_like(solid)
    kept[places[:, 0], places[:, 1], places[:, 2]] = True
    return kept


def cut(shares, threshold, kept_of_expected):
    """[N, 64, 64, 64] values in [0, 1] -> bool."""
    solid = shares > levels(shares, threshold, kept_of_expected)[:, None, None, :]
    return torch.stack([without_crumbs(one) if bool(one.any()) else one for one in solid])

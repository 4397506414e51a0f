"""A closed surface about what a scan encloses, for bodies that light must enter and leave in turn.

A point is inside where the scan's generalized winding number is over 1/2 (Jacobson, Kavan and Sorkine-Hornung 2013, "Robust inside-outside
segmentation using generalized winding numbers"), so holes, sheets and overlaps of the scan do not count. Distances with that sign, cut
off and smoothed on a grid, are a field whose zero is the surface, by marching cubes (Lewiner et al. 2003). No numbers are random.

    pip install libigl==2.6.3 scikit-image==0.26.0
"""

import igl
import numpy as np
from scipy import ndimage, sparse
from skimage import measure

# Cells of the grid beyond the scan, and distances that count, in cells.
MARGIN = 4
FAR = 3.0
# Deviation of the Gaussian, in cells.
SMOOTH = 0.75
# Values next to 0 are moved this far from it, in cells: triangles that end close to a point of the grid would be slivers.
LEAST = 0.1


def closed(points, faces, cell):
    """Points and faces of the largest body, of cubes with edges of `cell`."""
    points, faces = np.ascontiguousarray(points, np.float64), np.ascontiguousarray(faces, np.int64)
    low = points.min(axis=0) - MARGIN * cell
    counts = np.ceil((points.max(axis=0) + MARGIN * cell - low) / cell).astype(int) + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    at = low + cell * grid
    # The exact distance counts only next to the surface.
    inside = igl.fast_winding_number(points, faces, at).reshape(counts) > 0.5
    near = ndimage.binary_dilation(inside, iterations=4) & ~ndimage.binary_erosion(inside, iterations=4)
    distance = np.full(counts, FAR)
    squared = igl.point_mesh_squared_distance(at[near.ravel()], points, faces)[0]
    distance[near] = np.minimum(np.sqrt(squared) / cell, FAR)
    field = ndimage.gaussian_filter(np.where(inside, distance, -distance), SMOOTH)
    field = np.where(np.abs(field) < LEAST, np.where(field > 0, LEAST, -LEAST), field)
    points, faces, _, _ = measure.marching_cubes(field, 0.0, gradient_direction="ascent", allow_degenerate=False)
    return largest(low + cell * points.astype(np.float64), faces)


def largest(points, faces):
    """The connected part of the largest volume. Hollows inside have negative ones."""
    edges = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = sparse.coo_matrix((np.ones(len(edges)), edges.T), shape=(len(points), len(points)))
    part = sparse.csgraph.connected_components(graph, directed=False)[1][faces[:, 0]]
    a, b, c = (points[faces[:, k]] for k in range(3))
    volume = np.bincount(part, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6)
    faces = faces[part == volume.argmax()]
    used, numbers = np.unique(faces, return_inverse=True)
    points, faces = points[used], numbers.reshape(-1, 3)
    assert_closed(faces)
    return points, faces


def assert_closed(faces):
    """Each edge has two triangles, which agree on the outside."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    _, once = np.unique(edges, axis=0, return_counts=True)
    _, twice = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert np.all(once == 1) and np.all(twice == 2)

"""Two small dense solvers, written out so that the compiled library needs no LAPACK."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal

RANK = 1e-12  # eigenvalues below this part of the largest count as zero


@frugal
def pseudo_inverse(
    a: NDArray[np.float64], inverse: NDArray[np.float64], v: NDArray[np.float64]
) -> None:
    """
    Write the Moore-Penrose inverse of a symmetric, positive semidefinite matrix, which is used up.

    v: (n, n) scratch, for the eigenvectors.

    Cyclic Jacobi rotations (Golub, Van Loan, Matrix Computations, section 8.5). For contacts that
    share one constraint this is the least-norm solution, which no numbering of contacts changes.
    """
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            v[i, j] = 1.0 if i == j else 0.0
    for _ in range(60):
        off = 0.0
        size = 0.0
        for i in range(n):
            size += abs(a[i, i])
            for j in range(i):
                off += abs(a[i, j])
        if off <= 1e-17 * size:
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                if a[p, q] != 0.0:
                    rotate(a, v, p, q)
    largest = 0.0
    for i in range(n):
        largest = max(largest, a[i, i])
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 0.0
    for k in range(n):
        if a[k, k] > RANK * largest:
            for i in range(n):
                for j in range(n):
                    inverse[i, j] += v[i, k] * v[j, k] / a[k, k]


@frugal
def rotate(a: NDArray[np.float64], v: NDArray[np.float64], p: int, q: int) -> None:
    """Zero a[p, q] by a rotation in the plane of p and q, accumulated in v."""
    n = a.shape[0]
    theta = 0.5 * (a[q, q] - a[p, p]) / a[p, q]
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        x, y = a[k, p], a[k, q]
        a[k, p], a[k, q] = c * x - s * y, s * x + c * y
    for k in range(n):
        x, y = a[p, k], a[q, k]
        a[p, k], a[q, k] = c * x - s * y, s * x + c * y
        x, y = v[k, p], v[k, q]
        v[k, p], v[k, q] = c * x - s * y, s * x + c * y
    a[p, q] = 0.0
    a[q, p] = 0.0


@frugal
def solve_in_place(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Solve a x = b by Gaussian elimination with row pivoting; False where a is singular."""
    n = b.shape[0]
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if not abs(a[pivot, k]) > 1e-300:
            return False
        if pivot != k:
            for j in range(k, n):
                a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            factor = a[i, k] / a[k, k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i, j] -= factor * a[k, j]
                b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    return True

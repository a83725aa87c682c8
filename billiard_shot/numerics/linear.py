"""Two small dense solvers, written out so that they run compiled and interpreted alike."""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.records import Floats

RANK = 1e-12  # eigenvalues below this fraction of the largest count as zero


@inner
def pseudo_inverse(a: Floats, inverse: Floats, v: Floats, n: int) -> None:
    """
    Write the Moore-Penrose inverse of a symmetric, positive semidefinite (n, n) matrix.

    `a` is used up; `v` is scratch, for the eigenvectors.

    Cyclic Jacobi rotations (Golub, Van Loan, Matrix Computations, section 8.5). For contacts that
    share one constraint this is the least-norm solution, which does not depend on their numbering.
    """
    for i in range(n):
        for j in range(n):
            v[i][j] = 1.0 if i == j else 0.0
    for _ in range(60):
        off = 0.0
        size = 0.0
        for i in range(n):
            size += abs(a[i][i])
            for j in range(i):
                off += abs(a[i][j])
        if off <= 1e-17 * size:
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                if a[p][q] != 0.0:
                    rotate(a, v, n, p, q)
    largest = 0.0
    for i in range(n):
        largest = max(largest, a[i][i])
    for i in range(n):
        for j in range(n):
            inverse[i][j] = 0.0
    for k in range(n):
        if a[k][k] > RANK * largest:
            for i in range(n):
                for j in range(n):
                    inverse[i][j] += v[i][k] * v[j][k] / a[k][k]


@inner
def rotate(a: Floats, v: Floats, n: int, p: int, q: int) -> None:
    """Zero a[p][q] by a rotation in the plane of p and q, accumulated in v."""
    theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q]
    t = 1.0 / (abs(theta) + sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        x, y = a[k][p], a[k][q]
        a[k][p], a[k][q] = c * x - s * y, s * x + c * y
    for k in range(n):
        x, y = a[p][k], a[q][k]
        a[p][k], a[q][k] = c * x - s * y, s * x + c * y
        x, y = v[k][p], v[k][q]
        v[k][p], v[k][q] = c * x - s * y, s * x + c * y
    a[p][q] = 0.0
    a[q][p] = 0.0


@inner
def solve_in_place(a: Floats, b: Floats, n: int) -> bool:
    """Solve n equations a x = b by Gaussian elimination with pivots; False if a is singular."""
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i][k]) > abs(a[pivot][k]):
                pivot = i
        if not abs(a[pivot][k]) > 1e-300:
            return False
        if pivot != k:
            for j in range(k, n):
                a[k][j], a[pivot][j] = a[pivot][j], a[k][j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            factor = a[i][k] / a[k][k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i][j] -= factor * a[k][j]
                b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k][j] * b[j]
        b[k] /= a[k][k]
    return True

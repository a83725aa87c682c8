"""Markers in the frame of the table, of the kinds that the displays need."""

from collections.abc import Iterable, Sequence

from geometry_msgs.msg import Point, Vector3
import numpy as np
from numpy.typing import ArrayLike, NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.ros.conversions import filled

SIDES = 24  # of the polygon for a circle


def array_of(markers: Iterable[Marker], header: Header) -> MarkerArray:
    """Array of markers that replaces all earlier ones on its topic; ids count within each `ns`."""
    result = [Marker(action=Marker.DELETEALL), *markers]
    count: dict[str, int] = {}
    for marker in result:
        marker.header = header
        marker.id = count.get(marker.ns, 0)
        count[marker.ns] = marker.id + 1
    return MarkerArray(markers=result)


def colour(code: str, alpha: float = 1.0) -> ColorRGBA:
    """Colour of `#rrggbb`, with the opacity `alpha`, 0 to 1."""
    red, green, blue = (int(code[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return ColorRGBA(r=red, g=green, b=blue, a=float(alpha))


def box(namespace: str, low: ArrayLike, high: ArrayLike, paint: ColorRGBA) -> Marker:
    """Box between two corners (3,) [m]."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    return _shape(namespace, Marker.CUBE, 0.5 * (low + high), high - low, paint)


def ball(namespace: str, centre: ArrayLike, radius: float, paint: ColorRGBA) -> Marker:
    """Ball with a centre (3,) and a radius [m]."""
    return _shape(namespace, Marker.SPHERE, centre, np.full(3, 2 * radius), paint)


def disc(
    namespace: str, centre: ArrayLike, radius: float, thickness: float, paint: ColorRGBA
) -> Marker:
    """Upright cylinder about a centre (3,) [m]."""
    size = (2 * radius, 2 * radius, thickness)
    return _shape(namespace, Marker.CYLINDER, centre, size, paint)


def label_marker(text: str, place: ArrayLike, height: float, paint: ColorRGBA) -> Marker:
    """Text of a height [m] that faces the viewer, at a place (3,) [m]."""
    marker = _shape('labels', Marker.TEXT_VIEW_FACING, place, (0.0, 0.0, height), paint)
    marker.text = text
    return marker


def line_marker(
    namespace: str, points: NDArray[np.float64], width: float, paint: Sequence[ColorRGBA]
) -> Marker:
    """Line through points (n, 3), of a width [m], with a colour for each point."""
    marker = _shape(namespace, Marker.LINE_STRIP, np.zeros(3), (width, 0.0, 0.0), paint[0])
    marker.points = points_of(points)
    marker.colors = list(paint)
    return marker


def prisms(
    namespace: str,
    outlines: Iterable[NDArray[np.float64]],
    low: float,
    high: float,
    paint: ColorRGBA,
) -> Marker:
    """Upright prisms between two heights [m] over convex outlines (n, 2) [m]."""
    triangles: list[NDArray[np.float64]] = []
    for outline in outlines:
        top = np.column_stack([outline, np.full(len(outline), high)])
        bottom = np.column_stack([outline, np.full(len(outline), low)])
        triangles += [*_fan(top), *_strip(bottom, top)]
    return _mesh(namespace, triangles, paint)


def cone(
    namespace: str, tip: ArrayLike, end: ArrayLike, radii: tuple[float, float], paint: ColorRGBA
) -> Marker:
    """Cone frustum between two points (3,), with its radii at these points [m]."""
    tip, end = np.asarray(tip, float), np.asarray(end, float)
    axis = (end - tip) / np.linalg.norm(end - tip)
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    angles = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)[:, np.newaxis]
    around = np.cos(angles) * one + np.sin(angles) * np.cross(axis, one)
    thin, thick = tip + radii[0] * around, end + radii[1] * around
    return _mesh(namespace, [*_fan(thin), *_fan(thick), *_strip(thin, thick)], paint)


def points_of(points: NDArray[np.float64]) -> list[Point]:
    """Convert an array (n, 3) to points."""
    return [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]


def _shape(
    namespace: str, kind: int, centre: ArrayLike, size: ArrayLike, paint: ColorRGBA
) -> Marker:
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD, color=paint)
    marker.pose.orientation.w = 1.0
    marker.pose.position = filled(Point, centre)
    marker.scale = filled(Vector3, size)
    return marker


def _mesh(namespace: str, triangles: list[NDArray[np.float64]], paint: ColorRGBA) -> Marker:
    marker = _shape(namespace, Marker.TRIANGLE_LIST, np.zeros(3), np.ones(3), paint)
    marker.points = points_of(np.concatenate(triangles))
    return marker


def _fan(polygon: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Triangles (3, 3) of a convex polygon (n, 3)."""
    return [polygon[[0, i, i + 1]] for i in range(1, len(polygon) - 1)]


def _strip(one: NDArray[np.float64], other: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Triangles between two closed polygons with the same number of corners (n, 3)."""
    a, b = np.roll(one, -1, axis=0), np.roll(other, -1, axis=0)
    return [
        np.array(corners)
        for i in range(len(one))
        for corners in ((one[i], a[i], b[i]), (one[i], b[i], other[i]))
    ]

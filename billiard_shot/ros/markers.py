"""Markers in the frame of the table, of the kinds that the displays need."""

from collections.abc import Iterable

from geometry_msgs.msg import Point, Vector3
import numpy as np
from numpy.typing import ArrayLike
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from billiard_shot.records import Array
from billiard_shot.ros.conversions import filled


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


def shape(
    namespace: str,
    kind: int,
    paint: ColorRGBA,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    size: ArrayLike = (1.0, 1.0, 1.0),
) -> Marker:
    """Marker of a type, with a centre (3,) and a size (3,) [m]."""
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD, color=paint)
    marker.pose.orientation.w = 1.0
    marker.pose.position = filled(Point, centre)
    marker.scale = filled(Vector3, size)
    return marker


def ball(namespace: str, centre: ArrayLike, radius: float, paint: ColorRGBA) -> Marker:
    """Ball with a centre (3,) and a radius [m]."""
    return shape(namespace, Marker.SPHERE, paint, centre, np.full(3, 2 * radius))


def label(text: str, place: ArrayLike, height: float, paint: ColorRGBA) -> Marker:
    """Text of a height [m] that faces the viewer, at a place (3,) [m]."""
    marker = shape('labels', Marker.TEXT_VIEW_FACING, paint, place, (0.0, 0.0, height))
    marker.text = text
    return marker


def solids(namespace: str, ends: Iterable[tuple[Array, Array]], paint: ColorRGBA) -> Marker:
    """Solids between two convex polygons (n, 3) [m] with the same number of corners each."""
    triangles = []
    for one, other in ends:
        for i in range(len(one)):
            triangles += [one[[i - 1, i]], other[[i]], one[[i - 1]], other[[i - 1, i]]]
        for polygon in (one, other):
            triangles += [polygon[[0, i, i + 1]] for i in range(1, len(polygon) - 1)]
    marker = shape(namespace, Marker.TRIANGLE_LIST, paint)
    marker.points = points_of(np.concatenate(triangles))
    return marker


def points_of(points: Array) -> list[Point]:
    """Convert an array (n, 3) to points."""
    return [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]

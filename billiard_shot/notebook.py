"""Objects that notebooks show with a picture and a table."""


class Shown:
    """An object for which `billiard_shot.pictures.notebook` makes HTML, when it is shown."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        from billiard_shot.pictures.notebook import html_of

        return html_of(self)

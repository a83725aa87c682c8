"""x"""
VALUES: dict[tuple[str, str, str], tuple[float, tuple[tuple[float, ...], ...]]] = {}

"""The rows of tables of materials: angles of view, and the format of numbers."""

ELEVATIONS = (75, 40, 12)
# Elevation of the one, elevation of the other, azimuth between them (degrees).
PAIRS = ((75, 50, 150), (40, 30, 100), (12, 25, 170))


def numbers(albedos, values):
    """Directional albedos (red, green, blue) at `ELEVATIONS`; BSDFs times the cosine (1/sr) of
    `PAIRS`."""
    words = [f"{number:.4f}" for color in albedos for number in color]
    return " ".join(words + [f"{number:.4g}" for color in values for number in color])

"""Types of the extension module; `help` has what each name means."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, ClassVar, Literal, TypeVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path = str | PathLike[str]
_Vector = tuple[float, float, float] | Sequence[float]
_Color = float | _Vector
_Paint = _Color | NDArray[Any]
_Number = float | NDArray[Any]
_Clamp = Literal["auto", "off"] | float
_Filter = Literal["box", "tent", "gaussian", "blackman-harris"]
_Vpls = VplSet | int
_Progress = Callable[[int, int, int, int], object]
_Method = Literal[
    "tashika",
    "tashika-certified",
    "exact",
    "lightcuts",
    "mdlc",
    "nabata2016",
    "sakai2018",
    "iwasaki2019",
    "path",
]
_T = TypeVar("_T")

__version__: str

@final
class Scene:
    """A scene: surfaces, lights and cameras, ready to be rendered."""

    @property
    def name(self) -> str: ...
    @property
    def triangles(self) -> dict[str, int]: ...
    @property
    def cameras(self) -> dict[str, tuple[int, int] | None]: ...
    @property
    def triangles_without_area(self) -> int: ...
    @property
    def animated_seconds(self) -> list[float] | None: ...
    @property
    def time(self) -> float | None: ...
    @property
    def light_changes(self) -> list[str]: ...
    def at(self, seconds: float, *, shutter: tuple[float, float] | None = None) -> Scene: ...
    @property
    def notes(self) -> list[str]: ...
    @classmethod
    def build(
        cls,
        meshes: Sequence[Mesh],
        *,
        materials: Mapping[str, Material] | None = None,
        lights: Sequence[Light] = ...,
        camera: Camera | None = None,
        sky: _Paint | None = None,
        name: str = "scene",
    ) -> Scene: ...

@final
class Material:
    """What a mesh is made of."""

    @staticmethod
    def diffuse(reflectance: _Paint) -> Material: ...
    @staticmethod
    def phong(diffuse: _Paint, specular: _Paint, exponent: float) -> Material: ...
    @staticmethod
    def conductor(f0: _Color, alpha: _Number) -> Material: ...
    @staticmethod
    def coated(reflectance: _Paint, *, ior: float = 1.5, alpha: _Number | None = None) -> Material: ...
    @staticmethod
    def mirror(reflectance: _Paint) -> Material: ...
    @staticmethod
    def glass(*, ior: float = 1.5) -> Material: ...
    @staticmethod
    def boundary() -> Material: ...
    def emitting(self, radiance: _Paint, *, two_sided: bool = False) -> Material: ...

@final
class Medium:
    """What fills a space: fog, smoke, milk."""

    def __new__(
        cls,
        absorption: _Color,
        scattering: _Color,
        *,
        g: float = 0.0,
        density: ArrayLike | None = None,
        albedo: ArrayLike | None = None,
        transform: ArrayLike | None = None,
        name: str = "medium",
    ) -> Medium: ...

@final
class Mesh:
    """Triangles of one material."""

    def __new__(
        cls,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        material: Material | str,
        normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        transforms: ArrayLike | None = None,
        inside: Medium | None = None,
        outside: Medium | None = None,
        name: str = "",
    ) -> Mesh: ...

@final
class Light:
    """A light without surface."""

    @staticmethod
    def point(position: _Vector, intensity: _Color) -> Light: ...
    @staticmethod
    def spot(
        position: _Vector, direction: _Vector, intensity: _Color, *, inner: float = 0.0, outer: float = 45.0
    ) -> Light: ...
    @staticmethod
    def directional(direction: _Vector, irradiance: _Color) -> Light: ...

@final
class Camera:
    """A camera: perspective, orthographic, a fisheye, or one that sees all around."""

    def __new__(
        cls,
        eye: _Vector,
        target: _Vector,
        *,
        up: _Vector = ...,
        vertical_fov: float = 40.0,
        size: tuple[int, int] | None = None,
        name: str = "camera",
        lens_radius: float = 0.0,
        focus_distance: float | None = None,
        blades: int | None = None,
        blade_rotation: float = 0.0,
    ) -> Camera: ...
    def within(self, medium: Medium) -> Camera: ...
    @staticmethod
    def orthographic(
        eye: _Vector,
        target: _Vector,
        height: float,
        *,
        up: _Vector = ...,
        size: tuple[int, int] | None = None,
        name: str = "camera",
    ) -> Camera: ...
    @staticmethod
    def fisheye(
        eye: _Vector,
        target: _Vector,
        *,
        fov: float = 180.0,
        up: _Vector = ...,
        size: tuple[int, int] | None = None,
        name: str = "camera",
    ) -> Camera: ...
    @staticmethod
    def spherical(
        eye: _Vector,
        target: _Vector,
        *,
        equal_area: bool = False,
        up: _Vector = ...,
        size: tuple[int, int] | None = None,
        name: str = "camera",
    ) -> Camera: ...

@final
class VplSet:
    """A set of virtual point lights."""

    KINDS: ClassVar[list[str]]
    @property
    def positions(self) -> NDArray[np.float32] | NDArray[np.float64]: ...
    @property
    def normals(self) -> NDArray[np.float32]: ...
    @property
    def intensities(self) -> NDArray[np.float32]: ...
    @property
    def kinds(self) -> NDArray[np.uint32]: ...
    @property
    def instants(self) -> NDArray[np.float32]: ...
    @property
    def instant(self) -> NDArray[np.uint32]: ...
    @property
    def provenance(self) -> dict[str, Any]: ...
    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        normals: ArrayLike,
        intensities: ArrayLike,
        kinds: ArrayLike | None = None,
        *,
        scene: str = "",
        clamp: float = 0.0,
    ) -> VplSet: ...
    @classmethod
    def load(cls, path: _Path) -> VplSet: ...
    def save(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...

@final
class Image(Mapping[str, NDArray[Any]]):
    """An image: a mapping from names of planes to read-only arrays."""

    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def window(self) -> tuple[int, int, int, int]: ...
    @property
    def complete(self) -> bool: ...
    @property
    def tally(self) -> dict[str, int]: ...
    @property
    def picture_claim(self) -> dict[str, float | int | bool] | None: ...
    @property
    def metadata(self) -> dict[str, str | int | float | bool]: ...
    @property
    def planes(self) -> dict[str, dict[str, Any]]: ...
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def keys(self) -> list[str]: ...  # type: ignore[override]
    def values(self) -> list[NDArray[Any]]: ...  # type: ignore[override]
    def items(self) -> list[tuple[str, NDArray[Any]]]: ...  # type: ignore[override]
    def get(self, name: str, default: _T | None = None) -> NDArray[Any] | _T | None: ...  # type: ignore[override]
    def coverage(self, reference: Image, error: float | None = None) -> dict[str, Any]: ...
    def save(
        self,
        path: _Path,
        exr: str = "zip",
        *,
        tonemap: Literal["natural", "linear", "filmic", "aces", "agx"] = "natural",
        exposure: float | None = None,
    ) -> None: ...

@final
class Comparison:
    """How far an image is from a reference."""

    @property
    def error(self) -> float: ...
    @property
    def error_from(self) -> Literal["asked", "image", "default"]: ...
    @property
    def absolute(self) -> float: ...
    @property
    def pixels(self) -> int: ...
    @property
    def failed(self) -> int: ...
    @property
    def within_tolerance(self) -> float: ...
    @property
    def mean(self) -> float: ...
    @property
    def median(self) -> float: ...
    @property
    def p95(self) -> float: ...
    @property
    def worst(self) -> float: ...
    @property
    def worst_at(self) -> tuple[int, int]: ...
    @property
    def bias(self) -> float: ...
    @property
    def relative_l1(self) -> float: ...
    @property
    def reference_error(self) -> float | None: ...
    @property
    def rmse(self) -> float | None: ...
    @property
    def relmse(self) -> float | None: ...
    @property
    def psnr(self) -> float | None: ...
    @property
    def ssim(self) -> float | None: ...
    @property
    def flip(self) -> float | None: ...
    @property
    def exposure_stops(self) -> float | None: ...
    @property
    def infinite(self) -> int: ...
    @property
    def left_out(self) -> dict[str, int]: ...
    @property
    def claims_kept(self) -> float | None: ...
    @property
    def claims(self) -> dict[str, Any] | None: ...
    @property
    def picture(self) -> dict[str, Any] | None: ...
    @property
    def intervals(self) -> dict[str, Any] | None: ...
    @property
    def errors(self) -> NDArray[np.float64]: ...
    def save(
        self,
        path: _Path,
        *,
        tonemap: Literal["natural", "linear", "filmic", "aces", "agx"] = "natural",
    ) -> None: ...

def load(
    path: _Path,
    *,
    at: float | None = None,
    shutter: tuple[float, float] | None = None,
    environment: str | None = None,
    lights: Sequence[str] = ...,
    allow_outside: bool = False,
    allow_missing: bool = False,
    strict: bool = False,
) -> Scene: ...
def builtin(name: Literal["room", "tiny"]) -> Scene: ...
def read(path: _Path) -> Image: ...
def merge(parts: Iterable[Image], *, denoiser: str | PathLike[str] | None = None) -> Image: ...
def vpls(
    scene: Scene,
    *,
    count: int | None = None,
    seed: int = 1,
    clamp: _Clamp | None = None,
    instants: int | None = None,
    threads: int = 0,
) -> VplSet: ...
def render(
    scene: Scene,
    *,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    crop: tuple[int, int, int, int] | None = None,
    method: _Method = "tashika",
    error: float | None = None,
    confidence: float | None = None,
    claim: Literal["calibrated", "certified", "audited"] | None = None,
    truth: Literal["vpl", "transport", "clamped"] | None = None,
    vpls: _Vpls | None = None,
    gather: int | None = None,
    seed: int = 1,
    threads: int = 0,
    max_pairs: int | None = None,
    absolute: float | None = None,
    control: Literal["luminance", "channels"] | None = None,
    tiles: str | tuple[int, int] | None = None,
    clamp: _Clamp | None = None,
    paths: int | None = None,
    filter: _Filter | None = None,
    checkpoint: _Path | None = None,
    progress: _Progress | None = None,
    projection: Literal["perspective", "fisheye", "spherical", "equal-area"] | None = None,
    fov: float | None = None,
    lens_radius: float | None = None,
    focus_distance: float | None = None,
    blades: int | None = None,
    blade_rotation: float | None = None,
    quality: Literal["draft", "good", "final"] | None = None,
    share: float | None = None,
    assurance: float | None = None,
    audit: int | None = None,
    time: float | None = None,
    denoiser: str | PathLike[str] | None = None,
    cryptomatte: bool | int | None = None,
    groups: str | dict[str, list[str]] | None = None,
    motion_vectors: bool = False,
    instants: int | None = None,
    passes: int | None = None,
) -> Image: ...
def exact(
    scene: Scene,
    pixels: Sequence[tuple[int, int]],
    *,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    vpls: _Vpls | None = None,
    gather: int | None = None,
    clamp: _Clamp | None = None,
    instants: int | None = None,
    seed: int = 1,
    threads: int = 0,
    filter: _Filter | None = None,
    progress: _Progress | None = None,
) -> NDArray[np.float32]: ...
def sensors(
    scene: Scene,
    points: ArrayLike | _Path | None = None,
    *,
    grid: str | None = None,
    shape: Literal["plane", "cylinder", "sphere"] = "plane",
    photometry: Literal["scene", "cie", "radiance"] = "scene",
    error: float | None = None,
    absolute: float | None = None,
    confidence: float | None = None,
    claim: Literal["calibrated", "certified"] | None = None,
    jointly: bool = False,
    method: _Method = "tashika",
    vpls: int | None = None,
    clamp: _Clamp | None = None,
    max_pairs: int | None = None,
    paths: int | None = None,
    seed: int = 1,
    threads: int = 0,
    progress: _Progress | None = None,
) -> dict[str, Any]: ...
def compare(
    image: Image, reference: Image, error: float | None = None, absolute: float | None = None
) -> Comparison: ...
def coverage(
    scene: Scene,
    *,
    methods: Sequence[str] | None = None,
    errors: Sequence[float] = ...,
    confidences: Sequence[float] = ...,
    pixels: int | None = 200,
    seeds: int = 1,
    by: Sequence[Literal["brightness", "material"]] = ...,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    vpls: _Vpls | None = None,
    gather: int | None = None,
    clamp: _Clamp | None = None,
    instants: int | None = None,
    seed: int = 1,
    threads: int = 0,
    max_pairs: int | None = None,
    filter: _Filter | None = None,
    progress: _Progress | None = None,
) -> list[dict[str, Any]]: ...

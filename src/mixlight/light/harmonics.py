"""Real spherical harmonics up to degree 6: basis, projection, evaluation, irradiance, rotation.

Coefficients are radiance, orthonormal, index ``l*l + l + m``, all plus: the polynomials of Ramamoorthi and
Hanrahan, "An efficient representation for irradiance environment maps" (SIGGRAPH 2001), evaluated in our
frame's x, y and z (+X right, +Y up, -Z forward). In the angles' words, with the polar angle t from +Z and the
azimuth p from +X to +Y::

    B_lm = N_lm P_l^|m|(cos t) * (sqrt(2) cos(m p) | 1 | sqrt(2) sin(|m| p))   for m > 0 | m = 0 | m < 0

with P_l^m free of the Condon-Shortley sign.
"""

import math
from functools import lru_cache

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mixlight.sphere.equirect import row_solid_angle
from mixlight.sphere.points import vogel

MAX_DEGREE = 6


def count(degree: int) -> int:
    """Number of coefficients up to a degree, (degree + 1)^2.

    Raises:
        ValueError: the degree is not a whole number from 0 to 6.

    >>> count(2)
    9
    """
    if degree != int(degree) or not 0 <= degree <= MAX_DEGREE:
        raise ValueError(f"degree: expected a whole number from 0 to {MAX_DEGREE}, received {degree!r}")
    return (degree + 1) ** 2


def degree_of(coefficients: Float[Tensor, "*batch k channels"]) -> int:
    """Degree of a set of coefficients, read from its second to last axis.

    Raises:
        ValueError: that axis is no square of 1 to 7.

    >>> degree_of(torch.zeros(9, 3))
    2
    """
    size = coefficients.shape[-2]
    degree = math.isqrt(size) - 1
    if not 0 <= degree <= MAX_DEGREE or (degree + 1) ** 2 != size:
        raise ValueError(
            "coefficients: expected (degree + 1)^2 of them for a degree of 0 to "
            f"{MAX_DEGREE} on the second to last axis, received shape {tuple(coefficients.shape)}"
        )
    return degree


def degrees(degree: int) -> Int[Tensor, " k"]:
    """The degree l of each coefficient, in storage order.

    >>> degrees(2).tolist()
    [0, 1, 1, 1, 2, 2, 2, 2, 2]
    """
    count(degree)
    return torch.tensor([band for band in range(degree + 1) for _ in range(2 * band + 1)], device="cpu")


def basis(directions: Float[Tensor, "*points 3"], degree: int = 2) -> Float[Tensor, "*points k"]:
    """Values of the (degree + 1)^2 basis functions at unit directions.

    They are polynomials in x, y and z, so there is no special case at a pole and gradients flow everywhere.

    Args:
        directions: unit vectors in our frame.
        degree: highest degree, 0 to 6.

    Convention: index l*l + l + m, all plus, so that 1 = (1, -1) is +y, 2 = (1, 0) is +z and 3 = (1, 1) is +x.
        Worked: at +Y, ``basis`` of degree 1 is (.282095, .488603, 0, 0).

    Raises:
        ValueError: the degree is out of range, or the last axis is not 3.

    >>> basis(torch.tensor([0.0, 1.0, 0.0]), degree=1)
    tensor([0.2821, 0.4886, 0.0000, 0.0000])
    """
    size = count(degree)
    if directions.shape[-1] != 3:
        raise ValueError(f"directions: expected a last axis of 3, received shape {tuple(directions.shape)}")
    x, y, z = directions.unbind(-1)
    values: list[Tensor] = [x] * size
    cosine, sine = torch.ones_like(x), torch.zeros_like(x)  # real and imaginary part of (x + iy)^m
    diagonal = 0.5 / math.sqrt(
        math.pi
    )  # normalised P_m^m without its (1 - z^2)^(m/2), which (x + iy)^m brings
    for m in range(degree + 1):
        before, polynomial = torch.zeros_like(z), torch.full_like(z, diagonal)
        for band in range(m, degree + 1):
            if band > m:
                a = math.sqrt((4 * band * band - 1) / (band * band - m * m))
                b = math.sqrt(max(0, (band - 1) ** 2 - m * m) / (4 * (band - 1) ** 2 - 1))
                before, polynomial = polynomial, a * (z * polynomial - b * before)
            centre = band * band + band
            if m == 0:
                values[centre] = polynomial
            else:
                values[centre + m] = math.sqrt(2.0) * polynomial * cosine
                values[centre - m] = math.sqrt(2.0) * polynomial * sine
        diagonal *= math.sqrt((2 * m + 3) / (2 * m + 2))
        cosine, sine = x * cosine - y * sine, x * sine + y * cosine
    return torch.stack(values, -1)


def project(
    panorama: Float[Tensor, "*batch height width channels"], degree: int = 2
) -> Float[Tensor, "*batch k channels"]:
    """Projection of a panorama's radiance onto the basis, weighted by solid angle.

    Convention: the plain sum::

        L_k = sum over texels of radiance * B_k(texel centre) * solid angle

    The sum is separable: one matrix product takes each row to its Fourier terms cos and sin of m times the
    azimuth, a small one takes the rows to coefficients. It costs about as much as reading the panorama once.

    Args:
        panorama: radiance, 2:1; may be negative (a difference of two panoramas).
        degree: highest degree, 0 to 6.

    Convention: a panorama of radiance 1 has L_0 = 2 sqrt(pi) = 3.544908 and zeros elsewhere (up to the grid's
        error of order height^-2); L_0 sqrt(4 pi) is the panorama's energy exactly.

    Raises:
        ValueError: the degree is out of range, or the panorama is not 2:1.

    Source: the projection of Ramamoorthi and Hanrahan 2001, eq. 3, as a sum with exact texel solid angles.

    >>> project(torch.ones(16, 32, 3), degree=1)[:, 0].round(decimals=4).abs()
    tensor([3.5449, 0.0000, 0.0000, 0.0000])
    """
    height, width = panorama.shape[-3:-1]
    _check_2_to_1(height, width)
    return project_rows(row_sums(panorama, degree), degree)


def row_sums(
    rows: Float[Tensor, "*batch height width channels"], degree: int
) -> Float[Tensor, "*batch height terms channels"]:
    """Fourier sums of panorama rows over the azimuth: the first half of `project`, for callers who work band
    by band.

    Terms are 1, cos a, sin a, cos 2a, sin 2a, ... (2 degree + 1 of them), summed over the texels of a row;
    the azimuth a is 0 at the image centre (-Z) and grows to the right.

    >>> row_sums(torch.ones(1, 8, 1), degree=1)[0, :, 0].abs().round(decimals=4)
    tensor([8., 0., 0.])
    """
    dtype = _at_least_single(rows.dtype)
    width, channels = rows.shape[-2:]
    if channels > 4:
        return _fourier(degree, width).to(device=rows.device, dtype=dtype) @ rows.to(dtype)
    # One product for all channels, three quarters of it with zeros, is twice as fast as one product a row.
    table = _fourier_interleaved(degree, width, channels, dtype).to(rows.device)
    sums = rows.to(dtype).reshape(*rows.shape[:-2], width * channels) @ table
    return sums.reshape(*rows.shape[:-2], 2 * degree + 1, channels)


def project_rows(
    sums: Float[Tensor, "*batch height terms channels"], degree: int
) -> Float[Tensor, "*batch k channels"]:
    """Coefficients from the row sums of a whole panorama (height rows, 2 height texels in each): see
    `project`.

    >>> coefficients = project_rows(row_sums(torch.ones(8, 16, 3), degree=2), degree=2)
    >>> tuple(coefficients.shape), round(float(coefficients[0, 0]), 6)
    ((9, 3), 3.544908)
    """
    height = sums.shape[-3]
    weight = row_solid_angle(height, dtype=torch.float64)
    table = (_row_series(degree, height) * weight[:, None]).flatten(1).to(sums)
    return table @ sums.flatten(-3, -2)


def evaluate(
    coefficients: Float[Tensor, "*batch k channels"], directions: Float[Tensor, "*points 3"]
) -> Float[Tensor, "... channels"]:
    """Radiance of the expansion at unit directions; shape [*batch, *points, channels]. It may be negative.

    Convention: coefficients (1, 0, 0, 0) have the radiance .282095 everywhere.

    Raises:
        ValueError: the coefficients are no (degree + 1)^2, or the directions' last axis is not 3.

    >>> evaluate(torch.eye(4)[:, 1:2], torch.tensor([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]))[:, 0]
    tensor([ 0.4886, -0.4886])
    """
    table = basis(directions, degree_of(coefficients))
    dtype = torch.promote_types(table.dtype, coefficients.dtype)
    flat = table.to(dtype).reshape(-1, table.shape[-1]) @ coefficients.to(dtype)
    return flat.reshape(*coefficients.shape[:-2], *directions.shape[:-1], coefficients.shape[-1])


def evaluate_map(
    coefficients: Float[Tensor, "*batch k channels"], height: int
) -> Float[Tensor, "*batch height width channels"]:
    """Radiance of the expansion at the texel centres of a panorama [*batch, height, 2 height, channels], not
    clamped.

    Convention: row 0 is +Y, the image centre is -Z; coefficient 1 = (1, -1) alone is bright above and dark
        below.

    Raises:
        ValueError: the coefficients are no (degree + 1)^2, or height is below 1.

    >>> evaluate_map(torch.tensor([[0.0], [1.0], [0.0], [0.0]]), height=2)[:, 0, 0]
    tensor([ 0.3455, -0.3455])
    """
    degree = degree_of(coefficients)
    if height < 1:
        raise ValueError(f"height: expected at least 1, received {height}")
    dtype = _at_least_single(coefficients.dtype)
    table = _row_series(degree, height).flatten(1).T.to(device=coefficients.device, dtype=dtype)
    rows = (table @ coefficients.to(dtype)).reshape(
        *coefficients.shape[:-2], height, 2 * degree + 1, coefficients.shape[-1]
    )
    fourier = _fourier(degree, 2 * height).T.to(device=coefficients.device, dtype=dtype)
    return (fourier @ rows).to(coefficients.dtype)


def cosine_kernel(degree: int) -> Float[Tensor, " degrees"]:
    """Factors A_l that turn radiance coefficients into irradiance, one for each degree 0 to ``degree``, in
    float64.

    A_l = pi, 2 pi / 3, pi / 4, 0, -pi / 24, 0, pi / 64: the clamped cosine's own harmonics (Ramamoorthi and
    Hanrahan 2001, eq. 8).

    >>> cosine_kernel(2)
    tensor([3.1416, 2.0944, 0.7854], dtype=torch.float64)
    """
    count(degree)
    return torch.tensor([cosine_factor(band) for band in range(degree + 1)], dtype=torch.float64)


def cosine_factor(band: int) -> float:
    """Factor A_l of one degree l, any l >= 0: see `cosine_kernel`.

    >>> round(cosine_factor(4), 6)
    -0.1309
    """
    if band == 0:
        return math.pi
    if band == 1:
        return 2 * math.pi / 3
    if band % 2:
        return 0.0
    half = band // 2
    sign = 1 if half % 2 else -1
    return sign * 2 * math.pi / ((band + 2) * (band - 1)) * (math.comb(band, half) / (1 << band))


def irradiance(
    coefficients: Float[Tensor, "*batch k channels"], normals: Float[Tensor, "*points 3"]
) -> Float[Tensor, "... channels"]:
    """Irradiance of the expansion on surfaces with the given unit normals; shape [*batch, *points, channels].

    E(n) = sum of A_l L_lm B_lm(n). A Lambertian surface then shows the radiance albedo E / pi.

    Convention: radiance 1 all around gives the irradiance pi.

    >>> irradiance(torch.tensor([[3.544908]]), torch.tensor([0.0, 1.0, 0.0]))
    tensor([3.1416])
    """
    degree = degree_of(coefficients)
    factors = cosine_kernel(degree)[degrees(degree)].to(coefficients)
    return evaluate(coefficients * factors[:, None], normals)


def rotate(
    coefficients: Float[Tensor, "*batch k channels"], rotation: Float[Tensor, "*turns 3 3"]
) -> Float[Tensor, "... k channels"]:
    """Coefficients of the light turned by a rotation, exact for any degree; batches broadcast.

    The result's value at R d is the input's value at d. The turning matrix is solved for on a fixed set of
    directions D in float64, B(R D) = M B(D), degree by degree; degrees do not mix.

    Convention: as `mixlight.sphere.equirect.rotate`. Turning a lobe at +X by 90 degrees about +Y (x -> -z)
        puts it at -Z: coefficient 3 = (1, 1) moves to 2 = (1, 0) with a minus sign.

    Raises:
        ValueError: the rotation is no orthogonal 3x3 matrix, or the coefficients are no (degree + 1)^2.

    >>> turn = torch.tensor([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    >>> rotate(torch.eye(4)[:, 3:], turn)[:, 0].round(decimals=4) + 0.0
    tensor([ 0.,  0., -1.,  0.])
    """
    if rotation.shape[-2:] != (3, 3):
        raise ValueError(f"rotation: expected shape [..., 3, 3], received {tuple(rotation.shape)}")
    exact = rotation.double()
    error = (exact @ exact.mT - torch.eye(3, dtype=torch.float64, device=exact.device)).abs().max()
    if not error < 1e-4:
        raise ValueError(
            f"rotation: expected an orthogonal matrix, received one that is off by {float(error):.2g}"
        )
    degree = degree_of(coefficients)
    points, inverse, same_degree = (table.to(rotation.device) for table in _rotation_tables(degree))
    turned = basis((exact.unsqueeze(-3) @ points.unsqueeze(-1)).squeeze(-1), degree)  # [*turns, S, K]
    matrix = (turned.mT @ inverse) * same_degree
    return matrix.to(coefficients) @ coefficients


def mirror(coefficients: Float[Tensor, "*batch k channels"]) -> Float[Tensor, "*batch k channels"]:
    """Coefficients of the light seen in a mirror, left and right exchanged (x -> -x).

    Convention: of the first nine, (1, 1), (2, -2) and (2, 1) change their sign: those that are odd in x.

    >>> mirror(torch.ones(9, 1))[:, 0]
    tensor([ 1.,  1.,  1., -1., -1.,  1.,  1., -1.,  1.])
    """
    degree = degree_of(coefficients)
    signs = [
        float((-1) ** m if m >= 0 else (-1) ** (m + 1))
        for band in range(degree + 1)
        for m in range(-band, band + 1)
    ]
    return coefficients * torch.tensor(signs).to(coefficients)[:, None]


def _check_2_to_1(height: int, width: int) -> None:
    if width != 2 * height or height < 1:
        raise ValueError(
            f"panorama: expected [..., height, 2 height, channels], received height {height}, width {width}"
        )


def _at_least_single(dtype: torch.dtype) -> torch.dtype:
    """Sums over a sphere of texels in half precision would be worthless."""
    return torch.promote_types(dtype, torch.float32)


@lru_cache(maxsize=8)
def _fourier(degree: int, width: int) -> Tensor:
    """[2 degree + 1, width] in float64: 1, cos a, sin a, cos 2a, ... at the texel centres. Read-only."""
    count(degree)
    with torch.inference_mode(False):  # a cached inference tensor could never meet autograd again
        azimuth = ((torch.arange(width, dtype=torch.float64, device="cpu") + 0.5) / width - 0.5) * (
            2 * math.pi
        )
        return _harmonics_of(azimuth, degree)


@lru_cache(maxsize=8)
def _fourier_interleaved(degree: int, width: int, channels: int, dtype: torch.dtype) -> Tensor:
    """[width * channels, terms * channels]: `_fourier` for rows whose channels lie interleaved. Read-only."""
    with torch.inference_mode(False):
        table = _fourier(degree, width).T[:, None, :, None]
        same = torch.eye(channels, dtype=table.dtype, device="cpu")[:, None, :]
        return (table * same).reshape(width * channels, -1).to(dtype)


def _harmonics_of(azimuth: Tensor, degree: int) -> Tensor:
    terms = [torch.ones_like(azimuth)]
    for m in range(1, degree + 1):
        terms += [torch.cos(m * azimuth), torch.sin(m * azimuth)]
    return torch.stack(terms)


@lru_cache(maxsize=8)
def _row_series(degree: int, height: int) -> Tensor:
    """[k, height, 2 degree + 1] in float64: each basis function along each row, as a Fourier series.
    Read-only.

    Along a row (a circle around +Y) a polynomial of degree l is a trigonometric polynomial of degree l, which
    2 degree + 1 samples determine. So our z-based harmonics need no turning into y-based ones.
    """
    with torch.inference_mode(False):
        samples = 2 * degree + 1
        azimuth = torch.arange(samples, dtype=torch.float64, device="cpu") * (2 * math.pi / samples)
        polar = (torch.arange(height, dtype=torch.float64, device="cpu") + 0.5) * (math.pi / height)
        sine, cosine = torch.sin(polar)[:, None], torch.cos(polar)[:, None]
        directions = torch.stack(
            [sine * torch.sin(azimuth), cosine.expand(-1, samples), -sine * torch.cos(azimuth)], dim=-1
        )
        analysis = _harmonics_of(azimuth, degree) * (2.0 / samples)
        analysis[0] /= 2
        return torch.einsum("hsk,fs->khf", basis(directions, degree), analysis).contiguous()


@lru_cache(maxsize=8)
def _rotation_tables(degree: int) -> tuple[Tensor, Tensor, Tensor]:
    """Fixed directions [S, 3], the pseudo-inverse [S, k] of their basis, and where two degrees agree [k,
    k].
    """
    size = count(degree)
    with torch.inference_mode(False):
        points = vogel(4 * size, dtype=torch.float64, device="cpu")
        inverse = torch.linalg.pinv(basis(points, degree).T)  # [S, k]
        band = degrees(degree)
        return points, inverse, (band[:, None] == band[None, :]).double()

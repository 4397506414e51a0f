"""The rough lobes of docs/path-tracing.md as BSDFs of Mitsuba 3, written from the papers that they follow.

Mitsuba's own rough lobes differ by two things, for which its pictures cannot be compared to the last percent. They lose the light
that microfacets send to each other; and their masking is the product of that of both directions, where eosphor's is correlated by
height (Heitz 2014). `eosphor_glass` is Mitsuba's `roughdielectric` with both made up for; `eosphor_opaque` is a matte base under a
layer, or metal. Tables of albedos are integrated here, by the method of Heitz (2018, "Sampling the GGX distribution of visible
normals"), not read from eosphor. Thin glass and shares between metal, glass and base are not there.
"""

import json

import drjit as dr
import mitsuba as mi
import numpy as np

NODES = 256
SIDE = 96


def visible_normals(cos, alpha):
    """The direction, in the plane of x and z; SIDE x SIDE microfacet normals as seen from there; the part that each stands for."""
    to_viewer = np.array([np.sqrt(1 - cos * cos), 0, cos])
    u = (np.arange(SIDE) + 0.5) / SIDE
    # Dense at the rim of the disk, where normals are steep.
    part = np.broadcast_to(3 * (1 - u) ** 2 / SIDE**2, (SIDE, SIDE))
    u, v = np.meshgrid(1 - (1 - u) ** 3, u)
    stretched = to_viewer * [alpha, alpha, 1]
    stretched /= np.linalg.norm(stretched)
    # y is across: the viewer's direction lies in the plane of x and z.
    across = np.array([0.0, 1.0, 0.0])
    up = np.cross(stretched, across)
    r, phi = np.sqrt(u), 2 * np.pi * v
    a, b = r * np.cos(phi), r * np.sin(phi)
    s = 0.5 * (1 + stretched[2])
    b = (1 - s) * np.sqrt(np.maximum(1 - a * a, 0)) + s * b
    c = np.sqrt(np.maximum(1 - a * a - b * b, 0))
    n = a[..., None] * across + b[..., None] * up + c[..., None] * stretched
    n = n * [alpha, alpha, 1]
    n[..., 2] = np.maximum(n[..., 2], 1e-9)
    return to_viewer, n / np.linalg.norm(n, axis=-1, keepdims=True), part / part.sum()


def smith(cos, alpha):
    """Smith's lambda."""
    c2 = np.maximum(cos * cos, 1e-12)
    return 0.5 * (np.sqrt(1 + alpha * alpha * (1 / c2 - 1)) - 1)


def fresnel(cos, eta):
    """Of a dielectric, and the cosine on the other side."""
    sine2 = (1 - cos * cos) / (eta * eta)
    beyond = np.sqrt(np.maximum(1 - sine2, 0))
    s, p = (cos - eta * beyond) / (cos + eta * beyond), (beyond - eta * cos) / (beyond + eta * cos)
    return np.where(sine2 >= 1, 1.0, 0.5 * (s * s + p * p)), beyond


def mirror_albedos(alpha):
    """Over the square root of the cosine: what a white mirror loses, and what Schlick's (1 - cos)^5 weighs of the rest."""
    lost, grazing = [], []
    for x in np.linspace(0, 1, NODES):
        cos = max(x * x, 1e-5)
        i, h, part = visible_normals(cos, alpha)
        ih = h @ i
        o = 2 * ih * h[..., 2] - cos
        weight = np.where(o > 0, (1 + smith(cos, alpha)) / (1 + smith(cos, alpha) + smith(o, alpha)), 0)
        lost.append(1 - (part * weight).sum())
        grazing.append((part * weight * np.maximum(1 - ih, 0) ** 5).sum())
    return np.array(lost), np.array(grazing)


def mean_over_cosines(table):
    """Twice the integral of the table times the cosine."""
    x = np.linspace(0, 1, NODES)
    return float(np.trapezoid(table * x * x * 2 * x, x) * 2)


def glass_albedos(alpha, eta):
    """Over the square root of the cosine: what glass reflects and transmits by single scattering."""
    total = []
    for x in np.linspace(0, 1, NODES):
        cos = max(x * x, 1e-5)
        i, h, part = visible_normals(cos, alpha)
        ih = np.clip(h @ i, 0, 1)
        reflectance, beyond = fresnel(ih, eta)
        of = lambda o: np.where(o > 0, (1 + smith(cos, alpha)) / (1 + smith(cos, alpha) + smith(o, alpha)), 0)
        down = -(cos / -eta + (ih / eta - beyond) * h[..., 2])
        total.append((part * (reflectance * of(2 * ih * h[..., 2] - cos) + (1 - reflectance) * of(down))).sum())
    return np.array(total)


class Table:
    """Linear over the square root of a cosine."""

    def __init__(self, values):
        self.values = mi.Float(values.astype(np.float32))

    def __call__(self, cos):
        x = dr.sqrt(dr.clip(cos, 0, 1)) * (NODES - 1)
        node = dr.minimum(mi.UInt32(x), NODES - 2)
        a, b = dr.gather(mi.Float, self.values, node), dr.gather(mi.Float, self.values, node + 1)
        return dr.fma(x - mi.Float(node), b - a, a)


def smith_of(cos, alpha):
    return 0.5 * (dr.sqrt(1 + alpha * alpha * (1 / dr.maximum(cos * cos, 1e-12) - 1)) - 1)


class Opaque(mi.BSDF):
    """Metal, or a matte base under a layer: GGX with Schlick's reflectance, Kulla and Conty's lobe for what is lost, and the base by
    Kelemen and Szirmay-Kalos."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        pbr = json.loads(props["pbr"])
        color, is_metal = np.array(pbr["color"], dtype=float), pbr.get("metallic", 0) == 1
        ior, weight = pbr.get("ior", 1.5), pbr.get("specular", 1.0)
        self.alpha = pbr["roughness"] ** 2
        f0 = color if is_metal else np.full(3, weight * ((ior - 1) / (ior + 1)) ** 2)
        f90 = np.full(3, 1.0 if is_metal else weight)
        base = np.zeros(3) if is_metal else color
        lost, grazing = mirror_albedos(self.alpha)
        mean_lost, mean_grazing = mean_over_cosines(lost), mean_over_cosines(grazing)
        once = f0 * (20 / 21) + f90 / 21
        multiple = once * once * (1 - mean_lost) / (1 - once * mean_lost)
        below_mean = 1 - (f0 * (1 - mean_lost - mean_grazing) + f90 * mean_grazing + multiple * mean_lost)
        self.f0, self.f90, self.multiple = mi.Color3f(f0), mi.Color3f(f90), mi.Color3f(multiple)
        self.base = mi.Color3f(base / (np.pi * below_mean)) if not is_metal else mi.Color3f(0)
        self.of_wide = mi.Color3f(multiple / (np.pi * mean_lost))
        self.lost, self.grazing = Table(lost), Table(grazing)
        self.wide = 0.1 if is_metal else 0.5
        self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
        self.m_flags = self.m_components[0]

    def below(self, cos):
        lost, grazing = self.lost(cos), self.grazing(cos)
        return 1 - (self.f0 * (1 - lost - grazing) + self.f90 * grazing + self.multiple * lost)

    def facets(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def sample(self, ctx, si, sample1, sample2, active=True):
        cos = mi.Frame3f.cos_theta(si.wi)
        active = mi.Bool(active) & (cos > 0)
        normal, _ = self.facets().sample(si.wi, sample2)
        is_wide = sample1 < self.wide
        bs = dr.zeros(mi.BSDFSample3f)
        bs.wo = dr.select(is_wide, mi.warp.square_to_cosine_hemisphere(sample2), mi.reflect(si.wi, normal))
        bs.pdf = self.pdf(ctx, si, bs.wo, active)
        bs.eta = 1.0
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        bs.sampled_component = mi.UInt32(0)
        active &= bs.pdf > 0
        return bs, dr.select(active, self.eval(ctx, si, bs.wo, active) / bs.pdf, mi.Color3f(0))

    def eval(self, ctx, si, wo, active=True):
        i, o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active = mi.Bool(active) & (i > 0) & (o > 0)
        h = dr.normalize(si.wi + wo)
        m = 1 - dr.dot(si.wi, h)
        m5 = dr.square(dr.square(m)) * m
        masking = 1 / (1 + smith_of(i, self.alpha) + smith_of(o, self.alpha))
        facets = (self.f0 * (1 - m5) + self.f90 * m5) * (self.facets().eval(h) * masking / (4 * i))
        wide = self.base * self.below(i) * self.below(o) + self.of_wide * (self.lost(i) * self.lost(o))
        return dr.select(active, facets + wide * o, mi.Color3f(0))

    def pdf(self, ctx, si, wo, active=True):
        i, o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active = mi.Bool(active) & (i > 0) & (o > 0)
        h = dr.normalize(si.wi + wo)
        facets = self.facets().pdf(si.wi, h) / (4 * dr.dot(wo, h))
        return dr.select(active, self.wide * o * dr.inv_pi + (1 - self.wide) * facets, 0)

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)


class Glass(mi.BSDF):
    """`roughdielectric` with masking that is correlated by height, over its own albedo (Turquin 2019)."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        pbr = json.loads(props["pbr"])
        assert pbr.get("color", [1, 1, 1]) == [1, 1, 1], "clear glass"
        ior, self.alpha = pbr.get("ior", 1.5), pbr["roughness"] ** 2
        self.inner = mi.load_dict({"type": "roughdielectric", "distribution": "ggx", "alpha": self.alpha, "int_ior": ior, "ext_ior": 1.0})
        self.outside, self.inside = Table(glass_albedos(self.alpha, ior)), Table(glass_albedos(self.alpha, 1 / ior))
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide | mi.BSDFFlags.NonSymmetric
        self.m_components = [mi.BSDFFlags.GlossyReflection | sides, mi.BSDFFlags.GlossyTransmission | sides]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def factor(self, si, wo):
        i, o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        a, b = smith_of(i, self.alpha), smith_of(o, self.alpha)
        albedo = dr.select(i > 0, self.outside(dr.abs(i)), self.inside(dr.abs(i)))
        return (1 + a) * (1 + b) / ((1 + a + b) * albedo)

    def sample(self, ctx, si, sample1, sample2, active=True):
        bs, weight = self.inner.sample(ctx, si, sample1, sample2, active)
        return bs, weight * self.factor(si, bs.wo)

    def eval(self, ctx, si, wo, active=True):
        return self.inner.eval(ctx, si, wo, active) * self.factor(si, wo)

    def pdf(self, ctx, si, wo, active=True):
        return self.inner.pdf(ctx, si, wo, active)

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)


mi.register_bsdf("eosphor_opaque", Opaque)
mi.register_bsdf("eosphor_glass", Glass)

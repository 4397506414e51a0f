"""Values of Mitsuba's BSDFs: python mitsuba_values.py COUNT > mitsuba.txt (pip install mitsuba==3.9.1), COUNT pairs a setting.

The file in the repository has 7. Half of the pairs of rough surfaces are its samples, half are any directions.
Pairs near the edge of what refracts are left out: there Mitsuba's single precision is off by up to 8 % of its formula in double
precision. From the cosines below on it is off by less than 0.0001.
"""
import math, random, sys
import mitsuba as mi
mi.set_variant('scalar_rgb')
count = int(sys.argv[1])
rng = random.Random(5)
ctx = mi.BSDFContext(mi.TransportMode.Importance)
ALPHAS = [0.02, 0.1, 0.3, 0.6, 1.0]
INDICES = [1.1, 1.33, 1.5, 2.0]

def direction(sign, least=0.02):
    z = rng.uniform(least, 1)
    phi = rng.uniform(0, 2 * math.pi)
    s = math.sqrt(1 - z * z)
    return [s * math.cos(phi), s * math.sin(phi), sign * z]

def interaction(wi):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wi)
    return si

def put(kind, alpha, eta, wi, wo, value):
    print(kind, *('%.9g' % x for x in [alpha, eta, *wi, *wo, value]))

def sampled(bsdf, wi):
    s, _ = bsdf.sample(ctx, interaction(wi), rng.random(), mi.Point2f(rng.random(), rng.random()))
    return s

def is_at_edge(wi, wo, eta):
    """Whether directions all but graze the microfacets between them, or all but reach the critical angle; `eta` is the
    index on the side of z < 0 over that of z > 0."""
    scale = [1.0 if w[2] > 0 else eta for w in (wi, wo)]
    h = [a * scale[0] + b * scale[1] for a, b in zip(wi, wo)]
    length = math.sqrt(sum(x * x for x in h))
    cosines = [abs(sum(a * b for a, b in zip(w, h))) / length for w in (wi, wo)]
    if wi[2] * wo[2] > 0:
        relative = eta if wi[2] > 0 else 1 / eta
        return abs(1 - (1 - cosines[0] ** 2) / relative ** 2) < 1e-3
    return min(cosines) < 0.1

def rough(kind, bsdf, alpha, index, side):
    """Towards the viewer is above the surface, on whichever side of Mitsuba's that is."""
    made = 0
    while made < count:
        wi = direction(side)
        if made % 2 == 0:
            s = sampled(bsdf, wi)
            wo = [float(x) for x in s.wo]
            if s.pdf == 0:
                continue
        else:
            wo = direction(1 if kind == 'metal' else rng.choice([1, -1]))
        value = float(bsdf.eval(ctx, interaction(wi), mi.Vector3f(*wo))[0])
        # What is next to nothing is rounded to few digits.
        if abs(wo[2]) < 0.02 or value < 1e-6 or (kind == 'glass' and is_at_edge(wi, wo, index)):
            continue
        put(kind, alpha, index if side > 0 else 1 / index, [wi[0], wi[1], wi[2] * side], [wo[0], wo[1], wo[2] * side], value)
        made += 1

print("# kind, alpha, index beyond over the viewer's, to the viewer, to the light, value times cosine (a flux)")
matte = mi.load_dict({'type': 'diffuse', 'reflectance': {'type': 'rgb', 'value': [.5] * 3}})
for _ in range(count):
    wi, wo = direction(1), direction(1)
    put('diffuse', 0, 1, wi, wo, float(matte.eval(ctx, interaction(wi), mi.Vector3f(*wo))[0]))
for alpha in ALPHAS:
    rough('metal', mi.load_dict({'type': 'roughconductor', 'material': 'none', 'alpha': alpha, 'distribution': 'ggx'}),
          alpha, 1, 1)
for index in INDICES:
    for alpha in ALPHAS:
        bsdf = mi.load_dict({'type': 'roughdielectric', 'int_ior': index, 'ext_ior': 1.0, 'alpha': alpha,
                             'distribution': 'ggx'})
        for side in [1, -1]:
            rough('glass', bsdf, alpha, index, side)
    pane = mi.load_dict({'type': 'thindielectric', 'int_ior': index, 'ext_ior': 1.0})
    for _ in range(count):
        wi = direction(1)
        s, _ = pane.sample(ctx, interaction(wi), 0.0, mi.Point2f(.5, .5))
        assert s.wo[2] > 0
        put('pane', 0, index, wi, [float(x) for x in s.wo], float(s.pdf))

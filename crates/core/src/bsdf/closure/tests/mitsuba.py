"""Values of Mitsuba's BSDFs: python mitsuba.py COUNT > mitsuba.txt (pip install mitsuba==3.9.1)."""
import math, random, sys
import mitsuba as mi
mi.set_variant('scalar_rgb')
count = int(sys.argv[1])
rng = random.Random(5)
ctx = mi.BSDFContext(mi.TransportMode.Importance)

def direction(sign, least=0.02):
    z = rng.uniform(least, 1)
    phi = rng.uniform(0, 2 * math.pi)
    s = math.sqrt(1 - z * z)
    return [s * math.cos(phi), s * math.sin(phi), sign * z]

def evaluate(bsdf, wi, wo):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wi)
    return float(bsdf.eval(ctx, si, mi.Vector3f(*wo))[0]), si

def put(kind, alpha, eta, wi, wo, value):
    print(kind, *('%.9g' % x for x in [alpha, eta, *wi, *wo, value]))

print("# kind, alpha, index beyond over the viewer's, to the viewer, to the light, value times cosine (a flux)")
kinds = ['diffuse', 'metal', 'glass', 'glass', 'glass', 'pane']
made = 0
while made < count:
    kind = kinds[made % len(kinds)]
    alpha = rng.choice([0.02, 0.1, 0.3, 0.6, 1.0])
    eta = rng.choice([1.1, 1.33, 1.5, 2.0])
    if kind == 'diffuse':
        wi, wo = direction(1), direction(1)
        v, _ = evaluate(mi.load_dict({'type': 'diffuse', 'reflectance': {'type': 'rgb', 'value': [.5] * 3}}), wi, wo)
        put(kind, 0, 1, wi, wo, v)
    elif kind == 'metal':
        wi = direction(1)
        b = mi.load_dict({'type': 'roughconductor', 'material': 'none', 'alpha': alpha, 'distribution': 'ggx'})
        si = mi.SurfaceInteraction3f(); si.wi = mi.Vector3f(*wi)
        s, _ = b.sample(ctx, si, .5, mi.Point2f(rng.random(), rng.random()))
        wo = [float(x) for x in s.wo]
        if wo[2] < 0.02: continue
        v, _ = evaluate(b, wi, wo)
        put(kind, alpha, 1, wi, wo, v)
    elif kind == 'glass':
        side = rng.choice([1, -1])
        b = mi.load_dict({'type': 'roughdielectric', 'int_ior': eta, 'ext_ior': 1.0, 'alpha': alpha, 'distribution': 'ggx'})
        wi = direction(side)
        si = mi.SurfaceInteraction3f(); si.wi = mi.Vector3f(*wi)
        s, _ = b.sample(ctx, si, rng.random(), mi.Point2f(rng.random(), rng.random()))
        wo = [float(x) for x in s.wo]
        if abs(wo[2]) < 0.02 or s.pdf == 0: continue
        v, _ = evaluate(b, wi, wo)
        if v == 0: continue
        put(kind, alpha, eta if side > 0 else 1 / eta, [wi[0], wi[1], wi[2] * side], [wo[0], wo[1], wo[2] * side], v)
    else:
        b = mi.load_dict({'type': 'thindielectric', 'int_ior': eta, 'ext_ior': 1.0})
        wi = direction(1)
        si = mi.SurfaceInteraction3f(); si.wi = mi.Vector3f(*wi)
        s, _ = b.sample(ctx, si, 0.0, mi.Point2f(.5, .5))
        assert s.wo[2] > 0
        put(kind, 0, eta, wi, [float(x) for x in s.wo], float(s.pdf))
    made += 1

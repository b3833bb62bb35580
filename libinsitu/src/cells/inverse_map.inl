// Physical point -> parametric coordinates. Included like shape_functions.inl.

/// What an inverse map found. margin: the smallest slack of the reference cell's inequalities at r
/// (0 on the boundary, negative outside), in parametric units.
template <class T>
struct InverseMap {
  Vec3<T> r;
  T margin;
  decltype(T(0.0) < T(0.0)) converged;
};

/// Newton's method for x(q) = p, where `map(q, x, a, b, c)` gives x and its three derivatives. Lanes
/// that have converged are frozen, so a pack gives the same bits as scalars one by one. The iterate is
/// kept within `reach` of the reference cell, which bounds it where the Jacobian is singular.
template <class T, class Map>
INSITU_HD inline decltype(T(0.0) < T(0.0)) newton(const Map& map, const Vec3<T>& p, Vec3<T>& q) {
  constexpr int most_iterations = 24;
  const T lowest(-2.0), highest(3.0), small(1e-8), zero(0.0), one(1.0);
  auto done = zero < zero;
  for (int i = 0; i < most_iterations; ++i) {
    Vec3<T> x, a, b, c;
    map(q, x, a, b, c);
    const Vec3<T> f = p - x;
    const Vec3<T> bc = cross(b, c);
    const T det = dot(a, bc);
    const auto singular = det == zero;
    const T inv = select(singular, zero, one / select(singular, one, det));
    const Vec3<T> step{dot(f, bc) * inv, dot(f, cross(c, a)) * inv, dot(f, cross(a, b)) * inv};
    const T size = larger(absolute(step.x), larger(absolute(step.y), absolute(step.z)));
    const Vec3<T> next{smaller(larger(q.x + step.x, lowest), highest),
                       smaller(larger(q.y + step.y, lowest), highest),
                       smaller(larger(q.z + step.z, lowest), highest)};
    q = {select(done, q.x, next.x), select(done, q.y, next.y), select(done, q.z, next.z)};
    // Quadratic convergence: a step below 1e-8 leaves an error at rounding. A singular Jacobian
    // makes a zero step, which proves nothing.
    done = done | ((!singular) & (size < small));
    if (all_of(done))
      break;
  }
  return done;
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_tetrahedron(const Vec3<T>* x, const Vec3<T>& p) {
  const T zero(0.0), one(1.0);
  const Vec3<T> a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0], f = p - x[0];
  const Vec3<T> bc = cross(b, c);
  const T det = dot(a, bc);
  const auto singular = det == zero;
  const T inv = one / select(singular, one, det);
  InverseMap<T> out;
  out.r = {dot(f, bc) * inv, dot(f, cross(c, a)) * inv, dot(f, cross(a, b)) * inv};
  out.margin = smaller(smaller(out.r.x, out.r.y), smaller(out.r.z, one - out.r.x - out.r.y - out.r.z));
  out.converged = !singular;
  return out;
}

/// The trilinear map in monomials of r, s, t, relative to vertex 0: fewer operations an iteration
/// than shape functions, and no cancellation at large offsets.
template <class T>
INSITU_HD inline InverseMap<T> inverse_hexahedron(Shape shape, const Vec3<T>* x, const Vec3<T>& p) {
  const int swap = shape == Shape::voxel ? 1 : 0;
  const Vec3<T> x0 = x[0];
  const Vec3<T> e1 = x[1] - x0, e2 = x[2 + swap] - x0, e3 = x[3 - swap] - x0, e4 = x[4] - x0,
                e5 = x[5] - x0, e6 = x[6 + swap] - x0, e7 = x[7 - swap] - x0;
  const Vec3<T> crs = e2 - e1 - e3, crt = e5 - e1 - e4, cst = e7 - e3 - e4;
  const Vec3<T> crst = e6 - e2 - (e5 - e1) - (e7 - e3) + e4;
  const auto map = [&](const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                       Vec3<T>& c) INSITU_LAMBDA {
    const Vec3<T> rs_t = crs + q.z * crst; // coefficient of r s
    a = e1 + q.y * rs_t + q.z * crt;
    b = e3 + q.x * rs_t + q.z * cst;
    c = e4 + q.x * (crt + q.y * crst) + q.y * cst;
    v = q.x * a + q.y * (e3 + q.z * cst) + q.z * e4;
  };
  InverseMap<T> out;
  out.r = {T(0.5), T(0.5), T(0.5)};
  out.converged = newton(map, p - x0, out.r);
  const T one(1.0);
  const auto slack = [&](const T& u) INSITU_LAMBDA { return smaller(u, one - u); };
  out.margin = smaller(slack(out.r.x), smaller(slack(out.r.y), slack(out.r.z)));
  return out;
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_wedge(const Vec3<T>* x, const Vec3<T>& p) {
  const Vec3<T> x0 = x[0];
  const Vec3<T> e1 = x[1] - x0, e2 = x[2] - x0, e3 = x[3] - x0;
  const Vec3<T> crt = (x[4] - x0) - e1 - e3, cst = (x[5] - x0) - e2 - e3;
  const auto map = [&](const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                       Vec3<T>& c) INSITU_LAMBDA {
    a = e1 + q.z * crt;
    b = e2 + q.z * cst;
    c = e3 + q.x * crt + q.y * cst;
    v = q.x * a + q.y * b + q.z * e3;
  };
  const T one(1.0);
  InverseMap<T> out;
  out.r = {T(1.0 / 3.0), T(1.0 / 3.0), T(0.5)};
  out.converged = newton(map, p - x0, out.r);
  out.margin = smaller(smaller(out.r.x, out.r.y),
                       smaller(one - out.r.x - out.r.y, smaller(out.r.z, one - out.r.z)));
  return out;
}

/// The pyramid in u = (1-t) r, v = (1-t) s, w = 1-t about its apex: p - apex = w A + u B + v C +
/// (u v / w) D is homogeneous of degree one, so Newton works as well near the apex, where r and s
/// cease to exist, as anywhere else. At the apex itself r = s = 1/2.
template <class T>
INSITU_HD inline InverseMap<T> inverse_pyramid(const Vec3<T>* x, const Vec3<T>& p) {
  const T zero(0.0), one(1.0), tiny(1e-300);
  const Vec3<T> ea = x[0] - x[4], eb = x[1] - x[0], ec = x[3] - x[0];
  const Vec3<T> ed = (x[2] - x[0]) - eb - ec;
  const auto map = [&](const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                       Vec3<T>& c) INSITU_LAMBDA {
    const T w = select(absolute(q.z) < tiny, tiny, q.z);
    const T r = q.x / w, s = q.y / w;
    a = eb + s * ed;
    b = ec + r * ed;
    c = ea - (r * s) * ed;
    v = q.x * eb + q.y * ec + q.z * ea + (q.x * s) * ed;
  };
  Vec3<T> q{T(0.25), T(0.25), T(0.5)};
  const Vec3<T> f = p - x[4];
  InverseMap<T> out;
  out.converged = newton(map, f, q);
  const auto apex = (f.x == zero) & (f.y == zero) & (f.z == zero);
  out.converged = out.converged | apex;
  q = {select(apex, zero, q.x), select(apex, zero, q.y), select(apex, zero, q.z)};
  const auto flat = absolute(q.z) < tiny;
  const T w = select(flat, one, q.z);
  out.r = {select(flat, T(0.5), q.x / w), select(flat, T(0.5), q.y / w), one - q.z};
  out.margin = smaller(smaller(q.x, q.z - q.x), smaller(smaller(q.y, q.z - q.y),
                                                        smaller(q.z, one - q.z)));
  return out;
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_map(Shape shape, const Vec3<T>* x, const Vec3<T>& p) {
  switch (shape) {
  case Shape::tetrahedron: return inverse_tetrahedron(x, p);
  case Shape::pyramid: return inverse_pyramid(x, p);
  case Shape::wedge: return inverse_wedge(x, p);
  default: return inverse_hexahedron(shape, x, p);
  }
}

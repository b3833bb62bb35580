// Physical point -> parametric coordinates. Included like shape_functions.inl.

/// What an inverse map found. margin: the smallest slack of the reference cell's inequalities at r
/// (0 on the boundary, negative outside), in parametric units; of a pyramid in r (1-t), s (1-t), t.
///
/// error is the certificate: an exact preimage of the point exists whose margin differs from
/// `margin` by less than it (all real arithmetic, for the doubles given). It is infinite where none
/// can be given. So margin > error proves a preimage in the interior of the reference cell: the
/// point is inside if the map is one-to-one, as on a mesh that validation found free of folds.
/// margin < -error proves nothing but for tetrahedra, since a curved map may have a second
/// preimage; what proves the outside is `filter`, contain_lanes.inl.
template <class T>
struct InverseMap {
  Vec3<T> r;
  T margin;
  decltype(T(0.0) < T(0.0)) converged;
  T error;
};

/// Whether the point is on the cell's boundary as far as the certificate tells, so that no other
/// cell will be proven to hold it either.
template <class T>
INSITU_HD inline auto is_on_boundary(const T& margin, const T& error) {
  const T m = absolute(margin);
  return ((m < error) | (m == error)) & (error < T(1e-6));
}

template <class T>
INSITU_HD inline T largest_of(const Vec3<T>& a) {
  return larger(absolute(a.x), larger(absolute(a.y), absolute(a.z)));
}
template <class T>
INSITU_HD inline Vec3<T> absolute_of(const Vec3<T>& a) {
  return {absolute(a.x), absolute(a.y), absolute(a.z)};
}

/// Newton's step at a point, from the columns of the Jacobian and the residual f.
template <class T>
struct NewtonStep {
  Vec3<T> f, bc, ca, ab; // the rows of the Jacobian's adjugate
  T inverse_det;         // 0 where singular
  Vec3<T> step;
  decltype(T(0.0) < T(0.0)) singular;

  /// What takes the map on by g, to first order.
  INSITU_HD inline Vec3<T> towards(const Vec3<T>& g) const {
    return {dot(g, bc) * inverse_det, dot(g, ca) * inverse_det, dot(g, ab) * inverse_det};
  }
};
template <class T>
INSITU_HD inline NewtonStep<T> newton_step(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c,
                                           const Vec3<T>& f) {
  const T zero(0.0), one(1.0);
  NewtonStep<T> n;
  n.f = f;
  n.bc = cross(b, c);
  n.ca = cross(c, a);
  n.ab = cross(a, b);
  const T det = dot(a, n.bc);
  n.singular = det == zero;
  n.inverse_det = select(n.singular, zero, one / select(n.singular, one, det));
  n.step = n.towards(f);
  return n;
}

/// The computed inverse A of the Jacobian against rounding, given a bound `scale` on the sum of the
/// map's coefficients in each component (the cell's own size, relative to vertex 0):
/// reach: the largest row sum of |A| scale, so what a rounding of the residual does to coordinates;
/// contraction: a bound on the row sums of |1 - A J|. With |r|, |s|, |t| <= 2 columns are at most
/// 4 scale each; Cramer's rule then errs by less than 2^13 roundings of scale.x scale.y scale.z /
/// det, and the columns themselves by 2^10 roundings of `reach`. sound: no overflow or underflow
/// had a part in it.
template <class T>
struct InverseQuality {
  T reach, contraction;
  decltype(T(0.0) < T(0.0)) sound;
};
template <class T>
INSITU_HD inline InverseQuality<T> inverse_quality(const NewtonStep<T>& n, const Vec3<T>& scale) {
  const T inv = absolute(n.inverse_det);
  const T rows = larger(dot(absolute_of(n.bc), scale),
                        larger(dot(absolute_of(n.ca), scale), dot(absolute_of(n.ab), scale)));
  InverseQuality<T> q;
  q.reach = rows * inv;
  q.contraction = T(0x1p-40) * (scale.x * scale.y * scale.z * inv) + T(0x1p-43) * q.reach;
  const T low = smaller(scale.x, smaller(scale.y, scale.z));
  const T high = larger(scale.x, larger(scale.y, scale.z));
  q.sound = (low > T(0x1p-150)) & (high < T(0x1p300)) & (q.contraction < T(0.25)) & (!n.singular);
  return q;
}

/// A step of Newton's method at q less what the second derivatives bend it by (Chebyshev's method,
/// of the third order). map.bend(q, d) is x(q + d) - x(q) but for the terms of first order in d.
template <class T>
struct BentStep {
  Vec3<T> step;
  T size, bend; // of the straight step, and of what bends it
};
template <class T, class Map>
INSITU_HD inline BentStep<T> bent_step(const Map& map, const Vec3<T>& q, const NewtonStep<T>& n) {
  const Vec3<T> by = n.towards(map.bend(q, n.step));
  BentStep<T> b;
  b.size = largest_of(n.step);
  b.bend = largest_of(by);
  const auto bends = b.bend < T(0.5) * b.size; // else the second derivatives say little
  b.step = {select(bends, n.step.x - by.x, n.step.x), select(bends, n.step.y - by.y, n.step.y),
            select(bends, n.step.z - by.z, n.step.z)};
  return b;
}

/// A bound in the maximum norm on the error of q + step, the step n.step but for a correction of at
/// most `bend`; infinite where there is none, or where it is not asked for (`if_in`). n: at q, with
/// largest_of(n.step) = size. scale: see inverse_quality. apex: q is a pyramid's, in u, v, w.
///
/// With A the computed inverse of the Jacobian at q, eta >= |A (x(q) - p)| and kappa >= |1 - A J|
/// within 2 eta of q (the maximum norm), kappa < 1/4, Banach's theorem for q - A (x(q) - p) gives
/// one preimage there, and it differs from q + n.step by at most kappa eta / (1 - kappa) and
/// roundings, from the answer by the bend as well. kappa is the rounding of A and, from the second
/// derivatives, at most 2 eta 43 reach / w, where w is 1, or in a pyramid 1 - t.
template <class T>
INSITU_INLINE T error_of_step(const decltype(T(0.0) < T(0.0))& if_in, const Vec3<T>& q,
                                 const NewtonStep<T>& n, const T& size, const T& bend,
                                 const Vec3<T>& scale, bool apex) {
  const T two(2.0);
  const InverseQuality<T> quality = inverse_quality(n, scale);
  const T w = apex ? q.z : T(1.0);
  const T eta = size + T(0x1p-43) * quality.reach;
  const T kappa = quality.contraction + T(0x1p7) * quality.reach * eta / w;
  const auto near = apex ? (absolute(q.x) < two * w) & (absolute(q.y) < two * w) & (w < two)
                         : largest_of(q) < two;
  const Vec3<T> f = absolute_of(n.f);
  const auto certified = if_in & quality.sound & near & (kappa < T(0.25)) & (w > T(8.0) * eta) &
                         (f.x < scale.x) & (f.y < scale.y) & (f.z < scale.z);
  return select(certified, two * (kappa * eta + bend) + T(0x1p-43) * quality.reach, T(HUGE_VAL));
}

/// Newton's method for x(q) = p by bent steps, where map(q, x, a, b, c) gives x and its three
/// derivatives.
/// Lanes that are done are frozen, so a pack gives the same bits as scalars one by one. A lane is
/// given up at a step out of [-2, 3], or past a pyramid's apex (`apex`): points of a sound cell
/// take none. scale: see inverse_quality. error: of the answer, in the maximum norm.
/// The certificate is error_of_step() of the last step.
template <class T, class Map>
INSITU_HD inline decltype(T(0.0) < T(0.0))
newton(const Map& map, const Vec3<T>& p, const Vec3<T>& scale, bool apex, Vec3<T>& q, T& error) {
  constexpr int most_iterations = 12;
  // A bent step's error is about bend^2 / step: at rounding, which near an apex is that of w. A
  // singular Jacobian makes a zero step, which proves nothing.
  const T lowest(-2.0), highest(3.0), small(1e-5), small_bend(3e-11), zero(0.0);
  auto converged = zero < zero, left = converged;
  NewtonStep<T> n;
  BentStep<T> bent;
  for (int i = 0; i < most_iterations; ++i) {
    Vec3<T> x, a, b, c;
    map(q, x, a, b, c);
    n = newton_step(a, b, c, p - x);
    bent = bent_step(map, q, n);
    const Vec3<T> next = q + bent.step;
    auto out = !((smaller(next.x, smaller(next.y, next.z)) > lowest) &
                 (larger(next.x, larger(next.y, next.z)) < highest));
    if (apex)
      out = out | !(next.z > zero);
    left = left | out;
    const T unit = apex ? q.z : T(1.0);
    converged =
        (!left) & (!n.singular) & (bent.size < small * unit) & (bent.bend < small_bend * unit);
    const auto done = converged | left;
    if (all_of(done))
      break;
    q = {select(done, q.x, next.x), select(done, q.y, next.y), select(done, q.z, next.z)};
  }
  error = error_of_step(converged, q, n, bent.size, bent.bend, scale, apex);
  q = {select(converged, q.x + bent.step.x, q.x), select(converged, q.y + bent.step.y, q.y),
       select(converged, q.z + bent.step.z, q.z)};
  return converged;
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_tetrahedron(const Vec3<T>* x, const Vec3<T>& p) {
  const T one(1.0);
  const Vec3<T> a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0], f = p - x[0];
  const NewtonStep<T> n = newton_step(a, b, c, f);
  // Once more with what is left, for slivers, where Cramer's rule loses digits.
  const Vec3<T> step = n.towards(f - (n.step.x * a + n.step.y * b + n.step.z * c));
  InverseMap<T> out;
  out.r = n.step + step;
  out.margin =
      smaller(smaller(out.r.x, out.r.y), smaller(out.r.z, one - out.r.x - out.r.y - out.r.z));
  out.converged = !n.singular;
  // Linear: kappa is the rounding of the inverse alone. Roundings of g are those of f and of three
  // products, the size of f. The margin's sum has three coordinates.
  const Vec3<T> scale = absolute_of(a) + absolute_of(b) + absolute_of(c) + absolute_of(f);
  const InverseQuality<T> quality = inverse_quality(n, scale);
  const T size = largest_of(n.step);
  const auto certified = quality.sound & (size < T(2.0));
  out.error = select(certified,
                     T(8.0) * quality.contraction * largest_of(step) + T(0x1p-41) * quality.reach,
                     T(HUGE_VAL));
  return out;
}

/// The trilinear map in monomials of r, s, t, relative to vertex 0: fewer operations an iteration
/// than shape functions, and no cancellation at large offsets.
template <class T>
struct TrilinearMap {
  Vec3<T> er, es, et, crs, crt, cst, crst;

  /// v: the place at q; a, b, c: its derivatives by r, s, t.
  INSITU_HD inline void operator()(const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                                   Vec3<T>& c) const {
    const Vec3<T> rs_t = crs + q.z * crst; // coefficient of r s
    a = er + q.y * rs_t + q.z * crt;
    b = es + q.x * rs_t + q.z * cst;
    c = et + q.x * (crt + q.y * crst) + q.y * cst;
    v = q.x * a + q.y * (es + q.z * cst) + q.z * et;
  }
  INSITU_HD inline Vec3<T> bend(const Vec3<T>& q, const Vec3<T>& d) const {
    const T rs = d.x * d.y;
    return rs * (crs + (q.z + d.z) * crst) + (d.x * d.z) * (crt + q.y * crst) +
           (d.y * d.z) * (cst + q.x * crst);
  }
};
/// Of a hexahedron or voxel.
template <class T>
INSITU_HD inline TrilinearMap<T> trilinear_map(Shape shape, const Vec3<T>* x) {
  const int swap = shape == Shape::voxel ? 1 : 0;
  const Vec3<T> x0 = x[0];
  const Vec3<T> e1 = x[1] - x0, e2 = x[2 + swap] - x0, e3 = x[3 - swap] - x0, e4 = x[4] - x0,
                e5 = x[5] - x0, e6 = x[6 + swap] - x0, e7 = x[7 - swap] - x0;
  return {
      e1, e3, e4, e2 - e1 - e3, e5 - e1 - e4, e7 - e3 - e4, e6 - e2 - (e5 - e1) - (e7 - e3) + e4};
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_hexahedron(Shape shape, const Vec3<T>* x, const Vec3<T>& p) {
  const TrilinearMap<T> map = trilinear_map(shape, x);
  const Vec3<T> scale = absolute_of(map.er) + absolute_of(map.es) + absolute_of(map.et) +
                        absolute_of(map.crs) + absolute_of(map.crt) + absolute_of(map.cst) +
                        absolute_of(map.crst);
  InverseMap<T> out;
  out.r = {T(0.5), T(0.5), T(0.5)};
  out.converged = newton(map, p - x[0], scale, false, out.r, out.error);
  const T one(1.0);
  const auto slack = [&](const T& u) INSITU_LAMBDA { return smaller(u, one - u); };
  out.margin = smaller(slack(out.r.x), smaller(slack(out.r.y), slack(out.r.z)));
  return out;
}

template <class T>
struct WedgeMap {
  Vec3<T> er, es, et, crt, cst;

  INSITU_HD inline void operator()(const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                                   Vec3<T>& c) const {
    a = er + q.z * crt;
    b = es + q.z * cst;
    c = et + q.x * crt + q.y * cst;
    v = q.x * a + q.y * b + q.z * et;
  }
  INSITU_HD inline Vec3<T> bend(const Vec3<T>&, const Vec3<T>& d) const {
    return (d.x * d.z) * crt + (d.y * d.z) * cst;
  }
};

template <class T>
INSITU_HD inline InverseMap<T> inverse_wedge(const Vec3<T>* x, const Vec3<T>& p) {
  const Vec3<T> x0 = x[0];
  const Vec3<T> e1 = x[1] - x0, e2 = x[2] - x0, e3 = x[3] - x0;
  const Vec3<T> crt = (x[4] - x0) - e1 - e3, cst = (x[5] - x0) - e2 - e3;
  const WedgeMap<T> map{e1, e2, e3, crt, cst};
  const Vec3<T> scale =
      absolute_of(e1) + absolute_of(e2) + absolute_of(e3) + absolute_of(crt) + absolute_of(cst);
  const T one(1.0);
  InverseMap<T> out;
  out.r = {T(1.0 / 3.0), T(1.0 / 3.0), T(0.5)};
  out.converged = newton(map, p - x0, scale, false, out.r, out.error);
  out.error = T(2.0) * out.error; // of 1 - r - s
  out.margin = smaller(smaller(out.r.x, out.r.y),
                       smaller(one - out.r.x - out.r.y, smaller(out.r.z, one - out.r.z)));
  return out;
}

/// See inverse_pyramid.
template <class T>
struct PyramidMap {
  Vec3<T> ea, eb, ec, ed;

  INSITU_HD inline static T over(const T& w) {
    const T tiny(1e-300);
    return T(1.0) / select(absolute(w) < tiny, tiny, w);
  }
  INSITU_HD inline void operator()(const Vec3<T>& q, Vec3<T>& v, Vec3<T>& a, Vec3<T>& b,
                                   Vec3<T>& c) const {
    const T w = over(q.z);
    const T r = q.x * w, s = q.y * w;
    a = eb + s * ed;
    b = ec + r * ed;
    c = ea - (r * s) * ed;
    v = q.x * eb + q.y * ec + q.z * ea + (q.x * s) * ed;
  }
  INSITU_HD inline Vec3<T> bend(const Vec3<T>& q, const Vec3<T>& d) const {
    const T w = over(q.z);
    const T u = d.x - q.x * w * d.z, v = d.y - q.y * w * d.z;
    return (u * v * w) * ed;
  }
};

/// The pyramid in u = (1-t) r, v = (1-t) s, w = 1-t about its apex: p - apex = w A + u B + v C +
/// (u v / w) D is homogeneous of degree one, so Newton works as well near the apex, where r and s
/// cease to exist, as anywhere else. At the apex itself r = s = 1/2.
template <class T>
INSITU_HD inline InverseMap<T> inverse_pyramid(const Vec3<T>* x, const Vec3<T>& p) {
  const T zero(0.0), one(1.0), tiny(1e-300);
  const Vec3<T> ea = x[0] - x[4], eb = x[1] - x[0], ec = x[3] - x[0];
  const Vec3<T> ed = (x[2] - x[0]) - eb - ec;
  const PyramidMap<T> map{ea, eb, ec, ed};
  const Vec3<T> scale = absolute_of(ea) + absolute_of(eb) + absolute_of(ec) + absolute_of(ed);
  Vec3<T> q{T(0.25), T(0.25), T(0.5)};
  const Vec3<T> f = p - x[4];
  InverseMap<T> out;
  out.converged = newton(map, f, scale, true, q, out.error);
  out.error = T(2.0) * out.error; // of w - u
  const auto apex = (f.x == zero) & (f.y == zero) & (f.z == zero);
  out.converged = out.converged | apex;
  out.error = select(apex, zero, out.error);
  q = {select(apex, zero, q.x), select(apex, zero, q.y), select(apex, zero, q.z)};
  const auto flat = absolute(q.z) < tiny;
  const T w = select(flat, one, q.z);
  out.r = {select(flat, T(0.5), q.x / w), select(flat, T(0.5), q.y / w), one - q.z};
  out.margin =
      smaller(smaller(q.x, q.z - q.x), smaller(smaller(q.y, q.z - q.y), smaller(q.z, one - q.z)));
  return out;
}

template <class T>
INSITU_HD inline InverseMap<T> inverse_map(Shape shape, const Vec3<T>* x, const Vec3<T>& p) {
  switch (shape) {
  case Shape::tetrahedron:
    return inverse_tetrahedron(x, p);
  case Shape::pyramid:
    return inverse_pyramid(x, p);
  case Shape::wedge:
    return inverse_wedge(x, p);
  default:
    return inverse_hexahedron(shape, x, p);
  }
}

// Point in cell for scalars and packs: contain_filter.h's proofs lane by lane, without branches on
// a lane. Included like shape_functions.inl.
//
// Parity of the crossings of the ray from the point along +x with the boundary. Signs are sign bits
// (`signs`), and a zero counts as positive: that moves a vertex by less than anything that was
// measured, and once the point is proven to be off the boundary and the ray to pass the edges, this
// changes nothing. The diagonals are the face's own in its cell's order, not the canonical ones:
// where the patch is in question, the corner tetrahedron's test makes up for either choice.

constexpr double contain_tiny = math::FilterLimits<double>::tiny;
constexpr double contain_limit = math::FilterLimits<double>::max_difference;

template <class T>
using LaneMask = decltype(T(0.0) < T(0.0));

/// The least and the greatest coordinates of some vertices relative to the point.
template <class T>
struct Extent {
  Vec3<T> low, high;
};

template <class T>
INSITU_INLINE Extent<T> extent(const Vec3<T>& a, const Vec3<T>& b) {
  return {{smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)},
          {larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)}};
}
template <class T>
INSITU_INLINE Extent<T> joined(const Extent<T>& a, const Extent<T>& b) {
  return {extent(a.low, b.low).low, extent(a.high, b.high).high};
}

template <class T>
struct ContainLanes {
  using Sign = decltype(signs(T(0.0)));

  Vec3<T> r[8]; // vertices relative to the point
  Extent<T> spoke[4];
  T minor[12];        // of the edges, seen along x
  Sign straddles[12]; // the edge's ends are above and below the ray
  Sign crosses[12];   // and the edge passes it on the side of +y
  T minor_bound, determinant_bound, patch_bound;
  Sign parity, undecided;
};

/// a x b's x: the turn of the vectors around the ray.
template <class T>
INSITU_INLINE T minor_of(const Vec3<T>& a, const Vec3<T>& b) {
  return neg_mul_add(a.z, b.y, a.y * b.z);
}

/// The pairs of vertices that faces share: 2 k, 2 k + 1 of hexahedra, voxels and a pyramid's base,
/// the upright edges of wedges.
template <Shape S>
INSITU_HD constexpr int spoke_count() {
  return S == Shape::wedge ? 3 : S == Shape::pyramid ? 2 : 4;
}
template <Shape S>
INSITU_HD constexpr int spoke_between(int a, int b) {
  const int low = a < b ? a : b, high = a < b ? b : a;
  if (S == Shape::wedge)
    return high == low + 3 ? low : -1;
  return (S != Shape::pyramid || high < 4) && low % 2 == 0 && high == low + 1 ? low / 2 : -1;
}

template <Shape S, int K, class T>
INSITU_INLINE void find_spoke(ContainLanes<T>& c) {
  if constexpr (S == Shape::wedge)
    c.spoke[K] = extent(c.r[K], c.r[K + 3]);
  else
    c.spoke[K] = extent(c.r[2 * K], c.r[2 * K + 1]);
}

template <Shape S, int F, class T>
INSITU_INLINE Extent<T> face_extent(const ContainLanes<T>& c) {
  constexpr Face face = face_table(S).faces[F];
  constexpr int i = face.vertices[0], j = face.vertices[1], k = face.vertices[2],
                l = face.vertices[3];
  if constexpr (face.vertex_count == 3) {
    return joined(extent(c.r[i], c.r[j]), Extent<T>{c.r[k], c.r[k]});
  } else {
    constexpr int first = spoke_between<S>(i, j), second = spoke_between<S>(k, l);
    constexpr int third = spoke_between<S>(j, k), fourth = spoke_between<S>(l, i);
    if constexpr (first >= 0 && second >= 0)
      return joined(c.spoke[first], c.spoke[second]);
    else if constexpr (third >= 0 && fourth >= 0)
      return joined(c.spoke[third], c.spoke[fourth]);
    else
      return joined(extent(c.r[i], c.r[j]), extent(c.r[k], c.r[l]));
  }
}

/// Whether the ray's line passes a segment on the side of +y, which needs the sign of `minor`.
template <class T>
struct SegmentSigns {
  typename ContainLanes<T>::Sign straddles, crosses;
};
template <class T>
INSITU_INLINE SegmentSigns<T> segment_signs(const Vec3<T>& a, const Vec3<T>& b, const T& minor) {
  const auto straddles = signs(a.z) ^ signs(b.z);
  return {straddles, and_not(signs(minor) ^ signs(b.z), straddles)};
}

template <Shape S, int E, class T>
INSITU_INLINE void find_edge(ContainLanes<T>& c) {
  constexpr Edge edge = face_table(S).edges[E];
  const Vec3<T>&a = c.r[edge.vertices[0]], &b = c.r[edge.vertices[1]];
  c.minor[E] = minor_of(a, b);
  const auto s = segment_signs(a, b, c.minor[E]);
  c.straddles[E] = s.straddles;
  c.crosses[E] = s.crosses;
  c.undecided = or_and(c.undecided, s.straddles, signs(absolute(c.minor[E]) - c.minor_bound));
}

/// sum + x * (the minor from side K's first vertex to its second).
template <Shape S, int F, int K, class T>
INSITU_INLINE T add_side(const ContainLanes<T>& c, const T& x, const T& sum) {
  constexpr FaceSide side = face_side(S, F, K);
  if constexpr (side.reversed)
    return neg_mul_add(x, c.minor[side.edge], sum);
  else
    return mul_add(x, c.minor[side.edge], sum);
}
/// The sign bit of that minor.
template <Shape S, int F, int K, class T>
INSITU_INLINE typename ContainLanes<T>::Sign side_turn(const ContainLanes<T>& c) {
  constexpr FaceSide side = face_side(S, F, K);
  if constexpr (side.reversed)
    return !signs(c.minor[side.edge]);
  else
    return signs(c.minor[side.edge]);
}

template <Shape S, int F, class T>
INSITU_INLINE T triangle_determinant(const ContainLanes<T>& c) {
  constexpr Face f = face_table(S).faces[F];
  const T sum = add_side<S, F, 1>(c, c.r[f.vertices[0]].x, T(0.0));
  return add_side<S, F, 0>(c, c.r[f.vertices[2]].x,
                           add_side<S, F, 2>(c, c.r[f.vertices[1]].x, sum));
}

template <Shape S, int F, class T>
INSITU_INLINE void triangle_crossings(ContainLanes<T>& c,
                                      const typename ContainLanes<T>::Sign& far) {
  constexpr int e0 = face_side(S, F, 0).edge, e1 = face_side(S, F, 1).edge,
                e2 = face_side(S, F, 2).edge;
  const T determinant = triangle_determinant<S, F>(c);
  const auto round = xor3(c.crosses[e0], c.crosses[e1], c.crosses[e2]);
  // A triangle around the ray turns one way; of its first two sides, one straddles the ray.
  const auto turn = choose(c.straddles[e0], side_turn<S, F, 0>(c), side_turn<S, F, 1>(c));
  c.parity = c.parity ^ and_not(far, and_not(signs(determinant) ^ turn, round));
  c.undecided = c.undecided | and_not(far, signs(absolute(determinant) - c.determinant_bound));
}

template <Shape S, int F, class T>
INSITU_INLINE void patch_crossings(ContainLanes<T>& lanes,
                                   const typename ContainLanes<T>::Sign& far) {
  constexpr Face f = face_table(S).faces[F];
  constexpr int s0 = face_side(S, F, 0).edge, s1 = face_side(S, F, 1).edge,
                s2 = face_side(S, F, 2).edge, s3 = face_side(S, F, 3).edge;
  ContainLanes<T>& l = lanes;
  const T zero(0.0), bound = l.determinant_bound;
  const Vec3<T>&r00 = l.r[f.vertices[0]], &r10 = l.r[f.vertices[1]];
  const Vec3<T>&r11 = l.r[f.vertices[2]], &r01 = l.r[f.vertices[3]];
  const T diagonal = minor_of(r00, r11), other = minor_of(r10, r01);
  // The signed volumes of contain_filter.h, a and c with their signs turned.
  const T d =
      add_side<S, F, 0>(l, r11.x, neg_mul_add(r10.x, diagonal, add_side<S, F, 1>(l, r00.x, zero)));
  const T b =
      mul_add(r01.x, diagonal, add_side<S, F, 3>(l, r11.x, add_side<S, F, 2>(l, r00.x, zero)));
  const T c = mul_add(r00.x, other, add_side<S, F, 0>(l, r01.x, add_side<S, F, 3>(l, r10.x, zero)));
  const T a =
      neg_mul_add(r11.x, other, add_side<S, F, 2>(l, r10.x, add_side<S, F, 1>(l, r01.x, zero)));

  // Of b, d, -a and -c: the greatest, and the least with its sign turned.
  const T high = larger(larger(b, d), -smaller(a, c));
  const T low = larger(larger(a, c), -smaller(b, d));
  const auto all = signs(T(-1.0));
  const auto in_tetrahedron = signs(low + bound) | signs(high + bound);
  const auto out_of_tetrahedron = signs(bound - high) & signs(bound - low);
  const T side = neg_mul_add(b, d, a * c);
  const T largest = larger(absolute(high), absolute(low));
  const auto side_undecided =
      signs(absolute(side) - mul_add(l.patch_bound, largest, T(contain_tiny)));

  const auto s = segment_signs(r00, r11, diagonal);
  const auto first = xor3(l.crosses[s0], l.crosses[s1], s.crosses);
  const auto second = xor3(l.crosses[s2], l.crosses[s3], s.crosses);
  const auto first_turn = choose(l.straddles[s0], side_turn<S, F, 0>(l), side_turn<S, F, 1>(l));
  const auto second_turn = choose(l.straddles[s3], side_turn<S, F, 3>(l), side_turn<S, F, 2>(l));
  const auto crossings =
      xor3(and_not(signs(d) ^ first_turn, first), and_not(signs(b) ^ second_turn, second),
           and_not(signs(side), in_tetrahedron));
  l.parity = l.parity ^ and_not(far, crossings);
  auto undecided = and_not(in_tetrahedron | out_of_tetrahedron, all);
  undecided = or_and(undecided, in_tetrahedron, side_undecided);
  undecided = or_and(undecided, s.straddles, signs(absolute(diagonal) - l.minor_bound));
  undecided = or_and(undecided, first, signs(absolute(d) - bound));
  undecided = or_and(undecided, second, signs(absolute(b) - bound));
  l.undecided = l.undecided | and_not(far, undecided);
}

template <Shape S, int F, class T>
INSITU_INLINE void cross_face(ContainLanes<T>& c) {
  constexpr bool quad = face_table(S).faces[F].vertex_count == 4;
  const T zero(0.0);
  const Extent<T> e = face_extent<S, F>(c);
  // Strictly in front: the ray crosses it as often as its line does. Strictly behind or beside:
  // never. Adding zero rids a minus zero of its sign.
  const auto front = signs(zero - e.low.x);
  const auto away = signs(
      smaller(smaller(e.high.x, smaller(e.high.y, -e.low.y)), smaller(e.high.z, -e.low.z)) + zero);
  auto round = xor3(c.crosses[face_side(S, F, 0).edge], c.crosses[face_side(S, F, 1).edge],
                    c.crosses[face_side(S, F, 2).edge]);
  if constexpr (quad)
    round = round ^ c.crosses[face_side(S, F, 3).edge];
  c.parity = c.parity ^ (front & round);
  const auto far = front | away;
  if (all_of(lane_mask(far)))
    return;
  if constexpr (quad)
    patch_crossings<S, F>(c, far);
  else
    triangle_crossings<S, F>(c, far);
}

template <class T>
INSITU_INLINE void set_bounds(ContainLanes<T>& c, const Extent<T>& all, T& largest) {
  const T x = larger(all.high.x, -all.low.x), y = larger(all.high.y, -all.low.y),
          z = larger(all.high.z, -all.low.z);
  largest = larger(x, larger(y, z));
  const T u(math::FilterLimits<double>::unit_roundoff), tiny(contain_tiny);
  c.minor_bound = mul_add(T(9.0) * u * y, z, tiny);
  c.determinant_bound = mul_add(T(48.0) * u * x, y * z, tiny);
  // math::bilinear_bound with |a|, |b|, |c|, |d| <= largest and bound <= largest, where it matters.
  c.patch_bound = T(9.0) * c.determinant_bound;
}

template <Shape S, class T, int... K, int... E, int... F>
INSITU_INLINE auto contain_all(ContainLanes<T>& c, std::integer_sequence<int, K...>,
                               std::integer_sequence<int, E...>, std::integer_sequence<int, F...>) {
  (find_spoke<S, K>(c), ...);
  Extent<T> all = c.spoke[0];
  ((all = K == 0 ? all : joined(all, c.spoke[K])), ...);
  if constexpr (S == Shape::pyramid)
    all = joined(all, Extent<T>{c.r[4], c.r[4]});
  T largest;
  set_bounds(c, all, largest);
  (find_edge<S, E>(c), ...);
  (cross_face<S, F>(c), ...);
  // Comparisons and minima may lose a NaN; sums keep it.
  T sum = c.r[0].x;
  for (int v = 1; v < face_table(S).vertex_count; ++v)
    sum = sum + c.r[v].x;
  ((sum = sum + c.minor[E]), ...);
  return (sum == sum) & !(largest > T(contain_limit));
}

/// A point is in a tetrahedron where the four faces' volumes have one sign, and out of it, volume
/// or not, where two have not.
template <class T, int... E>
INSITU_INLINE void contain_tetrahedron(ContainLanes<T>& c, LaneMask<T>& inside,
                                       LaneMask<T>& outside, std::integer_sequence<int, E...>) {
  constexpr Shape S = Shape::tetrahedron;
  T largest;
  set_bounds(c, joined(extent(c.r[0], c.r[1]), extent(c.r[2], c.r[3])), largest);
  ((c.minor[E] =
        minor_of(c.r[face_table(S).edges[E].vertices[0]], c.r[face_table(S).edges[E].vertices[1]])),
   ...);
  const T a = triangle_determinant<S, 0>(c), b = triangle_determinant<S, 1>(c),
          d = triangle_determinant<S, 2>(c), e = triangle_determinant<S, 3>(c);
  const T low = smaller(smaller(a, b), smaller(d, e)), high = larger(larger(a, b), larger(d, e));
  const T sum = (a + b) + (d + e), bound = c.determinant_bound;
  const auto sound = (sum == sum) & !(largest > T(contain_limit));
  inside = sound & ((low > bound) | (high < -bound));
  outside = sound & (low < -bound) & (high > bound);
}

template <Shape S, class T>
INSITU_INLINE void contain_shape(const Vec3<T>* x, const Vec3<T>& p, LaneMask<T>& inside,
                                 LaneMask<T>& outside) {
  constexpr FaceTable table = face_table(S);
  ContainLanes<T> c;
  for (int v = 0; v < table.vertex_count; ++v)
    c.r[v] = x[v] - p;
  constexpr std::make_integer_sequence<int, table.edge_count> edges;
  if constexpr (S == Shape::tetrahedron) {
    contain_tetrahedron(c, inside, outside, edges);
  } else {
    c.parity = c.undecided = signs(T(0.0));
    const auto sound = contain_all<S>(c, std::make_integer_sequence<int, spoke_count<S>()>(), edges,
                                      std::make_integer_sequence<int, table.face_count>());
    const auto decided = sound & !lane_mask(c.undecided);
    inside = decided & lane_mask(c.parity);
    outside = decided & !lane_mask(c.parity);
  }
}

/// Per lane: the point is proven strictly inside, proven strictly outside, or neither, in the sense
/// of contain_exact.h. x: the vertices in VTK's order. Right for any input, NaN and infinity
/// included (neither); decides all but a share of random points that is near rounding.
template <class T>
INSITU_HD inline void filter(Shape shape, const Vec3<T>* x, const Vec3<T>& p, LaneMask<T>& inside,
                             LaneMask<T>& outside) {
  switch (shape) {
  case Shape::tetrahedron:
    return contain_shape<Shape::tetrahedron>(x, p, inside, outside);
  case Shape::voxel:
    return contain_shape<Shape::voxel>(x, p, inside, outside);
  case Shape::hexahedron:
    return contain_shape<Shape::hexahedron>(x, p, inside, outside);
  case Shape::wedge:
    return contain_shape<Shape::wedge>(x, p, inside, outside);
  case Shape::pyramid:
    return contain_shape<Shape::pyramid>(x, p, inside, outside);
  default:
    inside = outside = T(0.0) < T(0.0);
  }
}

// Signs of the Jacobian's determinant of a cell's map, for scalars and packs. Included like
// shape_functions.inl, after contain_lanes.inl.
//
// The determinant is constant in a tetrahedron, bilinear in (r, s) in a pyramid (about its apex),
// linear in (r, s) and quadratic in t in a wedge, and quadratic in each of r, s, t in a hexahedron.
// Its Bernstein coefficients bound it, and those at corners are its values there (Johnen, Remacle
// and Geuzaine 2013, "Geometrical validity of curvilinear finite elements").

/// For signs, so products may be fused.
template <class T>
INSITU_INLINE T sign_dot(const Vec3<T>& a, const Vec3<T>& b) {
  return mul_add(a.z, b.z, mul_add(a.y, b.y, a.x * b.x));
}
template <class T>
INSITU_INLINE Vec3<T> sign_cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {neg_mul_add(a.z, b.y, a.y * b.z), neg_mul_add(a.x, b.z, a.z * b.x),
          neg_mul_add(a.y, b.x, a.x * b.y)};
}

/// a: the edges along r at (s, t) = (0, 0), (1, 0), (0, 1), (1, 1); b along s at (r, t), c along t
/// at (r, s) likewise.
template <class T>
struct HexahedronEdges {
  Vec3<T> a[4], b[4], c[4];
};
template <class T>
INSITU_INLINE HexahedronEdges<T> hexahedron_edges(const Vec3<T>* x, int swap) {
  // By i + 2 j + 4 k; hexahedra turn, voxels count.
  const Vec3<T> v[8] = {x[0], x[1], x[3 - swap], x[2 + swap], x[4], x[5], x[7 - swap], x[6 + swap]};
  HexahedronEdges<T> e;
  for (int k = 0; k < 4; ++k) {
    const int low = k & 1, high = k >> 1;
    e.a[k] = v[2 * low + 4 * high + 1] - v[2 * low + 4 * high];
    e.b[k] = v[low + 4 * high + 2] - v[low + 4 * high];
    e.c[k] = v[low + 2 * high + 4] - v[low + 2 * high];
  }
  return e;
}

/// value: 27 coefficients, those along r adjacent, then along s.
template <class T>
INSITU_INLINE void hexahedron_determinant(const HexahedronEdges<T>& e, T* value) {
  for (int i = 0; i < 27; ++i)
    value[i] = T(0.0);
  for (int bc = 0; bc < 16; ++bc) {
    const int bi = bc & 1, bk = bc >> 1 & 1, ci = bc >> 2 & 1, cj = bc >> 3;
    const Vec3<T> normal = sign_cross(e.b[bi + 2 * bk], e.c[ci + 2 * cj]);
    for (int a = 0; a < 4; ++a) {
      T& at = value[(bi + ci) + 3 * ((a & 1) + cj) + 9 * ((a >> 1) + bk)];
      at = at + sign_dot(e.a[a], normal);
    }
  }
  // r (1 - r) is half of the middle polynomial, 2 r (1 - r).
  for (int i = 0; i < 27; ++i)
    value[i] = value[i] * T((i % 3 == 1 ? 0.5 : 1.0) * (i / 3 % 3 == 1 ? 0.5 : 1.0) *
                            (i / 9 == 1 ? 0.5 : 1.0));
}

/// value[k]: three coefficients along t at vertex k of the triangle, between which the determinant
/// is linear. Positive where triangle 0 1 2 faces away from 3 4 5.
template <class T>
INSITU_INLINE void wedge_determinant(const Vec3<T>* x, T (*value)[3]) {
  const Vec3<T> a0 = x[1] - x[0], a1 = x[4] - x[3], b0 = x[2] - x[0], b1 = x[5] - x[3];
  const Vec3<T> low = sign_cross(b0, a0), high = sign_cross(b1, a1);
  const Vec3<T> middle = sign_cross(b1, a0) + sign_cross(b0, a1);
  for (int k = 0; k < 3; ++k) {
    const Vec3<T> c = x[k + 3] - x[k];
    value[k][0] = sign_dot(low, c);
    value[k][1] = T(0.5) * sign_dot(middle, c);
    value[k][2] = sign_dot(high, c);
  }
}

/// value[k]: the determinant at corner k of the base, between which it is bilinear.
template <class T>
INSITU_INLINE void pyramid_determinant(const Vec3<T>* x, T* value) {
  for (int k = 0; k < 4; ++k)
    value[k] = sign_dot(sign_cross(x[(k + 1) % 4] - x[k], x[(k + 3) % 4] - x[k]), x[4] - x[k]);
}

template <class T>
INSITU_INLINE T tetrahedron_determinant(const Vec3<T>* x) {
  return sign_dot(sign_cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
}

/// What rounding may make of a determinant that is zero. A triple product of edges errs by at most
/// 48 roundings of the volume of the cell's box (contain_filter.h), sums of them and subdivision by
/// less than 200.
template <class T>
INSITU_INLINE T determinant_tolerance(int vertices, const Vec3<T>* x) {
  Vec3<T> low = x[0], high = x[0];
  for (int v = 1; v < vertices; ++v) {
    low = {smaller(low.x, x[v].x), smaller(low.y, x[v].y), smaller(low.z, x[v].z)};
    high = {larger(high.x, x[v].x), larger(high.y, x[v].y), larger(high.z, x[v].z)};
  }
  const Vec3<T> size = high - low;
  return T(256 * 0x1p-53) * (size.x * (size.y * size.z));
}

/// Per lane: a corner's volume is positive, one is negative (neither if zero to rounding); two
/// vertices coincide; and the determinant is not proven to keep its sign throughout the cell.
template <class T>
struct JacobianSigns {
  LaneMask<T> positive, negative, coincident, unsure;
  T least, greatest; // of the coefficients

  INSITU_INLINE JacobianSigns() {
    positive = negative = coincident = unsure = T(0.0) < T(0.0);
    least = T(HUGE_VAL);
    greatest = T(-HUGE_VAL);
  }
  INSITU_INLINE void coefficient(const T& value) {
    least = smaller(least, value);
    greatest = larger(greatest, value);
  }
  /// A corner where edges of these squared lengths meet. Cells may be needles or sheets, so zero to
  /// rounding is meant against the edges.
  INSITU_INLINE void corner(const T& volume, const T& a, const T& b, const T& c) {
    const auto known = T(1e-28) * (a * (b * c)) < volume * volume;
    positive = positive | (known & (volume > T(0.0)));
    negative = negative | (known & (volume < T(0.0)));
  }
};

template <class T>
INSITU_INLINE T squared(const Vec3<T>& a) {
  return sign_dot(a, a);
}

template <class T>
INSITU_INLINE void add_signs(Shape shape, const Vec3<T>* x, JacobianSigns<T>& out) {
  if (shape == Shape::tetrahedron) {
    const T volume = tetrahedron_determinant(x);
    out.corner(volume, squared(x[1] - x[0]), squared(x[2] - x[0]), squared(x[3] - x[0]));
    out.coefficient(volume);
  } else if (shape == Shape::pyramid) {
    T value[4];
    pyramid_determinant(x, value);
    for (int k = 0; k < 4; ++k) {
      out.corner(value[k], squared(x[(k + 1) % 4] - x[k]), squared(x[(k + 3) % 4] - x[k]),
                 squared(x[4] - x[k]));
      out.coefficient(value[k]);
    }
  } else if (shape == Shape::wedge) {
    T value[3][3];
    wedge_determinant(x, value);
    const T a0 = squared(x[1] - x[0]), a1 = squared(x[4] - x[3]), b0 = squared(x[2] - x[0]),
            b1 = squared(x[5] - x[3]);
    for (int k = 0; k < 3; ++k) {
      const T c = squared(x[k + 3] - x[k]);
      out.corner(value[k][0], a0, b0, c);
      out.corner(value[k][2], a1, b1, c);
      for (int i = 0; i < 3; ++i)
        out.coefficient(value[k][i]);
    }
  } else {
    const HexahedronEdges<T> e = hexahedron_edges(x, shape == Shape::voxel ? 1 : 0);
    T value[27], a[4], b[4], c[4];
    hexahedron_determinant(e, value);
    for (int k = 0; k < 4; ++k) {
      a[k] = squared(e.a[k]);
      b[k] = squared(e.b[k]);
      c[k] = squared(e.c[k]);
    }
    for (int i = 0; i < 27; ++i)
      out.coefficient(value[i]);
    for (int k = 0; k < 8; ++k) {
      const int r = k & 1, s = k >> 1 & 1, t = k >> 2;
      out.corner(value[2 * r + 6 * s + 18 * t], a[s + 2 * t], b[r + 2 * t], c[r + 2 * s]);
    }
  }
}

/// Coordinates must be finite.
template <class T>
INSITU_HD inline JacobianSigns<T> jacobian_signs(Shape shape, const Vec3<T>* x) {
  JacobianSigns<T> out;
  add_signs(shape, x, out);
  const int vertices = vertex_count(shape);
  for (int v = 1; v < vertices; ++v)
    for (int w = 0; w < v; ++w)
      out.coincident =
          out.coincident | ((x[v].x == x[w].x) & (x[v].y == x[w].y) & (x[v].z == x[w].z));
  const T tolerance = determinant_tolerance(vertices, x);
  out.unsure = (out.least < -tolerance) & (out.greatest > tolerance);
  return out;
}

// Shape functions and their derivatives, in VTK's parametric coordinates and point order.
// Included into a namespace by cells/kernels/kernels.h (scalars, CUDA) and
// cells/kernels/kernels_simd.h (once per SIMD target); T is double, float or a SIMD pack. No
// includes, no guard.

/// n[0..vertex_count): weights of the vertices at r; they sum to 1.
template <class T>
INSITU_HD inline void shape_functions(Shape shape, const Vec3<T>& p, T* n) {
  const T one(1.0), r = p.x, s = p.y, t = p.z;
  switch (shape) {
  case Shape::tetrahedron:
    n[0] = one - r - s - t;
    n[1] = r;
    n[2] = s;
    n[3] = t;
    break;
  case Shape::pyramid: {
    const T w = one - t;
    n[0] = (one - r) * (one - s) * w;
    n[1] = r * (one - s) * w;
    n[2] = r * s * w;
    n[3] = (one - r) * s * w;
    n[4] = t;
    break;
  }
  case Shape::wedge: {
    const T q = one - r - s;
    n[0] = q * (one - t);
    n[1] = r * (one - t);
    n[2] = s * (one - t);
    n[3] = q * t;
    n[4] = r * t;
    n[5] = s * t;
    break;
  }
  case Shape::voxel:
  case Shape::hexahedron: {
    const int swap = shape == Shape::voxel ? 1 : 0; // voxels count j before turning
    const T rm = one - r, sm = one - s, tm = one - t;
    n[0] = rm * sm * tm;
    n[1] = r * sm * tm;
    n[2 + swap] = r * s * tm;
    n[3 - swap] = rm * s * tm;
    n[4] = rm * sm * t;
    n[5] = r * sm * t;
    n[6 + swap] = r * s * t;
    n[7 - swap] = rm * s * t;
    break;
  }
  case Shape::none:
    break;
  }
}

/// The weighted mean of the vertices' values, taken about vertex 0's: that of equal values is their
/// value to the bit, so that a step of a transfer function at a constant is not parted by rounding.
/// Values further apart than the largest number have none.
template <class T>
INSITU_HD inline T weighted_mean(int count, const T* weight, const T* values) {
  T sum = weight[1] * (values[1] - values[0]);
  for (int v = 2; v < count; ++v)
    sum = sum + weight[v] * (values[v] - values[0]);
  return values[0] + sum;
}

/// d[v]: derivatives of vertex v's weight by r, s, t.
template <class T>
INSITU_HD inline void shape_derivatives(Shape shape, const Vec3<T>& p, Vec3<T>* d) {
  const T zero(0.0), one(1.0), r = p.x, s = p.y, t = p.z;
  switch (shape) {
  case Shape::tetrahedron:
    d[0] = {-one, -one, -one};
    d[1] = {one, zero, zero};
    d[2] = {zero, one, zero};
    d[3] = {zero, zero, one};
    break;
  case Shape::pyramid: {
    const T rm = one - r, sm = one - s, w = one - t;
    d[0] = {-(sm * w), -(rm * w), -(rm * sm)};
    d[1] = {sm * w, -(r * w), -(r * sm)};
    d[2] = {s * w, r * w, -(r * s)};
    d[3] = {-(s * w), rm * w, -(rm * s)};
    d[4] = {zero, zero, one};
    break;
  }
  case Shape::wedge: {
    const T q = one - r - s, tm = one - t;
    d[0] = {-tm, -tm, -q};
    d[1] = {tm, zero, -r};
    d[2] = {zero, tm, -s};
    d[3] = {-t, -t, q};
    d[4] = {t, zero, r};
    d[5] = {zero, t, s};
    break;
  }
  case Shape::voxel:
  case Shape::hexahedron: {
    const int swap = shape == Shape::voxel ? 1 : 0;
    const T rm = one - r, sm = one - s, tm = one - t;
    d[0] = {-(sm * tm), -(rm * tm), -(rm * sm)};
    d[1] = {sm * tm, -(r * tm), -(r * sm)};
    d[2 + swap] = {s * tm, r * tm, -(r * s)};
    d[3 - swap] = {-(s * tm), rm * tm, -(rm * s)};
    d[4] = {-(sm * t), -(rm * t), rm * sm};
    d[5] = {sm * t, -(r * t), r * sm};
    d[6 + swap] = {s * t, r * t, r * s};
    d[7 - swap] = {-(s * t), rm * t, rm * s};
    break;
  }
  case Shape::none:
    break;
  }
}

/// The point at parametric coordinates r.
template <class T>
INSITU_HD inline Vec3<T> map_to_physical(Shape shape, const Vec3<T>* x, const Vec3<T>& r) {
  T n[8];
  shape_functions(shape, r, n);
  Vec3<T> p = n[0] * x[0];
  const int count = vertex_count(shape);
  for (int v = 1; v < count; ++v)
    p += n[v] * x[v];
  return p;
}

/// The columns dx/dr, dx/ds, dx/dt of the map's Jacobian at r.
template <class T>
INSITU_HD inline void jacobian(Shape shape, const Vec3<T>* x, const Vec3<T>& r, Vec3<T>* columns) {
  Vec3<T> d[8];
  shape_derivatives(shape, r, d);
  columns[0] = columns[1] = columns[2] = {T(0.0), T(0.0), T(0.0)};
  const int count = vertex_count(shape);
  for (int v = 1; v < count; ++v) { // relative to vertex 0: the derivatives sum to zero
    const Vec3<T> e = x[v] - x[0];
    columns[0] += d[v].x * e;
    columns[1] += d[v].y * e;
    columns[2] += d[v].z * e;
  }
}

/// The physical gradient at r of the field whose vertex values are f.
template <class T>
INSITU_HD inline Vec3<T> gradient(Shape shape, const Vec3<T>* x, const T* f, const Vec3<T>& r) {
  Vec3<T> d[8], j[3];
  shape_derivatives(shape, r, d);
  jacobian(shape, x, r, j);
  Vec3<T> g{T(0.0), T(0.0), T(0.0)}; // df/dr
  const int count = vertex_count(shape);
  for (int v = 1; v < count; ++v)
    g += (f[v] - f[0]) * d[v];
  // J^T grad = g, by Cramer's rule; the reciprocal basis of the columns.
  const Vec3<T> bc = cross(j[1], j[2]), ca = cross(j[2], j[0]), ab = cross(j[0], j[1]);
  const T det = dot(j[0], bc);
  const T inv = select(det == T(0.0), T(0.0), T(1.0) / select(det == T(0.0), T(1.0), det));
  return inv * (g.x * bc + g.y * ca + g.z * ab);
}

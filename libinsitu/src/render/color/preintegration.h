#pragma once

#include <algorithm>
#include <cstdint>

#include "core/counted_vector.h"
#include "render/color/transfer_function.h"

namespace insitu::render {

/// A transfer function integrated over values (Engel, Kraus, Ertl 2001, "High-quality
/// pre-integrated volume rendering using hardware-accelerated pixel shading", with their integral
/// functions in place of a table of two values): the field goes linearly from one value to another
/// along a stretch of ray, and all that lies between is seen, however thin. With the extinction t =
/// -ln(1 - opacity) / unit distance and T, K the integrals of t and t * colour over values, the
/// stretch's optical depth is exactly its length times (T(b) - T(a)) / (b - a), and its colour the
/// mean weighted by t, (K(b) - K(a)) / (T(b) - T(a)): exact for one colour; else the stretch's own
/// absorption between its colours is left out, as in the paper.
///
/// T and K are held at the ends of table intervals that break at every opacity point and at the
/// ends of the colours' range, and are cubic in between, so sudden steps of opacity stay where they
/// are.
class Preintegration {
public:
  /// step: the length of the stretches. Opacity 1 counts as an optical depth of 40 in a step
  /// and in a unit distance.
  Preintegration(const TransferFunction& function, double step, double unit_distance,
                 const core::CountedAllocator<char>& counted = {});

  /// The integrals up to a value: t, then t times red, green and blue.
  struct Integral {
    double of[4] = {0, 0, 0, 0};
  };
  /// A value with its integrals, which the stretches on either side of a sample share.
  struct Place {
    double value = 0;
    std::size_t part = 0;
    Integral sum;
  };
  /// Of a number. near: a place whose part is likely to be the value's, for time's sake.
  Place place(double value, const Place& near) const;

  /// Of a stretch between two values, which must be numbers.
  ColorSample operator()(const Place& a, const Place& b) const;
  ColorSample operator()(double a, double b) const { return (*this)(place(a, {}), place(b, {})); }

  /// Of the tables of a function of so many opacity points.
  static std::int64_t most_bytes(int opacity_points, Scale scale);
  std::int64_t bytes() const;

private:
  /// An end of a table interval: the integrals up to it, and their derivatives within the interval
  /// that begins here (`after`) and the one that ends here (`before`).
  struct Knot {
    Integral sum, after, before;
  };
  /// Between two values at which something breaks.
  struct Part {
    double value, scale, width; ///< its first; intervals per value; an interval's
    int first, count;
  };
  std::size_t part_of(double value, std::size_t likely) const;
  void add_up(double value, std::size_t part, Integral& sum) const;

  Classifier classifier_;
  static constexpr int most_parts_of_log = 300;
  static int knots_in(std::size_t breaks) { return std::max(16, 1024 / int(breaks)); }
  core::CountedVector<Part> parts_; ///< ascending; the last is all beyond the last break
  core::CountedVector<Knot> knots_;
  Integral below_;  ///< derivatives below the first break
  double exponent_; ///< optical depth of a step, for extinctions per unit distance
  double least_;
};

} // namespace insitu::render
